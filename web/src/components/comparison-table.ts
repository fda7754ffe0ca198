/** Two pilots in the same encounter, side by side. */

import { css, html, nothing } from "lit";
import { customElement } from "lit/decorators.js";

import { compareVoyages, type VoyageSummary } from "../domain/voyage-summary";
import { formatAge, degrees, formatMiles, formatRudder, shortName } from "../domain/units";
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
      .other th:first-child {
        color: var(--gh-compare);
        font-weight: 700;
      }
      .mine th:first-child {
        font-weight: 700;
      }
    `,
  ];

  override render() {
    if (!store.session?.compare) return nothing;
    const both = compareVoyages(store.frames, store.compareFrames);
    return html`
      <h2>Two pilots, same encounter</h2>
      ${
        both
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
                ${row(both[0], "mine")} ${row(both[1], "other")}
              </tbody>
            </table>`
          : html`<p class="muted">Waiting for ${store.session.compare}.</p>`
      }
    `;
  }
}

function row(told: VoyageSummary, kind: string) {
  return html`<tr class=${kind}>
    <th scope="row">${told.pilot}</th>
    <td>${told.rudder_rad === null ? "–" : formatRudder(told.rudder_rad)}</td>
    <td>
      ${told.nearest_m === null ? "–" : `${formatMiles(told.nearest_m)} ${shortName(told.nearest!, 10)}`}
    </td>
    <td>${formatAge(told.inDomain_s)}</td>
    <td>${Math.round(degrees(told.turned_rad))}°</td>
    <td>${told.reward === null ? "–" : told.reward.toFixed(1).replace("-", "−")}</td>
  </tr>`;
}
