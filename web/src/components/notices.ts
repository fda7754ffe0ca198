/** Notices and failures, which disappear by themselves. */

import { css, html } from "lit";
import { customElement } from "lit/decorators.js";

import { store } from "../store";
import { shared } from "../style/shared";
import { StoreElement } from "./store-element";

@customElement("gh-notices")
export class Notices extends StoreElement {
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
        border: 1px solid var(--gh-muted);
        background: var(--gh-panel);
      }
      .failure {
        background: var(--gh-warn);
        color: var(--gh-on-warn);
      }
    `,
  ];

  override render() {
    return store.notices.map(
      (notice) => html`
        <div class=${notice.failure ? "failure" : ""}>
          <span>${notice.text}</span>
          <button @click=${() => store.dismissNotice(notice.id)}>Close</button>
        </div>
      `,
    );
  }
}
