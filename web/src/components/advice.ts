/** The decision: commanded rudder against the actual one, who steers, how old it is. */

import { css, html, nothing, svg } from "lit";
import { customElement } from "lit/decorators.js";

import { isHeadingKnown } from "../domain/own-motion";
import {
  formatAge,
  formatCourse,
  degrees,
  formatRateOfTurn,
  formatRudder,
  rudderOrder,
  formatKnots,
} from "../domain/units";
import { store } from "../store";
import { shared } from "../style/shared";
import { StoreElement } from "./store-element";
import type { Banded, Frame } from "../protocol.gen";
import { bandBracket, bandStyle, bandText } from "./band-bracket";

const MARGIN = 16;
/** Height of the scale, and where its bar begins [px]. */
const HEIGHT = 82;
const BAR = 44;

@customElement("gh-advice")
export class Advice extends StoreElement {
  static override styles = [
    shared,
    bandStyle,
    css`
      :host {
        display: block;
        padding: 10px 14px 8px;
        background: var(--gh-panel);
      }
      header {
        display: flex;
        justify-content: space-between;
        align-items: baseline;
      }
      .mode {
        font-size: 11px;
        font-weight: 600;
      }
      .order {
        display: flex;
        align-items: baseline;
        gap: 10px;
        margin: 2px 0 0;
      }
      .side {
        font-size: 24px;
        font-weight: 600;
      }
      .angle {
        font-size: 34px;
        font-weight: 700;
        line-height: 1.1;
      }
      .stale .side,
      .stale .angle {
        text-decoration: line-through;
        color: var(--gh-muted);
      }
      svg {
        display: block;
        width: 100%;
        height: 82px;
      }
      .value-curve {
        fill: var(--gh-track);
        stroke: var(--gh-ring-text);
        stroke-width: 1;
      }
      dl {
        display: flex;
        flex-wrap: wrap;
        justify-content: space-between;
        gap: 2px 8px;
        margin: 4px 0 0;
      }
      dt {
        font-size: 11px;
        color: var(--gh-muted);
      }
      dd {
        margin: 0;
        font-weight: 600;
        font-size: 14px;
      }
      text {
        font-size: 11px;
        fill: var(--gh-muted);
      }
      .line {
        stroke: var(--gh-ring-text);
      }
      .fill {
        fill: var(--gh-ring-text);
      }
    `,
  ];

  private readonly sizes = new ResizeObserver(() => this.requestUpdate());

  override connectedCallback(): void {
    super.connectedCallback();
    this.sizes.observe(this);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.sizes.disconnect();
  }

  override render() {
    const frame = store.frame;
    if (!frame)
      return html`<h2>Rudder advice</h2>
        <p class="muted">${store.liveness.text}</p>`;
    const stale = store.liveness.state === "stale";
    const decision = frame.decision ?? null;
    const ground = !isHeadingKnown(frame);
    const words = decision ? rudderOrder(decision.rudder_rad) : null;
    const band = stale ? null : store.band;
    return html`
      <header>
        <h2>Rudder ${decision?.applied === false ? "advice" : "order"}</h2>
        <span class="mode muted">${this.mode(frame, stale)}</span>
      </header>
      <div class=${stale ? "order stale" : "order"} role="status" aria-label="Rudder advice">
        ${
          words
            ? html`<span class="side">${words.side}</span
                ><span class="angle number">${words.angle}</span>`
            : html`<span class="side muted">No advice</span>`
        }
      </div>
      ${gauge(frame, store.compareFrames.at(-1) ?? null, band, Math.max(200, this.clientWidth - 28))}
      ${bandText(band, stale ? null : store.lastBand, store.settings.values.level)}
      <dl class="number">
        <div>
          <dt>Rudder</dt>
          <dd>
            ${frame.own.rudder_rad == null ? "no sensor" : formatRudder(frame.own.rudder_rad)}
          </dd>
        </div>
        <div>
          <dt>${ground ? "COG" : "Heading"}</dt>
          <dd>${formatCourse(frame.own.heading_rad)}</dd>
        </div>
        <div>
          <dt>${ground ? "SOG" : "Speed"}</dt>
          <dd>${formatKnots(frame.own.speed_m_s)} kn</dd>
        </div>
        <div>
          <dt>Rate of turn</dt>
          <dd>${formatRateOfTurn(frame.own.rate_of_turn_rad_s)}</dd>
        </div>
      </dl>
    `;
  }

