/** Transport controls: play, pause, seek and speed. */

import "@oicl/openbridge-webcomponents/dist/icons/icon-media-pause.js";
import "@oicl/openbridge-webcomponents/dist/icons/icon-media-play.js";
import { css, html, nothing } from "lit";
import { customElement, state } from "lit/decorators.js";

import { formatDuration } from "../domain/units";
import { store } from "../store";
import { shared } from "../style/shared";
import { inputValue, StoreElement } from "./store-element";

const RATES = [1, 2, 5, 10, 20, 60] as const;

@customElement("gh-transport")
export class Transport extends StoreElement {
  static override styles = [
    shared,
    css`
      :host {
        display: flex;
        align-items: center;
        gap: 10px;
        padding: 6px 12px;
        background: var(--gh-panel);
        border-top: 1px solid var(--gh-line);
      }
      input {
        flex: 1;
        min-width: 80px;
        height: 28px;
        margin: 0;
        appearance: none;
        background: transparent;
        cursor: pointer;
      }
      input::-webkit-slider-runnable-track {
        height: 6px;
        border-radius: 3px;
        background: linear-gradient(var(--gh-accent), var(--gh-accent)) 0 / var(--share) 100%
          no-repeat var(--gh-track);
      }
      input::-moz-range-track {
        height: 6px;
        border-radius: 3px;
        background: linear-gradient(var(--gh-accent), var(--gh-accent)) 0 / var(--share) 100%
          no-repeat var(--gh-track);
      }
      input::-webkit-slider-thumb {
        appearance: none;
        width: 16px;
        height: 16px;
        margin-top: -5px;
        border-radius: 50%;
        background: var(--gh-accent);
        border: 2px solid var(--gh-on-accent);
      }
      input::-moz-range-thumb {
        width: 13px;
        height: 13px;
        border-radius: 50%;
        background: var(--gh-accent);
        border: 2px solid var(--gh-on-accent);
      }
      .play {
        width: 44px;
        height: 36px;
        padding: 0;
        display: grid;
        place-items: center;
      }
      obi-media-play,
      obi-media-pause {
        display: block;
        width: 22px;
        height: 22px;
      }
      select {
        min-height: 36px;
      }
      .live {
        flex: 1;
      }
    `,
  ];

  /** The slider's time while it is dragged. */
  @state() private dragged_s: number | null = null;

  override render() {
    const session = store.session;
    if (!session) return html`<span class="muted">No session</span>`;
    if (session.mode === "live")
      return html`<span class="live muted"
        >${["Live: the pilot advises on received data", ...session.notes].join(" · ")}</span
      >`;
    const now = this.dragged_s ?? store.frame?.time_s ?? session.time_s;
    const end = session.end_s;
    const [from, to] = [session.seekable_from_s, Math.max(end ?? session.seekable_to_s, now)];
    return html`
      <button
        class="play"
        ?disabled=${store.viewOnly}
        aria-label=${session.playing ? "Pause" : "Play"}
        title="Space"
        @click=${togglePlay}
      >
        ${session.playing ? html`<obi-media-pause></obi-media-pause>` : html`<obi-media-play></obi-media-play>`}
      </button>
      <span class="number">${formatDuration(now)}</span>
      <input
        type="range"
        aria-label="Time"
        min=${from}
        max=${to}
        step="5"
        .value=${String(now)}
        style="--share: ${to > from ? (100 * (now - from)) / (to - from) : 0}%"
        aria-valuetext=${formatDuration(now)}
        ?disabled=${store.viewOnly || to <= from}
        @input=${(e: Event) => (this.dragged_s = Number(inputValue(e)))}
        @change=${this.seek}
      />
      <span class="number muted">${end === null ? nothing : formatDuration(end)}</span>
      <label>
        <span class="visually-hidden">Speed</span>
        <select
          aria-label="Speed"
          ?disabled=${store.viewOnly}
          @change=${(e: Event) => store.send({ type: "rate", rate: Number(inputValue(e)) })}
        >
          ${rateOptions(session.rate).map((r) => html`<option value=${r} ?selected=${r === session.rate}>×${r}</option>`)}
        </select>
      </label>
    `;
  }

  private readonly seek = (event: Event): void => {
    seekTo(Number(inputValue(event)));
    this.dragged_s = null;
  };
}

export function togglePlay(): void {
  const session = store.session;
  if (session && session.mode !== "live" && !store.viewOnly)
    store.send({ type: session.playing ? "pause" : "play" });
}

/** Seek to a time, within what has been simulated or can be read. */
export function seekTo(target_s: number): void {
  const { session, frame } = store;
  if (!session || !frame || session.mode === "live" || store.viewOnly) return;
  const last = Math.max(session.seekable_to_s, frame.time_s);
  const time_s = Math.min(Math.max(target_s, session.seekable_from_s), last);
  store.send({ type: "seek", time_s });
}

/** The usual speeds, and the present one if it is another. */
function rateOptions(rate: number): number[] {
  return [...new Set<number>([...RATES, rate])].sort((a, b) => a - b);
}
