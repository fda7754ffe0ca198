/** The top bar: menu, session, liveness, time, level of detail and palette. */

import "@oicl/openbridge-webcomponents/dist/icons/icon-menu-iec.js";
import "@oicl/openbridge-webcomponents/dist/icons/icon-palette-day.js";
import "@oicl/openbridge-webcomponents/dist/icons/icon-palette-dusk.js";
import "@oicl/openbridge-webcomponents/dist/icons/icon-palette-night.js";
import { css, html, nothing } from "lit";
import { customElement } from "lit/decorators.js";

import { type Palette, PALETTES } from "../domain/colours";
import { formatTime } from "../domain/units";
import type { DetailLevel } from "../settings";
import { store } from "../store";
import { shared } from "../style/shared";
import { StoreElement } from "./store-element";

const LEVELS: [DetailLevel, string, string][] = [
  [1, "Basic", "The rudder order and the ships that matter"],
  [2, "Why", "Also the value of each rudder angle and each ship's share"],
  [3, "All", "Also all values over time"],
];

const PALETTE_ICONS: Record<Palette, unknown> = {
  day: html`<obi-palette-day></obi-palette-day>`,
  dusk: html`<obi-palette-dusk></obi-palette-dusk>`,
  night: html`<obi-palette-night></obi-palette-night>`,
};

const MODES = { simulated: "Simulated", recorded: "Recorded", live: "Live", replay: "Replay" };

export const VIEW_ONLY =
  "View only: the session, its time and its alarms can be changed by an owner.";

@customElement("gh-top-bar")
export class TopBar extends StoreElement {
  static override styles = [
    shared,
    css`
      :host {
        display: flex;
        align-items: center;
        gap: 12px;
        height: 48px;
        padding: 0 12px;
        background: var(--gh-panel);
        border-bottom: 1px solid var(--gh-line);
        min-width: 0;
      }
      .name {
        font-weight: 700;
        font-size: 15px;
        letter-spacing: 0.01em;
      }
      .title {
        min-width: 0;
        flex: 1 1 0;
        line-height: 1.2;
      }
      .title div {
        overflow: hidden;
        text-overflow: ellipsis;
        white-space: nowrap;
      }
      .preparing {
        font-weight: 600;
      }
      .state {
        font-weight: 600;
        padding: 3px 10px;
        border-radius: 999px;
        border: 1px solid var(--gh-line);
        white-space: nowrap;
      }
      .state[data-state="stale"],
      .state[data-state="waiting"] {
        background: var(--gh-warn);
        color: var(--gh-on-warn);
        border-color: transparent;
      }
      .state[data-state="live"],
      .state[data-state="playing"] {
        background: var(--gh-accent);
        color: var(--gh-on-accent);
        border-color: transparent;
      }
      .view-only {
        font-weight: 600;
        padding: 3px 10px;
        border-radius: 4px;
        border: 1px solid var(--gh-text);
        white-space: nowrap;
      }
      .time {
        font-size: 15px;
        font-weight: 600;
      }
      .button-group button {
        padding: 0 9px;
        display: grid;
        place-items: center;
      }
      obi-menu-iec {
        display: block;
        width: 24px;
        height: 24px;
      }
      .button-group obi-palette-day,
      .button-group obi-palette-dusk,
      .button-group obi-palette-night {
        display: block;
        width: 20px;
        height: 20px;
      }
      .menu {
        display: flex;
        align-items: center;
        gap: 6px;
        padding: 0 10px 0 6px;
        font-weight: 600;
      }
      @media (max-width: 1100px) {
        .name {
          display: none;
        }
        :host {
          gap: 8px;
        }
      }
    `,
  ];

  override render() {
    const { session, frame, liveness } = store;
    const { palette, level } = store.settings.values;
    return html`
      <button class="menu" aria-haspopup="dialog" @click=${this.menu}>
        <obi-menu-iec></obi-menu-iec> Menu
      </button>
      <span class="name">Glasshelm</span>
      <div class="title">
        <div><strong>${session?.title ?? "No session"}</strong></div>
        ${
          store.preparing
            ? html`<div class="preparing" role="status">Preparing ${store.preparing} …</div>`
            : html`<div class="muted">
                ${session ? `${MODES[session.mode]} · pilot ${session.pilot}` : ""}
              </div>`
        }
      </div>
      <span class="state" data-state=${liveness.state} role="status">${liveness.text}</span>
      ${store.viewOnly ? html`<span class="view-only" title=${VIEW_ONLY}>View only</span>` : nothing}
      <span class="number time" aria-label="Time">
        ${frame ? formatTime(frame.time_s, frame.time_utc) : "–"}
      </span>
      <span class="button-group" role="group" aria-label="Detail">
        ${LEVELS.map(
          ([value, label, title]) => html`
            <button
              title=${title}
              aria-pressed=${level === value}
              @click=${() => store.settings.set({ level: value })}
            >
              ${label}
            </button>
          `,
        )}
      </span>
      <span class="button-group" role="group" aria-label="Palette">
        ${PALETTES.map(
          (value) => html`
            <button
              title=${`${value} palette`}
              aria-label=${`${value} palette`}
              aria-pressed=${palette === value}
              @click=${() => store.settings.set({ palette: value })}
            >
              ${PALETTE_ICONS[value]}
            </button>
          `,
        )}
      </span>
    `;
  }

  private readonly menu = (): void => {
    this.dispatchEvent(new CustomEvent("menu", { bubbles: true, composed: true }));
  };
}
