/** The list of ships: danger, attention, intention, CPA, encounter and age of each. */

import { html, nothing } from "lit";
import { customElement, state } from "lit/decorators.js";

import { N_SHIP_COLOURS } from "../domain/colours";
import { criticDanger, largestIntention, type RankedTarget, roundScale } from "../domain/ranking";
import {
  formatAge,
  formatCourse,
  formatDuration,
  formatKnots,
  formatMiles,
  formatRelativeBearing,
  formatValue,
  shortName,
} from "../domain/units";
import type { EncounterStatus } from "../protocol.gen";
import { store } from "../store";
import { shared } from "../style/shared";
import { badgeColour, shipBadge } from "./ship-badge";
import { StoreElement } from "./store-element";
import { listStyle } from "./list-style";

/** So many rows are visible on every screen. */
const MIN_VISIBLE_ROWS = 4;
/** The age of an older report is marked. */
const OLD_S = 60;

const ENCOUNTERS: Record<EncounterStatus["type"], string> = {
  "head-on": "Head-on",
  crossing: "Crossing",
  overtaking: "Overtaking",
  overtaken: "Overtaken",
  none: "–",
};

@customElement("gh-target-list")
export class TargetList extends StoreElement {
  static override styles = [shared, listStyle];

  @state() private showAll = false;

  override render() {
    const frame = store.frame;
    const { level } = store.settings.values;
    const rows = store.rows;
    const shown = this.showAll
      ? rows
      : rows.filter((row) => store.colours.indexOf(row.target.id) !== null);
    this.style.setProperty("--rows", String(Math.min(shown.length, MIN_VISIBLE_ROWS)));
    const scale = {
      danger: store.dangerScale,
      intention: frame ? roundScale(largestIntention(frame), 0.05) : 1,
    };
    const critic = rows.some((r) => criticDanger(r.target) !== null);
    const attentive = rows.some((r) => r.target.attention != null);
    return html`
      <header>
        <h2>Ships <span class="count">${rows.length}</span></h2>
        ${
          rows.length > N_SHIP_COLOURS
            ? html`<button class="toggle" aria-expanded=${this.showAll} @click=${this.toggle}>
                ${this.showAll ? "Fewer" : `All ${rows.length}`}
              </button>`
            : nothing
        }
      </header>
      <div class="scroll" tabindex="0" role="region" aria-label="List of ships">
        <table>
          <caption class="visually-hidden">
            Ships, those under alarm first, then
            ${rows.some((r) => r.target.intention != null) ? "the largest intention" : "the most urgent"}
          </caption>
          <thead>
            <tr>
              <th scope="col">Ship</th>
              ${critic ? html`<th scope="col" class="bar" title="How much lower the critic values the ship than a distant one (Q far − Q); 0 is no danger">Danger <span class="scale">0–${scale.danger}</span></th>` : nothing}
              ${attentive && level > 1 ? html`<th scope="col" class="bar narrow" title="Share of the pilot's attention (Eq. 23)">Attention</th>` : nothing}
              ${attentive ? html`<th scope="col" class="bar" title="What the rudder does for this ship, weighted by attention (Eq. 24)">Intention <span class="scale">±${scale.intention}</span></th>` : nothing}
              <th scope="col" class="right">CPA <span class="scale">NM</span></th>
              <th scope="col" class="right">TCPA</th>
              <th scope="col">Encounter</th>
              ${level > 1 ? html`<th scope="col" class="right c-range">Range</th>` : nothing}
              ${
                level > 2
                  ? html` <th scope="col" class="right c-bearing">Bearing</th>
                      <th scope="col" class="right c-course">Course</th>
                      <th scope="col" class="right c-course">kn</th>`
                  : nothing
              }
              <th scope="col" class="right">Age</th>
            </tr>
          </thead>
          <tbody>
            ${shown.map((row) => this.row(row, scale, critic, attentive, level))}
          </tbody>
        </table>
        ${rows.length || !frame ? nothing : html`<p class="none">No other ships.</p>`}
      </div>
    `;
  }

  private readonly toggle = (): void => {
    this.showAll = !this.showAll;
  };

