/** The explanation: the value of each rudder angle, each ship's share, and all values over time. */

import { css, html, nothing } from "lit";
import { customElement } from "lit/decorators.js";

import { criticDanger } from "../domain/ranking";
import {
  cachedTable,
  prioritySeries,
  rudderShares,
  shipSeries,
  sweepRelativeToMidships,
} from "../domain/series";
import { degrees } from "../domain/units";
import { planColours, type PlanColours } from "../plan/plan-colours";
import type { Frame, Target } from "../protocol.gen";
import { store } from "../store";
import { shared } from "../style/shared";
import "./alternatives";
import "./line-plot";
import type { PlotLine, PlotSpec } from "./line-plot";
import { shipBadge } from "./ship-badge";
import { StoreElement } from "./store-element";
import { seekTo } from "./transport";

const WAYPOINT = "waypoint";
const SHIPS = "ships";
const TOTAL = "total";

interface PlotCard {
  title: string;
  hint: string;
  /** The hint in full, where it is too long for the header. */
  details?: string;
  spec: PlotSpec;
  overTime: boolean;
}

@customElement("gh-explanation")
export class ExplanationPanel extends StoreElement {
  static override styles = [
    shared,
    css`
      :host {
        display: grid;
        container-type: inline-size;
      }
      .cards {
        display: grid;
        grid-template-columns: 1fr 1fr;
        grid-auto-rows: 1fr;
        gap: 1px;
        background: var(--gh-panel);
      }
      @container (min-width: 600px) {
        .cards.many {
          grid-template-columns: 1fr 1fr 1fr;
        }
      }
      article {
        box-shadow: 0 0 0 1px var(--gh-line);
        display: grid;
        grid-template-rows: auto auto minmax(120px, 1fr);
        background: var(--gh-panel);
        padding: 7px 4px 2px 8px;
        min-width: 0;
      }
      article.table {
        grid-template-rows: auto 1fr;
      }
      header {
        padding: 0 4px;
        white-space: nowrap;
        overflow: hidden;
        text-overflow: ellipsis;
      }
      header h2 {
        display: inline;
      }
      header span {
        font-size: 11px;
      }
      ul {
        display: flex;
        flex-wrap: nowrap;
        overflow: hidden;
        gap: 2px 5px;
        margin: 3px 0 0;
        padding: 0 4px;
        list-style: none;
        font-size: 11px;
        height: 18px;
      }
      li {
        display: flex;
        align-items: center;
        gap: 4px;
        white-space: nowrap;
        cursor: default;
      }
      li.highlighted {
        font-weight: 700;
      }
      li .badge {
        width: 15px;
        height: 15px;
        font-size: 10px;
      }
      i {
        width: 12px;
        border-top: 2px solid;
      }
      i.dashed {
        height: 2px;
        border: 0;
        background: repeating-linear-gradient(90deg, currentColor 0 3px, transparent 3px 4.5px);
      }
      p {
        margin: 0;
        padding: 6px 4px;
      }
      .none {
        grid-column: 1 / -1;
        background: var(--gh-panel);
        padding: 10px 14px;
      }
    `,
  ];

  override render() {
    const frame = store.frame;
    const { level, palette } = store.settings.values;
    if (!frame) return nothing;
    const colours = planColours(palette);
    const ids = store.colouredShips;
    const cards = [this.sweep(frame, ids, colours), this.rudderShares(frame, ids, colours)];
    if (level > 2)
      cards.push(
        this.ships("Attention", "Eq. 23", ids, colours, (t) => t.attention, 1, true),
        this.ships("Intention", "Eq. 24", ids, colours, (t) => t.intention, 0.02),
        this.ships(
          "Danger",
          "0 = distant ship",
          ids,
          colours,
          (t) => positive(criticDanger(t)),
          store.dangerScale,
          true,
        ),
        this.priorities(frame, colours),
      );
    const shown = cards.filter((card) => card !== null);
    const compares = !!frame.alternatives;
    if (!shown.length && !compares)
      return html`<p class="none muted">
        This pilot has no critic, so there are no values to show.
      </p>`;
    return html`<div class="cards ${shown.length + Number(compares) > 2 ? "many" : ""}">
      ${compares ? this.alternatives() : nothing} ${shown.map((card) => this.card(card, colours))}
    </div>`;
  }

  private alternatives() {
    return html`<article class="table">
      <header><h2>Why not another course?</h2></header>
      <gh-alternatives></gh-alternatives>
    </article>`;
  }

  private card(card: PlotCard, colours: PlanColours) {
    return html`
      <article>
        <header title=${card.details ?? card.hint}>
          <h2>${card.title}</h2>
          <span class="muted">${card.hint}</span>
        </header>
        <ul>
          ${card.spec.lines.map((line) => this.legend(line))}
        </ul>
        <gh-plot
          .spec=${card.spec}
          .colours=${colours}
          .highlighted=${store.highlighted}
          .name=${`${card.title}: ${card.details ?? card.hint}`}
          @line-hover=${(e: CustomEvent<string | null>) => store.hover(isShip(e.detail) ? e.detail : null)}
          @x-click=${card.overTime ? this.seek : nothing}
        ></gh-plot>
      </article>
    `;
  }

  private legend(line: PlotLine) {
    if (!isShip(line.id))
      return html`<li>
        <i class=${line.dash ? "dashed" : ""} style="color: ${line.colour}"></i>${line.label}
      </li>`;
    return html`<li
      class=${line.id === store.highlighted ? "highlighted" : ""}
      title=${line.label}
      @mouseenter=${() => store.hover(line.id)}
      @mouseleave=${() => store.hover(null)}
    >
      ${shipBadge(line.id)}
    </li>`;
  }

