/** One sentence: what the pilot does, why, and what comes next. */

import { css, html, LitElement, nothing } from "lit";
import { customElement } from "lit/decorators.js";

import { split } from "../domain/name-split";
import { shipName } from "../domain/units";
import { store, Watch } from "../store";
import { shared } from "../style/shared";
import { colourOf } from "./ship-badge";

@customElement("gh-sentence")
export class SentencePanel extends LitElement {
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
        color: var(--gh-soft);
      }
      .ship {
        font-weight: 600;
        border-bottom: 3px solid var(--ship);
        cursor: pointer;
        white-space: nowrap;
      }
      .ship.lit {
        background: color-mix(in srgb, var(--ship) 25%, var(--gh-panel));
      }
    `,
  ];

  constructor() {
    super();
    new Watch(this, store);
  }

  override render() {
    const sentence = store.now?.sentence;
    const { level } = store.settings.all;
    if (!store.frame) return nothing;
    return html`
      ${
        sentence
          ? html`
              <div class=${level > 1 ? "small" : ""}>
                <p class="what">${this.told(sentence.what)}</p>
                <p class="why">${this.told(sentence.why)}</p>
                ${sentence.next ? html`<p class="next">${this.told(sentence.next)}</p>` : nothing}
              </div>
            `
          : html`<p class="soft">This pilot gives no reasons.</p>`
      }
    `;
  }

  /** The words, with every ship's name in her colour; pointing at it lights her up. */
  private told(words: string) {
    const names = new Map(store.frame!.targets.map((t) => [t.name, t.id]));
    return split(words, [...names.keys()]).map((part) => {
      const id = names.get(part);
      if (id === undefined) return part;
      return html`<span
        class="ship ${id === store.lit ? "lit" : ""}"
        style="--ship: ${colourOf(id) ?? "var(--gh-other)"}"
        @mouseenter=${() => store.hover(id)}
        @mouseleave=${() => store.hover(null)}
        @click=${() => store.select(id)}
        >${shipName(part)}</span
      >`;
    });
  }
}