  private mode(frame: Frame, stale: boolean): string {
    const guards = frame.guard?.steers === true;
    const advises = guards ? "guard advises" : "advises only";
    const who =
      frame.decision?.applied === false ? advises : `${guards ? "guard" : "pilot"} steers`;
    if (store.session?.mode === "replay") return guards ? "recorded, guard's" : "recorded decision";
    const old = store.dataAge_s;
    return stale && old !== null ? `${formatAge(old)} old` : who;
  }
}

/**
 * A horizontal scale to the rudder limit: triangle = commanded, bar = actual, and behind them
 * a hill, as high as each rudder is worth to the critic. A bracket holds the certified band.
 */
function gauge(frame: Frame, compare: Frame | null, band: Banded | null, width: number) {
  const limit = Math.max(frame.ship.rudder_limit_rad, 0.01);
  const half = width / 2 - MARGIN;
  const x = (rad: number): number => width / 2 + Math.max(-1, Math.min(1, rad / limit)) * half;
  const most = Math.round(degrees(limit));
  const step = most > 12 ? 5 : 1;
  const reach = Math.floor(most / step);
  const marks = Array.from({ length: 2 * reach + 1 }, (_, k) => (k - reach) * step);
  const rad = (deg: number): number => (deg / most) * limit;
  const [actual, order] = [frame.own.rudder_rad, frame.decision?.rudder_rad];
  const other = compare?.decision?.rudder_rad;
  return html`
    <svg
      viewBox="0 0 ${width} ${HEIGHT}"
      height=${HEIGHT}
      role="img"
      aria-label="Rudder scale, and the worth of each rudder"
    >
      ${hill(frame, x)}
      <rect x=${x(-limit)} y=${BAR} width=${2 * half} height="12" rx="2" fill="var(--gh-track)" />
      ${
        actual == null
          ? nothing
          : svg`
        <rect x=${Math.min(x(0), x(actual))} y=${BAR} width=${Math.abs(x(actual) - x(0))} height="12"
          class="fill" />
        <rect x=${x(actual) - 1.5} y=${BAR - 3} width="3" height="18" fill="var(--gh-text)" />`
      }
      ${marks.map(
        (deg) => svg`
        <line x1=${x(rad(deg))} x2=${x(rad(deg))} y1=${BAR + 14} y2=${BAR + (deg % 5 ? 18 : 22)} class="line" />
        ${
          deg && Math.abs(deg) !== most
            ? nothing
            : svg`
          <text x=${x(rad(deg))} y=${BAR + 33} text-anchor="middle">
            ${deg === 0 ? "0" : `${deg < 0 ? "P" : "S"} ${Math.abs(deg)}°`}</text>`
        }`,
      )}
      ${bandBracket(band, x, BAR)}
      ${
        other == null
          ? nothing
          : svg`
        <path d="M${x(other)} ${BAR} l-7 -12 h14 z" fill="var(--gh-panel)" stroke="var(--gh-compare)"
          stroke-width="2" />`
      }
      ${
        order == null
          ? nothing
          : svg`
        <path class="order-mark" d="M${x(order)} ${BAR} l-9 -16 h18 z" fill="var(--gh-accent)" stroke="var(--gh-text)" />`
      }
    </svg>
  `;
}

/** The worth of each rudder as a hill: its top is the best, its foot the worst of the range. */
function hill(frame: Frame, x: (rad: number) => number) {
  const sweep = frame.sweep;
  if (!sweep) return nothing;
  const total = sweep.waypoint.map((w, k) => w + (sweep.collision[k] ?? 0));
  const [low, high] = [Math.min(...total), Math.max(...total)];
  const up = (v: number): number =>
    BAR - 1 - (high > low ? (v - low) / (high - low) : 0) * (BAR - 4);
  const edge = total.map((v, k) => `${x(sweep.rudder_rad[k]!).toFixed(1)} ${up(v).toFixed(1)}`);
  const first = x(sweep.rudder_rad[0]!).toFixed(1);
  const last = x(sweep.rudder_rad.at(-1)!).toFixed(1);
  return svg`<path class="value-curve" d="M${first} ${BAR} L${edge.join(" L")} L${last} ${BAR} Z">
    <title>Worth of each rudder to the critic</title></path>`;
}
