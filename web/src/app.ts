/** The page: its layout and its keyboard shortcuts. */

import { css, html, nothing } from "lit";
import { customElement, query } from "lit/decorators.js";

import { startAlarmSound } from "./alarm-sound";
import "./components/advice";
import "./components/alarm-strip";
import "./components/comparison-table";
import "./components/envelope-warning";
import "./components/explanation-panel";
import "./components/menu";
import type { Menu } from "./components/menu";
import "./components/notices";
import "./components/plan-bar";
import "./components/sentence";
import { StoreElement } from "./components/store-element";
import "./components/target-list";
import "./components/top-bar";
import "./components/transport";
import "./components/what-if";
import "./plan/plan-display";
import { handleKey } from "./shortcuts";
import { store } from "./store";
import { shared } from "./style/shared";

@customElement("gh-app")
export class App extends StoreElement {
  static override styles = [
    shared,
    css`
      :host {
        display: grid;
        grid-template-rows: auto auto minmax(0, 1fr) auto;
        height: 100vh;
        height: 100dvh;
      }
      .body {
        display: grid;
        grid-template-columns: minmax(0, 1fr) var(--side);
        min-height: 0;
      }
      .level-1 {
        --side: clamp(430px, 37vw, 520px);
      }
      .level-2 {
        --side: clamp(520px, 44.5vw, 640px);
      }
      .level-3 {
        --side: clamp(540px, 54vw, 900px);
      }
      .plan {
        display: grid;
        grid-template-rows: auto minmax(0, 1fr);
        min-width: 0;
        min-height: 0;
      }
      aside {
        display: flex;
        flex-direction: column;
        min-height: 0;
        overflow-y: auto;
        border-left: 1px solid var(--gh-line);
        background: var(--gh-panel);
      }
      .stale gh-sentence,
      .stale gh-target-list,
      .stale gh-explanation {
        filter: grayscale(1) opacity(0.5);
      }
      aside > * + * {
        border-top: 1px solid var(--gh-line);
      }
      gh-envelope-warning {
        border: 0;
      }
      /* Four ships are always in full sight, six where there is room; the plots take the rest. */
      gh-target-list {
        --row: 36px;
        flex: 1 0 0;
        min-height: calc(75px + var(--row) * var(--rows, 2));
      }
      .level-3 gh-target-list {
        --row: 33px;
      }
      .level-2 gh-target-list,
      .level-3 gh-target-list {
        flex: 0 1 auto;
        max-height: 294px;
      }
      gh-explanation {
        flex: 1 0 auto;
      }
      .overview {
        display: grid;
      }
      .level-2 .overview,
      .level-3 .overview {
        grid-template-columns: minmax(270px, 1fr) 1fr;
      }
      .level-3 .overview {
        grid-template-rows: 1fr auto;
      }
      .level-3 gh-advice {
        grid-row: span 2;
      }
      /* A tablet held upright: the picture above, its reasons below, and the more room the more of them. */
      @media (orientation: portrait) {
        .body {
          grid-template-columns: minmax(0, 1fr);
          grid-template-rows: minmax(0, 11fr) minmax(0, 10fr);
        }
        .level-2 {
          grid-template-rows: minmax(450px, 9fr) minmax(0, 11fr);
        }
        .level-3 {
          grid-template-rows: minmax(450px, 7fr) minmax(0, 13fr);
        }
        aside {
          border-left: 0;
          border-top: 1px solid var(--gh-line);
        }
        .level-1 .overview {
          grid-template-columns: minmax(270px, 1fr) 1fr;
        }
      }
    `,
  ];

  @query("gh-menu") private menu!: Menu;

  override connectedCallback(): void {
    super.connectedCallback();
    window.addEventListener("keydown", this.key);
    store.start();
    startAlarmSound();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    window.removeEventListener("keydown", this.key);
  }

  override willUpdate(): void {
    document.documentElement.dataset.obcTheme = store.settings.values.palette;
    document.title = store.session ? `${store.session.title} · Glasshelm` : "Glasshelm";
  }

  override render() {
    const { level } = store.settings.values;
    const ask = html`<gh-what-if aria-live="polite"></gh-what-if>`;
    return html`
      <gh-top-bar role="banner" @menu=${() => this.menu.open()}></gh-top-bar>
      <gh-alarm-strip role="alert"></gh-alarm-strip>
      <main class="body level-${level}">
        <section class="plan" aria-label="Plan display">
          <gh-plan-bar></gh-plan-bar>
          <gh-plan></gh-plan>
        </section>
        <aside aria-label="Decision" class=${store.liveness.state === "stale" ? "stale" : ""}>
          <div class="overview">
            <gh-advice></gh-advice>
            <gh-sentence aria-live="polite"></gh-sentence>
            ${level > 2 ? ask : nothing}
          </div>
          <gh-envelope-warning></gh-envelope-warning>
          ${store.session?.compare ? html`<gh-comparison></gh-comparison>` : nothing}
          ${level > 2 ? nothing : ask}
          <gh-target-list></gh-target-list>
          ${level > 1 ? html`<gh-explanation></gh-explanation>` : nothing}
        </aside>
      </main>
      <gh-transport role="contentinfo"></gh-transport>
      <gh-notices role="status"></gh-notices>
      <gh-menu></gh-menu>
    `;
  }

  private readonly key = (event: KeyboardEvent): void => handleKey(event, () => this.menu.open());
}