  private readonly seek = (event: CustomEvent<number>): void => {
    seekTo(Math.round((event.detail * 60) / 5) * 5);
  };

  /** A line for each ship, in its colour. */
  private lines(ids: readonly string[], colours: PlanColours): PlotLine[] {
    return ids.map((id) => ({
      id,
      label: store.target(id)?.name ?? id,
      colour: colours.ships[store.colours.indexOf(id)!] ?? colours.other,
    }));
  }

  private sweep(frame: Frame, ids: readonly string[], colours: PlanColours): PlotCard | null {
    const table = sweepRelativeToMidships(frame, ids);
    if (!table) return null;
    const limit = degrees(frame.ship.rudder_limit_rad);
    const decided = frame.decision?.rudder_rad;
    const shown = new Set(table.ships.map((ship) => ship.id));
    return {
      title: sweepTitle(decided),
      hint: "0 = midships",
      details: "value of each rudder angle relative to midships",
      overTime: false,
      spec: {
        lines: [
          { id: TOTAL, label: "total", colour: colours.text, width: 2.4 },
          { id: WAYPOINT, label: "waypoint", colour: colours.muted, dash: [5, 3] },
          ...this.lines(
            ids.filter((id) => shown.has(id)),
            colours,
          ),
        ],
        data: [table.rudder_deg, table.total, table.waypoint, ...table.ships.map((s) => s.values)],
        formatX: (deg) => (Math.abs(deg) < 0.05 ? "0" : `${deg < 0 ? "P" : "S"} ${Math.abs(deg)}°`),
        xRange: [-limit, limit],
        xTicks: [-1, -0.5, 0, 0.5, 1].map((share) => Number((share * limit).toFixed(1))),
        minY: 0.2,
        marks: decided === undefined ? [] : [{ at: degrees(decided), colour: colours.path }],
      },
    };
  }

  /** The shares of the rudder angle, which add up to it. */
  private rudderShares(
    frame: Frame,
    ids: readonly string[],
    colours: PlanColours,
  ): PlotCard | null {
    if (!hasValue((f) => f.decision?.base_rad)) return null;
    const shown = ids.filter((id) => shipHasValue(id, (t) => t.shapley_rad));
    return {
      title: "Rudder shares",
      hint: "° to starboard",
      details: "each ship's share of the rudder angle, in ° to starboard",
      overTime: true,
      spec: {
        lines: [
          { id: WAYPOINT, label: "no other ships", colour: colours.muted, width: 2, dash: [5, 3] },
          ...this.lines(shown, colours),
        ],
        data: cachedTable(store.frames, `rudder shares ${shown.join(" ")}`, () =>
          rudderShares(store.frames, shown),
        ),
        ...this.time(frame, colours),
        minY: 1,
      },
    };
  }

  private priorities(frame: Frame, colours: PlanColours): PlotCard | null {
    if (!frame.priority) return null;
    return {
      title: "Priorities",
      hint: "Eq. 22",
      details: "gain over midships, Eq. 22",
      overTime: true,
      spec: {
        lines: [
          { id: WAYPOINT, label: "waypoint", colour: colours.muted, width: 2, dash: [5, 3] },
          { id: SHIPS, label: "ships", colour: colours.text, width: 2.2 },
        ],
        data: cachedTable(store.frames, "priorities", () => prioritySeries(store.frames)),
        ...this.time(frame, colours),
        minY: 0.05,
      },
    };
  }

  private ships(
    title: string,
    hint: string,
    ids: readonly string[],
    colours: PlanColours,
    value: (target: Target) => number | null | undefined,
    minY: number,
    fromZero = false,
  ): PlotCard | null {
    const shown = ids.filter((id) => store.target(id) && shipHasValue(id, value));
    if (!shown.length) return null;
    return {
      title,
      hint,
      overTime: true,
      spec: {
        lines: this.lines(shown, colours),
        data: cachedTable(store.frames, `${title} ${shown.join(" ")}`, () =>
          shipSeries(store.frames, shown, value),
        ),
        ...this.time(store.frame!, colours),
        minY,
        fromZero,
      },
    };
  }

  /** The time axis from the first frame held to a little after the present, which is marked. */
  private time(frame: Frame, colours: PlanColours): Pick<PlotSpec, "formatX" | "marks" | "xRange"> {
    const first = (store.frames[0]?.time_s ?? 0) / 60;
    const now = frame.time_s / 60;
    return {
      formatX: (minute) => `${Number(minute.toFixed(1))} min`,
      xRange: [first, Math.max(now * 1.02, first + 2)],
      marks: [{ at: now, colour: colours.path }],
    };
  }
}

/** Whether any frame of the present pilot has the value: its line is then drawn, with gaps. */
function hasValue(value: (frame: Frame) => number | null | undefined): boolean {
  const pilot = store.frame?.pilot;
  return store.frames.some((f) => f.pilot === pilot && value(f) != null);
}

function shipHasValue(id: string, value: (target: Target) => number | null | undefined): boolean {
  return hasValue((f) => {
    const target = f.targets.find((t) => t.id === id);
    return target && value(target);
  });
}

/** The question that the curve answers. */
function sweepTitle(decided: number | undefined): string {
  if (decided === undefined || Math.abs(degrees(decided)) < 0.1) return "Why not turn?";
  return decided > 0 ? "Why not port?" : "Why not starboard?";
}

const positive = (value: number | null): number | null =>
  value === null ? null : Math.max(0, value);
const isShip = (id: string | null): id is string =>
  id !== null && id !== WAYPOINT && id !== SHIPS && id !== TOTAL;
