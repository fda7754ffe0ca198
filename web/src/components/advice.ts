/** The rudder order or advice: the commanded and the actual rudder, and who steers. */

import { css, html, nothing, svg } from "lit";
import { customElement } from "lit/decorators.js";

import { isHeadingKnown } from "../domain/own-motion";
import {
  degrees,
  formatAge,
  formatCourse,
  formatKnots,
  formatRateOfTurn,
  formatRudder,
  rudderOrder,
} from "../domain/units";
import type { BandMessage, Frame } from "../protocol.gen";
import { store } from "../store";
import { shared } from "../style/shared";
import { bandBracket, bandStyle, bandText } from "./band-bracket";
import { StoreElement } from "./store-element";

const MARGIN = 16;
/** Height of the scale, and the top of its bar [px]. */
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
    const headingKnown = isHeadingKnown(frame);
    const order = decision ? rudderOrder(decision.rudder_rad) : null;
    const band = stale ? null : store.band;
    return html`
      <header>
        <h2>Rudder ${decision?.applied === false ? "advice" : "order"}</h2>
        <span class="mode muted">${this.mode(frame, stale)}</span>
      </header>
      <div class=${stale ? "order stale" : "order"} role="status" aria-label="Rudder advice">
        ${
          order
            ? html`<span class="side">${order.side}</span
                ><span class="angle number">${order.angle}</span>`
            : html`<span class="side muted">No advice</span>`
        }
      </div>
      ${rudderScale(frame, store.compareFrames.at(-1) ?? null, band, Math.max(200, this.clientWidth - 28))}
      ${bandText(band, stale ? null : store.lastBand, store.settings.values.level)}
      <dl class="number">
        <div>
          <dt>Rudder</dt>
          <dd>
            ${frame.own.rudder_rad == null ? "no sensor" : formatRudder(frame.own.rudder_rad)}
          </dd>
        </div>
        <div>
          <dt>${headingKnown ? "Heading" : "COG"}</dt>
          <dd>${formatCourse(frame.own.heading_rad)}</dd>
        </div>
        <div>
          <dt>${headingKnown ? "Speed" : "SOG"}</dt>
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
    const guardSteers = frame.guard?.steers === true;
    const adviser = guardSteers ? "guard advises" : "advises only";
    const who =
      frame.decision?.applied === false ? adviser : `${guardSteers ? "guard" : "pilot"} steers`;
    if (store.session?.mode === "replay")
      return guardSteers ? "recorded, by guard" : "recorded decision";
    const age_s = store.dataAge_s;
    return stale && age_s !== null ? `${formatAge(age_s)} old` : who;
  }
}

/**
 * A scale to the rudder limit. The triangle is the commanded rudder, the bar the actual one, the
 * curve the critic's value of each rudder angle, the bracket the certified band.
 */
function rudderScale(frame: Frame, compare: Frame | null, band: BandMessage | null, width: number) {
  const limit = Math.max(frame.ship.rudder_limit_rad, 0.01);
  const half = width / 2 - MARGIN;
  const x = (rad: number): number => width / 2 + Math.max(-1, Math.min(1, rad / limit)) * half;
  const limit_deg = Math.round(degrees(limit));
  const step = limit_deg > 12 ? 5 : 1;
  const perSide = Math.floor(limit_deg / step);
  const marks = Array.from({ length: 2 * perSide + 1 }, (_, k) => (k - perSide) * step);
  const rad = (deg: number): number => (deg / limit_deg) * limit;
  const [actual, order] = [frame.own.rudder_rad, frame.decision?.rudder_rad];
  const compared = compare?.decision?.rudder_rad;
  return html`
    <svg
      viewBox="0 0 ${width} ${HEIGHT}"
      height=${HEIGHT}
      role="img"
      aria-label="Rudder scale and the value of each rudder angle"
    >
      ${valueCurve(frame, x)}
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
          deg && Math.abs(deg) !== limit_deg
            ? nothing
            : svg`
          <text x=${x(rad(deg))} y=${BAR + 33} text-anchor="middle">
            ${deg === 0 ? "0" : `${deg < 0 ? "P" : "S"} ${Math.abs(deg)}°`}</text>`
        }`,
      )}
      ${bandBracket(band, x, BAR)}
      ${
        compared == null
          ? nothing
          : svg`
        <path d="M${x(compared)} ${BAR} l-7 -12 h14 z" fill="var(--gh-panel)" stroke="var(--gh-compare)"
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

/** The critic's value of each rudder angle, from the worst to the best of the range. */
function valueCurve(frame: Frame, x: (rad: number) => number) {
  const sweep = frame.sweep;
  if (!sweep) return nothing;
  const total = sweep.waypoint.map((w, k) => w + (sweep.collision[k] ?? 0));
  const [low, high] = [Math.min(...total), Math.max(...total)];
  const y = (v: number): number =>
    BAR - 1 - (high > low ? (v - low) / (high - low) : 0) * (BAR - 4);
  const edge = total.map((v, k) => `${x(sweep.rudder_rad[k]!).toFixed(1)} ${y(v).toFixed(1)}`);
  const first = x(sweep.rudder_rad[0]!).toFixed(1);
  const last = x(sweep.rudder_rad.at(-1)!).toFixed(1);
  return svg`<path class="value-curve" d="M${first} ${BAR} L${edge.join(" L")} L${last} ${BAR} Z">
    <title>Critic's value of each rudder angle</title></path>`;
}
