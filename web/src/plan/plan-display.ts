/** The plan display: its canvas, pointer input and status text. */

import { css, html } from "lit";
import { customElement, query } from "lit/decorators.js";

import { StoreElement } from "../components/store-element";
import type { Position } from "../domain/geometry";
import { RANGE_SCALES_NM, stepThrough, upBearing, View, viewCentre } from "../domain/view";
import { store } from "../store";
import { shared } from "../style/shared";
import { targetAt } from "./hit-test";
import { drawPlan } from "./layers";
import { planColours } from "./plan-colours";
import { describePlan } from "./plan-description";
import { pixelsPerMetre, ringRadius, type Scene, toPositions } from "./scene";

const FLASH_MS = 500;

@customElement("gh-plan")
export class PlanDisplay extends StoreElement {
  static override styles = [
    shared,
    css`
      :host {
        display: block;
        position: relative;
        min-width: 0;
        min-height: 0;
        overflow: hidden;
        background: var(--gh-sea);
      }
      canvas {
        position: absolute;
        inset: 0;
        width: 100%;
        height: 100%;
        touch-action: none;
      }
      canvas.stale {
        filter: grayscale(1) opacity(0.45);
      }
      .stale-banner {
        position: absolute;
        left: 50%;
        top: 12px;
        transform: translateX(-50%);
        background: var(--gh-warn);
        color: var(--gh-on-warn);
        font-weight: 700;
        padding: 6px 14px;
        border-radius: 4px;
        border: 1px solid currentColor;
      }
      .empty {
        position: absolute;
        inset: 0;
        display: grid;
        place-items: center;
        color: var(--gh-muted);
        font-size: 15px;
      }
    `,
  ];

  @query("canvas") private canvas!: HTMLCanvasElement;
  private scene: Scene | null = null;
  private centre: Position | null = null;
  private readonly sizes = new ResizeObserver(() => this.requestUpdate());
  private flash = 0;

  override connectedCallback(): void {
    super.connectedCallback();
    this.sizes.observe(this);
    this.flash = window.setInterval(() => {
      if (store.hasOpenAlarm) this.requestUpdate();
    }, FLASH_MS);
    void document.fonts?.load("12px 'Noto Sans'").then(() => this.requestUpdate());
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.sizes.disconnect();
    window.clearInterval(this.flash);
  }

  override render() {
    const { liveness } = store;
    const stale = liveness.state === "stale";
    return html`
      <canvas
        role="img"
        class=${stale ? "stale" : ""}
        aria-label=${this.scene ? describePlan(this.scene) : "Plan display, empty"}
        @pointermove=${this.move}
        @pointerleave=${() => store.hover(null)}
        @click=${this.choose}
        @wheel=${{ handleEvent: this.wheel, passive: false }}
      ></canvas>
      ${stale ? html`<div class="stale-banner" role="status">NOT LIVE · ${liveness.text}</div>` : ""}
      ${store.frame ? "" : html`<div class="empty">${liveness.text}</div>`}
    `;
  }

  override updated(): void {
    const context = this.canvas.getContext("2d");
    const { clientWidth: width, clientHeight: height } = this;
    if (!context || !width || !height) return;
    const ratio = window.devicePixelRatio || 1;
    const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (this.canvas.width !== w || this.canvas.height !== h) {
      this.canvas.width = w;
      this.canvas.height = h;
    }
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.scene = this.compose(width, height);
    if (this.scene) drawPlan(context, this.scene);
    else context.clearRect(0, 0, width, height);
  }

  private compose(width: number, height: number): Scene | null {
    const frame = store.frame;
    if (!frame) return null;
    const settings = store.settings.values;
    const radius = ringRadius(width, height);
    this.centre = viewCentre(settings.motion, frame, settings.range_nm, this.centre);
    const view = new View(
      this.centre,
      upBearing(settings.orientation, frame),
      { x: width / 2, y: height / 2 },
      pixelsPerMetre(radius, settings.range_nm),
    );
    return {
      frame,
      frames: store.frames,
      compare: store.compareFrames,
      path: toPositions(store.path),
      whatIf: toPositions(store.whatIf?.counterfactual ?? []),
      rows: store.rows,
      selected: store.selected,
      hovered: store.hovered,
      colourIndex: (id) => store.colours.indexOf(id),
      settings,
      colours: planColours(settings.palette),
      view,
      width,
      height,
      radius,
      flashOn: Math.floor(performance.now() / FLASH_MS) % 2 === 0,
    };
  }

  private eventPoint(event: PointerEvent | MouseEvent) {
    const box = this.canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  private readonly move = (event: PointerEvent): void => {
    if (event.pointerType === "touch" || !this.scene) return;
    const target = targetAt(this.scene, this.eventPoint(event));
    store.hover(target?.id ?? null);
    this.canvas.style.cursor = target ? "pointer" : "default";
  };

  private readonly choose = (event: MouseEvent): void => {
    if (!this.scene) return;
    const target = targetAt(this.scene, this.eventPoint(event), 26);
    store.select(target?.id ?? null);
  };

  private readonly wheel = (event: WheelEvent): void => {
    event.preventDefault();
    const range_nm = stepThrough(
      RANGE_SCALES_NM,
      store.settings.values.range_nm as never,
      event.deltaY > 0 ? 1 : -1,
    );
    store.settings.set({ range_nm });
  };
}
