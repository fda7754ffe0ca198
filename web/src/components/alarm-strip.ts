/**
 * The alarm strip, which is always there: CPA alarms, or that there are none, or that none are
 * computed. The server computes them without the pilot; they flash red until acknowledged.
 */

import { css, html, nothing } from "lit";
import { customElement } from "lit/decorators.js";

import { cpaWatch } from "../domain/cpa-watch";
import { compareAlarms, MAX_NAMED_ALARMS } from "../domain/ranking";
import { formatDuration, formatMiles, shortName } from "../domain/units";
import type { Alarm } from "../protocol.gen";
import { store } from "../store";
import { shared } from "../style/shared";
import { shipBadge } from "./ship-badge";
import { StoreElement } from "./store-element";

/** Alarms shown one by one where there are more than `MAX_NAMED_ALARMS`; the list marks all. */
const N_NAMED_WHEN_MANY = 2;

@customElement("gh-alarm-strip")
export class AlarmStrip extends StoreElement {
  static override styles = [
    shared,
    css`
      :host {
        display: flex;
        align-items: center;
        justify-content: space-between;
        gap: 12px;
        min-height: 42px;
        padding: 3px 12px;
        background: var(--gh-panel);
        border-bottom: 1px solid var(--gh-line);
      }
      ul {
        display: flex;
        flex-wrap: wrap;
        gap: 6px;
        margin: 0;
        padding: 0;
        list-style: none;
      }
      .advisory,
      .inactive {
        flex: none;
        font-weight: 600;
        color: var(--gh-on-warn);
        background: var(--gh-warn);
        border-radius: 4px;
        padding: 3px 10px;
      }
      li {
        display: flex;
        align-items: center;
        gap: 8px;
        border-radius: 4px;
        border: 2px solid var(--gh-alarm);
        color: var(--gh-text);
        padding: 2px 3px 2px 10px;
        font-weight: 600;
      }
      li.unacknowledged {
        background: var(--gh-alarm);
        color: var(--gh-on-alarm);
        animation: flash 1s steps(2, jump-none) infinite;
      }
      @keyframes flash {
        to {
          border-color: var(--gh-panel);
        }
      }
      li.all {
        border: 0;
        padding: 0;
      }
      button {
        min-height: 28px;
      }
      li button {
        background: var(--gh-panel);
        color: var(--gh-text);
      }
      .alarm-text {
        background: none;
        border: 0;
        padding: 0;
        color: inherit;
      }
      .acknowledged,
      .view-only,
      .more {
        padding-right: 10px;
      }
    `,
  ];

  override render() {
    const alarms = [...store.alarms].sort(compareAlarms);
    const open = alarms.filter((a) => a.state === "unacknowledged");
    const shown = alarms.length > MAX_NAMED_ALARMS ? N_NAMED_WHEN_MANY : MAX_NAMED_ALARMS;
    const more = alarms.length - shown;
    const watch = cpaWatch(store.liveness, store.limits);
    return html`
      ${alarms.length ? nothing : html`<span class=${watch.active ? "muted" : "inactive"}>${watch.text}</span>`}
      <ul aria-label="CPA alarms">
        ${alarms.slice(0, shown).map((alarm) => this.item(alarm))}
        ${more > 0 ? html`<li class="more ${open.length > shown ? "unacknowledged" : "acknowledged"}">and ${more} more</li>` : nothing}
        ${
          open.length > 1 && !store.viewOnly
            ? html`<li class="all">
                <button @click=${() => open.forEach((a) => this.acknowledge(a))}>
                  Acknowledge all ${open.length}
                </button>
              </li>`
            : nothing
        }
      </ul>
      <span class="advisory">Advisory, not type-approved</span>
    `;
  }

  private item(alarm: Alarm) {
    return html`
      <li class="${alarm.state} ${store.viewOnly ? "view-only" : ""}" title=${alarm.cause}>
        ${store.colours.indexOf(alarm.target) === null ? nothing : shipBadge(alarm.target)}
        <button class="alarm-text number" @click=${() => store.select(alarm.target)}>
          CPA ${shortName(alarm.name)} ${formatMiles(alarm.dcpa_m)} NM in
          ${formatDuration(alarm.tcpa_s)}
        </button>
        ${
          alarm.state === "unacknowledged" && !store.viewOnly
            ? html`<button
                @click=${() => this.acknowledge(alarm)}
                aria-label="Acknowledge the alarm of ${alarm.name}"
              >
                Acknowledge
              </button>`
            : nothing
        }
      </li>
    `;
  }

  private acknowledge(alarm: Alarm): void {
    store.send({ type: "acknowledge", id: alarm.id });
  }
}
