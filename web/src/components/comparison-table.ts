/** Two pilots in the same encounter, side by side. */

import { css, html, nothing } from "lit";
import { customElement } from "lit/decorators.js";

import { degrees, formatAge, formatMiles, formatRudder, shortName } from "../domain/units";
import { compareVoyages, type VoyageSummary } from "../domain/voyage-summary";
import { store } from "../store";
import { shared } from "../style/shared";
import { StoreElement } from "./store-element";

@customElement("gh-comparison")
export class Comparison extends StoreElement {
  static override styles = [
    shared,
    css`
      :host {
        display: block;
        background: var(--gh-panel);
        padding: 8px 14px;
      }
      table {
        width: 100%;
        border-collapse: collapse;
        font-size: 12.5px;
        margin-top: 3px;
      }
      th,
      td {
        text-align: right;
        font-weight: 500;
        padding: 2px 0 2px 8px;
        vertical-align: top;
      }
      thead th {
        font-size: 11px;
        color: var(--gh-muted);
      }
      th:first-child {
        text-align: left;
        padding-left: 0;
      }
      .compared th:first-child {
        color: var(--gh-compare);
        font-weight: 700;
      }
      .shown th:first-child {
        font-weight: 700;
      }
    `,
  ];

  override render() {
    if (!store.session?.compare) return nothing;
    const summaries = compareVoyages(store.frames, store.compareFrames);
    return html`
      <h2>Two pilots, same encounter</h2>
      ${
        summaries
          ? html`<table class="number">
              <thead>
                <tr>
                  <th scope="col">Pilot</th>
                  <th scope="col">Rudder</th>
                  <th scope="col">Nearest so far [NM]</th>
                  <th scope="col">In domain</th>
                  <th scope="col">Turned</th>
                  <th scope="col">Reward</th>
                </tr>
              </thead>
              <tbody>
                ${row(summaries[0], "shown")} ${row(summaries[1], "compared")}
              </tbody>
            </table>`
          : html`<p class="muted">Waiting for ${store.session.compare}.</p>`
      }
    `;
  }
}

function row(summary: VoyageSummary, kind: string) {
  return html`<tr class=${kind}>
    <th scope="row">${summary.pilot}</th>
    <td>${summary.rudder_rad === null ? "–" : formatRudder(summary.rudder_rad)}</td>
    <td>
      ${summary.nearest_m === null ? "–" : `${formatMiles(summary.nearest_m)} ${shortName(summary.nearest!, 10)}`}
    </td>
    <td>${formatAge(summary.inDomain_s)}</td>
    <td>${Math.round(degrees(summary.turned_rad))}°</td>
    <td>${summary.reward === null ? "–" : summary.reward.toFixed(1).replace("-", "−")}</td>
  </tr>`;
}
