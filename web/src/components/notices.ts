/** Plain lines from the server, one under the other; they go by themselves. */

import { css, html, LitElement } from "lit";
import { customElement } from "lit/decorators.js";

import { store, StoreController } from "../store";
import { shared } from "../style/shared";

@customElement("gh-notices")
export class Notices extends LitElement {
  static override styles = [
    shared,
    css`
      :host {
        position: fixed;
        left: 12px;
        bottom: 60px;
        display: grid;
        gap: 6px;
        max-width: min(560px, 50vw);
        z-index: 5;
      }
      div {
        display: flex;
        gap: 12px;
        align-items: center;
        justify-content: space-between;
        padding: 6px 8px 6px 12px;
        border-radius: 4px;
        border: 1px solid var(--gh-soft);
        background: var(--gh-panel);
      }
      .failure {
        background: var(--gh-warn);
        color: var(--gh-on-warn);
      }
    `,
  ];

  constructor() {
    super();
    new StoreController(this, store);
  }

  override render() {
    return store.notices.map(
      (notice) => html`
        <div class=${notice.failure ? "failure" : ""}>
          <span>${notice.text}</span>
          <button @click=${() => store.dismiss(notice.id)}>Close</button>
        </div>
      `,
    );
  }
}
