/** A line plot (uPlot). Events: `line-hover` with the id of the line pointed at, `x-click` with x. */

import { css, html, LitElement, unsafeCSS } from "lit";
import { customElement, property } from "lit/decorators.js";
import uPlot from "uplot";
import uPlotCss from "uplot/dist/uPlot.min.css?inline";

import type { PlanColours } from "../plan/plan-colours";

export interface PlotLine {
  /** The ship's id, or the name of a sub-task. */
  id: string;
  label: string;
  colour: string;
  width?: number;
  dash?: number[];
}

export interface PlotSpec {
  lines: readonly PlotLine[];
  data: readonly (readonly (number | null)[])[];
  formatX: (value: number) => string;
  /** The y axis spans at least this much, so that noise does not fill the plot. */
  minY: number;
  /** The y axis starts at zero. */
  fromZero?: boolean;
  /** The range of the x axis, where it does not follow the data. */
  xRange?: [number, number];
  xTicks?: number[];
  /** Vertical lines. */
  marks: readonly { at: number; colour: string }[];
}

@customElement("gh-plot")
export class LinePlot extends LitElement {
  static override styles = [
    css`
      ${unsafeCSS(uPlotCss)}
      :host {
        display: block;
        min-height: 0;
        min-width: 0;
        position: relative;
      }
      div.container {
        position: absolute;
        inset: 0;
      }
    `,
  ];

  @property({ attribute: false }) spec!: PlotSpec;
  @property({ attribute: false }) colours!: PlanColours;
  @property() highlighted: string | null = null;
  @property() name = "";

  private plot: uPlot | null = null;
  private built = "";
  private drawn: PlotSpec["data"] | null = null;
  private readonly sizes = new ResizeObserver(() => this.resize());

  override connectedCallback(): void {
    super.connectedCallback();
    this.sizes.observe(this);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.sizes.disconnect();
    this.plot?.destroy();
    this.plot = null;
    this.built = "";
  }

  override render() {
    return html`<div class="container" role="img" aria-label=${this.name}></div>`;
  }

  override updated(): void {
    const key = JSON.stringify([
      this.spec.lines,
      this.spec.xRange,
      this.colours.text,
      this.colours.sea,
    ]);
    if (key !== this.built) {
      this.plot?.destroy();
      this.plot = this.build();
      this.built = key;
    }
    const plot = this.plot;
    if (!plot) return;
    if (this.drawn !== this.spec.data) plot.setData(this.spec.data as uPlot.AlignedData);
    this.drawn = this.spec.data;
    plot.redraw(false, true);
  }

  private get container(): HTMLElement {
    return this.renderRoot.querySelector<HTMLElement>(".container")!;
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this;
    if (width && height) this.plot?.setSize({ width, height });
  }

  private build(): uPlot | null {
    const { clientWidth: width, clientHeight: height } = this;
    if (!width || !height) {
      requestAnimationFrame(() => this.requestUpdate());
      return null;
    }
    const axis: uPlot.Axis = {
      stroke: this.colours.muted,
      font: "11px 'Noto Sans', sans-serif",
      grid: { stroke: this.colours.line, width: 1 },
      ticks: { show: false },
    };
    const options: uPlot.Options = {
      width,
      height,
      legend: { show: false },
      padding: [6, 16, 0, 0],
      cursor: {
        y: false,
        points: { size: 5 },
        drag: { x: false, y: false },
        focus: { prox: 14 },
        bind: {},
      },
      focus: { alpha: 0.35 },
      scales: {
        x: {
          time: false,
          range: (_, low, high) =>
            this.spec.xRange ?? [low ?? 0, Math.max(high ?? 1, (low ?? 0) + 1)],
        },
        y: { range: (_, low, high) => this.yRange(low, high) },
      },
      axes: [
        {
          ...axis,
          size: 22,
          gap: 3,
          space: 46,
          values: (_, ticks) => ticks.map((v) => this.spec.formatX(v)),
          ...(this.spec.xTicks ? { splits: () => this.spec.xTicks! } : {}),
        },
        { ...axis, size: 42, gap: 3, space: 28, values: (_, ticks) => ticks.map(formatTick) },
      ],
      series: [
        {},
        ...this.spec.lines.map((line): uPlot.Series => ({
          label: line.label,
          stroke: line.colour,
          width: line.width ?? 1.6,
          points: { show: false },
          spanGaps: false,
          ...(line.dash ? { dash: line.dash } : {}),
        })),
      ],
      hooks: {
        draw: [(u) => this.marks(u)],
        setSeries: [(_, index) => this.hoverLine(index)],
        drawClear: [(u) => this.emphasise(u)],
      },
    };
    this.container.replaceChildren();
    const plot = new uPlot(options, this.spec.data as uPlot.AlignedData, this.container);
    plot.over.addEventListener("click", () => this.clicked(plot));
    plot.over.addEventListener("mouseleave", () => this.hoverLine(null));
    return plot;
  }

  private yRange(low: number | null, high: number | null): uPlot.Range.MinMax {
    const least = this.spec.minY;
    if (this.spec.fromZero) return [0, Math.max(least, (high ?? 0) * 1.08)];
    const [a, b] = [Math.min(low ?? 0, 0), Math.max(high ?? 0, 0)];
    if (b - a < least) return [a - least / 2, b + least / 2];
    const margin = (b - a) * 0.08;
    return [a - margin, b + margin];
  }

  /** Draw the highlighted line bold. */
  private emphasise(u: uPlot): void {
    this.spec.lines.forEach((line, k) => {
      const series = u.series[k + 1];
      if (series) series.width = line.id === this.highlighted ? 3.6 : (line.width ?? 1.6);
    });
  }

  private marks(u: uPlot): void {
    const c = u.ctx;
    const { top, height, left, width } = u.bbox;
    const zero = u.valToPos(0, "y", true);
    c.save();
    c.lineWidth = devicePixelRatio;
    c.strokeStyle = this.colours.muted;
    if (zero >= top && zero <= top + height) {
      c.beginPath();
      c.moveTo(left, zero);
      c.lineTo(left + width, zero);
      c.stroke();
    }
    for (const mark of this.spec.marks) {
      const x = u.valToPos(mark.at, "x", true);
      if (x < left - 1 || x > left + width + 1) continue;
      c.strokeStyle = mark.colour;
      c.lineWidth = 1.8 * devicePixelRatio;
      c.beginPath();
      c.moveTo(x, top);
      c.lineTo(x, top + height);
      c.stroke();
    }
    c.restore();
  }

  private hoverLine(index: number | null): void {
    const id = index ? (this.spec.lines[index - 1]?.id ?? null) : null;
    this.dispatchEvent(new CustomEvent<string | null>("line-hover", { detail: id }));
  }

  private clicked(u: uPlot): void {
    const left = u.cursor.left;
    if (left === undefined || left < 0) return;
    this.dispatchEvent(new CustomEvent<number>("x-click", { detail: u.posToVal(left, "x") }));
  }
}

/** A tick label without superfluous digits, with a typographic minus. */
function formatTick(value: number): string {
  return String(Number(value.toPrecision(3))).replace("-", "−");
}
