/** Range, orientation, motion, vectors, trails and stabilisation of the plan display. */

import { css, html } from "lit";
import { customElement } from "lit/decorators.js";

import {
  formatRingDistance,
  type Orientation,
  RANGE_SCALES_NM,
  stepThrough,
  TRAIL_MINUTES,
  VECTOR_MINUTES,
} from "../domain/view";
import { store } from "../store";
import { shared } from "../style/shared";
import { inputValue, StoreElement } from "./store-element";

const ORIENTATIONS: [Orientation, string, string][] = [
  ["head-up", "H UP", "Head up (H)"],
  ["north-up", "N UP", "North up (N)"],
  ["course-up", "C UP", "Course up (C)"],
];

@customElement("gh-plan-bar")
export class PlanBar extends StoreElement {
  static override styles = [
    shared,
    css`
      :host {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: 4px 6px;
        padding: 4px 6px;
        background: var(--gh-panel);
        border-bottom: 1px solid var(--gh-line);
        font-size: 12px;
      }
      button,
      select {
        min-height: 28px;
        padding: 0 7px;
      }
      select {
        padding: 0 2px;
      }
      label,
      .set {
        display: inline-flex;
        align-items: center;
        gap: 5px;
        white-space: nowrap;
      }
      .range {
        font-weight: 700;
        font-size: 14px;
        line-height: 1.1;
        min-width: 78px;
        text-align: center;
      }
      small {
        display: block;
        font-weight: 500;
        font-size: 10.5px;
        color: var(--gh-muted);
      }
      .step {
        width: 27px;
        padding: 0;
        font-size: 16px;
        font-weight: 700;
      }
    `,
  ];

  override render() {
    const { orientation, motion, vectors, range_nm, vector_min, trail_min } = store.settings.values;
    const set = store.settings.set.bind(store.settings);
    return html`
      <span class="set" role="group" aria-label="Range scale">
        <button
          class="step"
          aria-label="Smaller range"
          ?disabled=${range_nm === RANGE_SCALES_NM[0]}
          @click=${() => this.stepRange(-1)}
        >
          −
        </button>
        <span class="range number"
          >${range_nm} NM<small>rings ${formatRingDistance(range_nm)} NM</small></span
        >
        <button
          class="step"
          aria-label="Larger range"
          ?disabled=${range_nm === RANGE_SCALES_NM.at(-1)}
          @click=${() => this.stepRange(1)}
        >
          +
        </button>
      </span>
      <span class="button-group" role="group" aria-label="Orientation">
        ${ORIENTATIONS.map(
          ([value, label, title]) =>
            html`<button
              title=${title}
              aria-pressed=${orientation === value}
              @click=${() => set({ orientation: value })}
            >
              ${label}
            </button>`,
        )}
      </span>
      <span class="button-group" role="group" aria-label="Motion">
        <button
          title="Relative motion (M)"
          aria-pressed=${motion === "relative"}
          @click=${() => set({ motion: "relative" })}
        >
          RM
        </button>
        <button
          title="True motion (M)"
          aria-pressed=${motion === "true"}
          @click=${() => set({ motion: "true" })}
        >
          TM
        </button>
      </span>
      <span class="set">
        <span class="muted">Vectors</span>
        <span class="button-group" role="group" aria-label="Vectors">
          <button
            title="True vectors (V)"
            aria-pressed=${vectors === "true"}
            @click=${() => set({ vectors: "true" })}
          >
            T
          </button>
          <button
            title="Relative vectors (V)"
            aria-pressed=${vectors === "relative"}
            @click=${() => set({ vectors: "relative" })}
          >
            R
          </button>
        </span>
        <select
          aria-label="Vector time"
          .value=${String(vector_min)}
          @change=${(e: Event) => set({ vector_min: Number(inputValue(e)) })}
        >
          ${VECTOR_MINUTES.map((m) => html`<option value=${m} ?selected=${m === vector_min}>${m} min</option>`)}
        </select>
      </span>
      <label>
        <span class="muted">Trails ${motion === "relative" ? "R" : "T"}</span>
        <select
          aria-label="Trail time"
          .value=${String(trail_min)}
          @change=${(e: Event) => set({ trail_min: Number(inputValue(e)) })}
        >
          ${TRAIL_MINUTES.map(
            (m) =>
              html`<option value=${m} ?selected=${m === trail_min}>
                ${m ? `${m} min` : "off"}
              </option>`,
          )}
        </select>
      </label>
      <span class="muted" title="Courses and speeds are over ground">GND STAB</span>
    `;
  }

  private stepRange(step: -1 | 1): void {
    const { range_nm } = store.settings.values;
    store.settings.set({ range_nm: stepThrough<number>(RANGE_SCALES_NM, range_nm, step) });
  }
}
