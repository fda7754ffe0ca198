/** "What if": the questions about the selected ship and own rudder, and the answer in words. */

import { css, html, nothing } from "lit";
import { customElement } from "lit/decorators.js";

import { formatDuration, degrees, shortName } from "../domain/units";
import { store } from "../store";
import { shared } from "../style/shared";
import { StoreElement } from "./store-element";
import type { WhatIf } from "../protocol.gen";

/** The rudder that is asked about, or the limit of own ship's where that is less [deg]. */
const RUDDER_DEG = 5;
const OF_SHIP: [WhatIf["change"], string, string][] = [
  ["deleted", "Not there", "What if she were not there?"],
  ["blind", "Not seen", "What if the pilot did not see her?"],
  ["kept", "Kept course", "What if she kept her course and speed?"],
];

@customElement("gh-what-if")
export class WhatIfPanel extends StoreElement {
  static override styles = [
    shared,
    css`
      :host {
        display: block;
        background: var(--gh-panel);
        padding: 6px 14px;
      }
      .ask {
        display: flex;
        flex-wrap: wrap;
        gap: 4px 10px;
        align-items: center;
      }
      .ask button {
        min-height: 28px;
        padding: 0 8px;
        font-size: 12px;
      }
      .ask .muted {
        font-size: 12px;
      }
      p {
        margin: 6px 0 2px;
        padding-left: 9px;
        border-left: 3px dashed var(--gh-what-if);
        text-wrap: pretty;
      }
      .end {
        display: flex;
        justify-content: space-between;
        align-items: center;
        font-size: 11px;
      }
    `,
  ];

  override render() {
    const frame = store.frame;
    if (!frame) return nothing;
    const ship = store.target(store.selected);
    const most = Math.min(RUDDER_DEG, degrees(frame.ship.rudder_limit_rad));
    return html`
      <div class="ask">
        <h2>What if</h2>
        ${
          ship
            ? html`<span class="button-group" role="group" aria-label=${`What if ${ship.name}`}>
                ${OF_SHIP.map(([change, words, title]) =>
                  this.button(words, title, () => store.askWhatIf(change, { ship: ship.id })),
                )}
              </span>`
            : nothing
        }
        <span class="button-group" role="group" aria-label="What if own rudder">
          ${[-most, most].map((deg) => {
            const words = `${deg < 0 ? "P" : "S"} ${Math.abs(Number(deg.toFixed(1)))}°`;
            const title = `What if the rudder went to ${words} now, for a minute?`;
            return this.button(words, title, () => store.askWhatIf("rudder", { degrees: deg }));
          })}
        </span>
        <span class="muted">
          ${store.awaitingWhatIf ? "Sailing both futures …" : ship ? shortName(ship.name, 16) : "Select a ship to ask about her"}
        </span>
      </div>
      ${this.answer()}
    `;
  }

  private answer() {
    const told = store.whatIf;
    if (!told) return nothing;
    return html`
      <p>${told.sentence}</p>
      <div class="end muted">
        <span
          >Simulated from ${formatDuration(told.time_s)} on, half an hour; other ships do not
          react.</span
        >
        <button @click=${() => store.dismissWhatIf()}>Dismiss</button>
      </div>
    `;
  }

  private button(words: string, title: string, ask: () => void) {
    return html`<button
      title=${title}
      aria-label=${title}
      ?disabled=${store.awaitingWhatIf}
      @click=${ask}
    >
      ${words}
    </button>`;
  }
}
