/** The menu: open, replay and compare, CPA limits, the session and keyboard shortcuts. */

import { css, html, nothing } from "lit";
import { customElement, query, state } from "lit/decorators.js";

import { metresToMiles, milesToMetres } from "../domain/units";
import type { SourceEntry } from "../protocol.gen";
import { SHORTCUTS } from "../shortcuts";
import { store } from "../store";
import { shared } from "../style/shared";
import { inputValue, StoreElement } from "./store-element";
import { VIEW_ONLY } from "./top-bar";

const KINDS: [SourceEntry["kind"], string][] = [
  ["simulated", "Simulated encounters"],
  ["recorded", "Recorded traffic"],
  ["live", "Live"],
];

@customElement("gh-menu")
export class Menu extends StoreElement {
  static override styles = [
    shared,
    css`
      dialog {
        width: min(920px, 94vw);
        max-height: 90vh;
        padding: 0;
        color: var(--gh-text);
        background: var(--gh-panel);
        border: 1px solid var(--gh-line);
        border-radius: 6px;
      }
      dialog::backdrop {
        background: rgb(0 0 0 / 45%);
      }
      header {
        display: flex;
        justify-content: space-between;
        align-items: center;
        padding: 10px 16px;
        border-bottom: 1px solid var(--gh-line);
      }
      h1 {
        font-size: 17px;
        margin: 0;
      }
      .columns {
        display: grid;
        grid-template-columns: 1fr 1fr;
        gap: 4px 28px;
        padding: 12px 16px 16px;
      }
      section {
        display: grid;
        gap: 8px;
        align-content: start;
        padding: 8px 0 12px;
      }
      label {
        display: grid;
        gap: 3px;
      }
      select,
      input[type="text"],
      input[type="number"] {
        min-height: 36px;
        background: var(--gh-panel);
        border: 1px solid var(--gh-line);
        border-radius: 4px;
        padding: 0 8px;
        width: 100%;
      }
      .row {
        display: flex;
        gap: 10px;
        align-items: end;
      }
      .row label {
        flex: 1;
      }
      dl {
        display: grid;
        grid-template-columns: auto 1fr;
        gap: 3px 14px;
        margin: 0;
      }
      dt {
        font-weight: 600;
      }
      dd {
        margin: 0;
      }
      .primary {
        background: var(--gh-accent);
        color: var(--gh-on-accent);
        border-color: var(--gh-accent);
        min-height: 36px;
      }
      p {
        margin: 0;
      }
    `,
  ];

  @query("dialog") private dialog!: HTMLDialogElement;
  @state() private source = "";
  @state() private pilot = "";

  open(): void {
    this.source = store.session?.source ?? store.catalogue?.scenarios[0]?.source ?? "";
    this.pilot = "";
    this.dialog.showModal();
  }

  override render() {
    return html`
      <dialog aria-labelledby="title">
        <header>
          <h1 id="title">Menu</h1>
          <button @click=${() => this.dialog.close()}>Close</button>
        </header>
        <div class="columns">
          ${
            store.viewOnly
              ? html`<div>
                    <p>${VIEW_ONLY}</p>
                    ${this.sessionSection()}
                  </div>
                  <div>${this.limitsSection()} ${this.shortcutsSection()}</div>`
              : html`<div>
                    ${this.openSection()} ${this.replaySection()} ${this.sessionSection()}
                  </div>
                  <div>
                    ${this.pilotSection()} ${this.limitsSection()} ${this.shortcutsSection()}
                  </div>`
          }
        </div>
      </dialog>
    `;
  }

  private openSection() {
    const scenarios = store.catalogue?.scenarios ?? [];
    const known = scenarios.some((s) => s.source === this.source);
    return html`
      <section aria-label="Open">
        <h2>Open an encounter</h2>
        <label
          >Encounter
          <select id="scenario" @change=${(e: Event) => (this.source = inputValue(e))}>
            ${known ? nothing : html`<option value=${this.source} selected>${this.source || "choose"}</option>`}
            ${KINDS.map(([kind, title]) =>
              sourceGroup(
                title,
                scenarios.filter((s) => s.kind === kind),
                this.source,
              ),
            )}
          </select>
        </label>
        <label
          >or by name
          <input
            id="source"
            type="text"
            .value=${this.source}
            spellcheck="false"
            autocomplete="off"
            @input=${(e: Event) => (this.source = inputValue(e))}
            placeholder="random:35"
          />
        </label>
        <div class="row">
          <label
            >Pilot
            <select id="open-pilot" @change=${(e: Event) => (this.pilot = inputValue(e))}>
              <option value="" ?selected=${!this.pilot}>current</option>
              ${this.pilotOptions(this.pilot)}
            </select>
          </label>
          <button
            class="primary"
            id="open"
            ?disabled=${!this.source.trim()}
            @click=${this.openEncounter}
          >
            Open
          </button>
        </div>
      </section>
    `;
  }

  private readonly openEncounter = (): void => {
    const name = this.pilot || store.session?.pilot;
    const pilot = store.catalogue?.pilots.find((p) => p.name === name);
    store.send({
      type: "open",
      source: this.source.trim(),
      ...(pilot ? { pilot: pilot.name } : {}),
      ...(pilot?.ship ? { ship: pilot.ship } : {}),
    });
    this.dialog.close();
  };

