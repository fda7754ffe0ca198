/** What-if questions about the selected ship and own rudder, and the answer. */

import { css, html, nothing } from "lit";
import { customElement } from "lit/decorators.js";

import { degrees, formatDuration, shortName } from "../domain/units";
import type { AskWhatIf } from "../protocol.gen";
import { store } from "../store";
import { shared } from "../style/shared";
import { StoreElement } from "./store-element";

/** The rudder angle of the questions, or own ship's rudder limit where that is less. */
const RUDDER_DEG = 5;
const SHIP_QUESTIONS: [AskWhatIf["change"], string, string][] = [
  ["delete", "Not there", "What if this ship were not there?"],
  ["hide", "Not seen", "What if the pilot did not see this ship?"],
  ["keep_course", "Steady course", "What if this ship kept its course and speed?"],
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
    const angle = Math.min(RUDDER_DEG, degrees(frame.ship.rudder_limit_rad));
    return html`
      <div class="ask">
        <h2>What if</h2>
        ${
          ship
            ? html`<span class="button-group" role="group" aria-label=${`What if ${ship.name}`}>
                ${SHIP_QUESTIONS.map(([change, label, title]) =>
                  this.button(label, title, () => store.askWhatIf(change, { ship: ship.id })),
                )}
              </span>`
            : nothing
        }
        <span class="button-group" role="group" aria-label="What if own rudder">
          ${[-angle, angle].map((deg) => {
            const label = `${deg < 0 ? "P" : "S"} ${Math.abs(Number(deg.toFixed(1)))}°`;
            const title = `What if the rudder went to ${label} now, for a minute?`;
            return this.button(label, title, () => store.askWhatIf("rudder", { rudder_deg: deg }));
          })}
        </span>
        <span class="muted">
          ${store.awaitingWhatIf ? "Simulating …" : ship ? shortName(ship.name, 16) : "Select a ship to ask about it"}
        </span>
      </div>
      ${this.answer()}
    `;
  }

  private answer() {
    const answer = store.whatIf;
    if (!answer) return nothing;
    return html`
      <p>${answer.summary}</p>
      <div class="end muted">
        <span
          >Simulated for 30 min from ${formatDuration(answer.time_s)}; other ships do not
          react.</span
        >
        <button @click=${() => store.dismissWhatIf()}>Dismiss</button>
      </div>
    `;
  }

  private button(label: string, title: string, ask: () => void) {
    return html`<button
      title=${title}
      aria-label=${title}
      ?disabled=${store.awaitingWhatIf}
      @click=${ask}
    >
      ${label}
    </button>`;
  }
}
