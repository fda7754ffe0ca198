/** What lies outside the pilot's training envelope, where its advice is less reliable. */

import { css, html, nothing } from "lit";
import { customElement } from "lit/decorators.js";

import { store } from "../store";
import { shared } from "../style/shared";
import { StoreElement } from "./store-element";

@customElement("gh-envelope-warning")
export class EnvelopeWarning extends StoreElement {
  static override styles = [
    shared,
    css`
      p {
        margin: 0;
        padding: 5px 14px;
        background: var(--gh-warn);
        color: var(--gh-on-warn);
        text-wrap: pretty;
      }
    `,
  ];

  override render() {
    const outside = store.frame?.outside_training ?? [];
    if (!outside.length) return nothing;
    const more = outside.length - 1;
    const text =
      store.settings.values.level < 3 && more
        ? html`${outside[0]} <span title=${outside.join("\n")}>and ${more} more</span>`
        : outside.join(" · ");
    return html`<p><strong>Outside the pilot's training</strong>: ${text}</p>`;
  }
}