  private row(
    row: RankedTarget,
    scale: { danger: number; intention: number },
    critic: boolean,
    attentive: boolean,
    level: number,
  ) {
    const { target, alarm } = row;
    const colour = badgeColour(target.id) ?? "var(--gh-other)";
    const opening = target.tcpa_s <= 0;
    const old = (target.age_s ?? 0) > OLD_S;
    return html`
      <tr
        style="--ship: ${colour}"
        data-id=${target.id}
        class=${[
          target.id === store.selected ? "selected" : "",
          target.id === store.hovered ? "hovered" : "",
          alarm ? `alarm ${alarm.state}` : "",
          target.lost ? "lost" : "",
        ].join(" ")}
        @mouseenter=${() => store.hover(target.id)}
        @mouseleave=${() => store.hover(null)}
        @click=${() => store.select(target.id)}
      >
        <th scope="row">
          <button
            class="ship"
            aria-pressed=${target.id === store.selected}
            @click=${(e: Event) => {
              e.stopPropagation();
              store.select(target.id);
            }}
            @focus=${() => store.hover(target.id)}
            @blur=${() => store.hover(null)}
          >
            ${shipBadge(target.id)}
            <span class="name" title=${target.name}>${shortName(target.name)}</span>
          </button>
        </th>
        ${critic ? html`<td>${dangerBar(criticDanger(target), scale.danger)}</td>` : nothing}
        ${attentive && level > 1 ? html`<td>${shareBar(target.attention)}</td>` : nothing}
        ${attentive ? html`<td>${signedBar(target.intention, scale.intention)}</td>` : nothing}
        <td class="right number ${alarm ? "in-alarm" : ""}">${formatMiles(target.dcpa_m)}</td>
        <td class="right number ${alarm ? "in-alarm" : ""} ${opening ? "muted" : ""}">
          ${opening ? "past" : formatDuration(target.tcpa_s)}
        </td>
        <td class="encounter">${encounterCell(store.encounter(target.id), level)}</td>
        ${level > 1 ? html`<td class="right number c-range">${formatMiles(target.range_m)}</td>` : nothing}
        ${
          level > 2
            ? html` <td class="right number c-bearing">
                  ${formatRelativeBearing(target.bearing_rad)}
                </td>
                <td class="right number c-course">${formatCourse(target.course_rad)}</td>
                <td class="right number c-course">${formatKnots(target.speed_m_s)}</td>`
            : nothing
        }
        <td class="right number age ${old ? "old" : ""}">
          ${target.lost ? html`<strong>lost</strong> ` : nothing}${target.age_s == null ? "–" : formatAge(target.age_s)}
        </td>
      </tr>
    `;
  }
}

function encounterCell(encounter: EncounterStatus | null, level: number) {
  if (!encounter || encounter.type === "none") return html`<span class="muted">–</span>`;
  const role = { "give-way": "give way", "stand-on": "stand on", none: "" }[encounter.role];
  const rule = encounter.rule ? `R${encounter.rule}` : "";
  if (level === 1)
    return html`<span title="${ENCOUNTERS[encounter.type]}, ${role}, Rule ${encounter.rule}"
      >${ENCOUNTERS[encounter.type]}<br /><span class="muted">${role}</span></span
    >`;
  return html`${ENCOUNTERS[encounter.type]} <span class="muted">${rule}<br />${role}</span>`;
}

/** A bar from zero; values below zero are no danger. */
function dangerBar(value: number | null, scale: number) {
  if (value === null) return html`<span class="muted">not used</span>`;
  const share = Math.max(0, Math.min(1, value / scale));
  return html`<span class="meter"><i style="width: ${share * 100}%"></i></span
    ><span class="value number">${Math.max(0, value).toFixed(value < 9.95 ? 2 : 1)}</span>`;
}

function shareBar(share: number | null | undefined) {
  if (share == null) return html`<span class="muted">–</span>`;
  return html`<span class="meter"><i style="width: ${share * 100}%"></i></span
    ><span class="value number">${Math.round(share * 100)}%</span>`;
}

/** A bar from the middle: to the right the rudder helps the ship, to the left it hurts. */
function signedBar(value: number | null | undefined, scale: number) {
  if (value == null) return html`<span class="muted">–</span>`;
  const share = Math.min(1, Math.abs(value) / scale) / 2;
  const left = value < 0 ? 0.5 - share : 0.5;
  return html`<span class="meter signed ${value < 0 ? "minus" : ""}"
      ><i style="left: ${left * 100}%; width: ${share * 100}%"></i></span
    ><span class="value number">${formatValue(value)}</span>`;
}