  private pilotOptions(chosen: string | null) {
    return (store.catalogue?.pilots ?? []).map(
      (p) => html`<option value=${p.name} ?selected=${p.name === chosen}>${p.title}</option>`,
    );
  }

  private pilotSection() {
    const session = store.session;
    return html`
      <section aria-label="Pilot">
        <h2>
          ${session?.mode === "recorded" || session?.mode === "live" ? "Who advises" : "Who steers"}
        </h2>
        <label
          >Pilot
          <select
            id="pilot"
            ?disabled=${!session || session.mode === "replay"}
            @change=${(e: Event) => store.send({ type: "pilot", name: inputValue(e) })}
          >
            ${this.pilotOptions(session?.pilot ?? null)}
          </select>
        </label>
        <label
          >Compare with
          <select
            id="compare"
            ?disabled=${!session || session.mode === "replay"}
            @change=${(e: Event) => store.send({ type: "compare", name: inputValue(e) || null })}
          >
            <option value="" ?selected=${!session?.compare}>none</option>
            ${this.pilotOptions(session?.compare ?? null)}
          </select>
        </label>
      </section>
    `;
  }

  private replaySection() {
    const logs = store.catalogue?.logs ?? [];
    return html`
      <section aria-label="Replay">
        <h2>Replay a voyage</h2>
        ${
          logs.length
            ? html`<div class="row">
                <label
                  >Log
                  <select id="log">
                    ${logs.map(
                      (l) =>
                        html`<option value=${l.name}>
                          ${l.name.replace(/\.jsonl$/, "")}
                          ${l.frames == null ? "" : `(${l.frames} frames)`}
                        </option>`,
                    )}
                  </select>
                </label>
                <button id="replay" class="primary" @click=${this.replay}>Replay</button>
              </div>`
            : html`<p class="muted">No voyage has been recorded yet.</p>`
        }
      </section>
    `;
  }

  private readonly replay = (): void => {
    const log = this.renderRoot.querySelector<HTMLSelectElement>("#log")?.value;
    if (log) store.send({ type: "replay", log });
    this.dialog.close();
  };

  private limitsSection() {
    const limits = store.limits;
    return html`
      <section aria-label="CPA alarm">
        <h2>CPA alarm</h2>
        <p class="muted">Raised when both are below the limit, whatever the pilot advises.</p>
        <form class="row" @submit=${this.setLimits}>
          <label
            >CPA [NM]
            <input
              id="dcpa"
              name="dcpa"
              type="number"
              min="0"
              max="10"
              step="0.05"
              required
              ?disabled=${store.viewOnly}
              .value=${limits ? metresToMiles(limits.dcpa_m).toFixed(2) : ""}
            />
          </label>
          <label
            >TCPA [min]
            <input
              id="tcpa"
              name="tcpa"
              type="number"
              min="0"
              max="60"
              step="1"
              required
              ?disabled=${store.viewOnly}
              .value=${limits ? String(limits.tcpa_s / 60) : ""}
            />
          </label>
          ${store.viewOnly ? nothing : html`<button id="set-limits">Set</button>`}
        </form>
        <label class="sound">
          <span
            ><input
              type="checkbox"
              .checked=${store.settings.values.sound}
              @change=${(e: Event) => store.settings.set({ sound: (e.target as HTMLInputElement).checked })}
            />
            Sound while an alarm is unacknowledged</span
          >
        </label>
      </section>
    `;
  }

  private readonly setLimits = (event: SubmitEvent): void => {
    event.preventDefault();
    const data = new FormData(event.target as HTMLFormElement);
    store.setLimits({
      dcpa_m: milesToMetres(Number(data.get("dcpa"))),
      tcpa_s: 60 * Number(data.get("tcpa")),
    });
  };

  private sessionSection() {
    const session = store.session;
    const hash = store.frame?.weights_sha256;
    return html`
      <section aria-label="About">
        <h2>About this session</h2>
        <dl>
          <dt>Source</dt>
          <dd>${session?.source ?? "–"}</dd>
          <dt>Own ship</dt>
          <dd>${session?.ship ?? "–"}</dd>
          ${
            hash
              ? html`<dt>Weights</dt>
                  <dd title=${hash}>${hash.slice(0, 12)}</dd>`
              : nothing
          }
          <dt>Glasshelm</dt>
          <dd>${store.version || "–"}</dd>
        </dl>
        ${session?.notes.map((note) => html`<p class="muted">${note}</p>`)}
      </section>
    `;
  }

  private shortcutsSection() {
    return html`
      <section aria-label="Shortcuts">
        <h2>Shortcuts</h2>
        <dl>
          ${SHORTCUTS.filter(([, , whose]) => !whose || !store.viewOnly).map(
            ([key, what]) =>
              html`<dt>${key}</dt>
                <dd>${what}</dd>`,
          )}
        </dl>
      </section>
    `;
  }
}

function sourceGroup(title: string, entries: SourceEntry[], chosen: string) {
  if (!entries.length) return nothing;
  return html`<optgroup label=${title}>
    ${entries.map((s) => html`<option value=${s.source} ?selected=${s.source === chosen}>${s.title}</option>`)}
  </optgroup>`;
}
