/** The sentence: what the pilot does, why, and what comes next. */

import { css, html, nothing } from "lit";
import { customElement } from "lit/decorators.js";

import { splitAtNames } from "../domain/name-split";
import { shortName } from "../domain/units";
import { store } from "../store";
import { shared } from "../style/shared";
import { badgeColour } from "./ship-badge";
import { StoreElement } from "./store-element";

@customElement("gh-sentence")
export class SentencePanel extends StoreElement {
  static override styles = [
    shared,
    css`
      :host {
        display: block;
        padding: 8px 14px 10px;
        background: var(--gh-panel);
      }
      p {
        margin: 0;
        text-wrap: pretty;
      }
      .what {
        font-size: 15px;
        font-weight: 600;
      }
      .why {
        margin-top: 4px;
      }
      .small .what {
        font-size: 14px;
      }
      .small p {
        font-size: 12.5px;
        line-height: 1.42;
      }
      .next {
        margin-top: 4px;
        color: var(--gh-muted);
      }
      .ship {
        font-weight: 600;
        border-bottom: 3px solid var(--ship);
        cursor: pointer;
        white-space: nowrap;
      }
      .ship.highlighted {
        background: color-mix(in srgb, var(--ship) 25%, var(--gh-panel));
      }
    `,
  ];

  override render() {
    const sentence = store.current?.sentence;
    const { level } = store.settings.values;
    if (!store.frame) return nothing;
    return html`
      ${
        sentence
          ? html`
              <div class=${level > 1 ? "small" : ""}>
                <p class="what">${this.withShipNames(sentence.what)}</p>
                <p class="why">${this.withShipNames(sentence.why)}</p>
                ${sentence.next ? html`<p class="next">${this.withShipNames(sentence.next)}</p>` : nothing}
              </div>
            `
          : html`<p class="muted">This pilot gives no explanation.</p>`
      }
    `;
  }

  /** The text with each ship's name in its colour; pointing at a name highlights the ship. */
  private withShipNames(text: string) {
    const names = new Map(store.frame!.targets.map((t) => [t.name, t.id]));
    return splitAtNames(text, [...names.keys()]).map((part) => {
      const id = names.get(part);
      if (id === undefined) return part;
      return html`<span
        class="ship ${id === store.highlighted ? "highlighted" : ""}"
        style="--ship: ${badgeColour(id) ?? "var(--gh-other)"}"
        @mouseenter=${() => store.hover(id)}
        @mouseleave=${() => store.hover(null)}
        @click=${() => store.select(id)}
        >${shortName(part)}</span
      >`;
    });
  }
}
