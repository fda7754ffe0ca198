/** The common style of panels, buttons and numbers; theme.css has the colours. */

import { css } from "lit";

export const shared = css`
  :host {
    font-family: var(--gh-font);
    font-size: 13px;
    line-height: 1.3;
    color: var(--gh-text);
  }
  * {
    box-sizing: border-box;
  }
  button,
  select,
  input {
    font: inherit;
    color: inherit;
  }
  button,
  select {
    background: var(--gh-panel);
    border: 1px solid var(--gh-line);
    border-radius: 4px;
    min-height: 32px;
    padding: 0 10px;
    cursor: pointer;
    white-space: nowrap;
  }
  button:hover:not(:disabled),
  select:hover:not(:disabled) {
    border-color: var(--gh-muted);
  }
  :disabled {
    opacity: 0.45;
    cursor: default;
  }
  button[aria-pressed="true"] {
    background: var(--gh-accent);
    border-color: var(--gh-accent);
    color: var(--gh-on-accent);
  }
  :focus-visible {
    outline: 2px solid var(--gh-accent);
    outline-offset: 1px;
  }
  .button-group {
    display: inline-flex;
  }
  .button-group button {
    border-radius: 0;
    margin-left: -1px;
  }
  .button-group button:first-child {
    border-radius: 4px 0 0 4px;
    margin-left: 0;
  }
  .button-group button:last-child {
    border-radius: 0 4px 4px 0;
  }
  h2 {
    font-size: 11px;
    font-weight: 600;
    letter-spacing: 0.06em;
    text-transform: uppercase;
    color: var(--gh-muted);
    margin: 0;
  }
  .muted {
    color: var(--gh-muted);
  }
  .number {
    font-variant-numeric: tabular-nums;
    white-space: nowrap;
  }
  .badge {
    display: inline-grid;
    place-items: center;
    width: 18px;
    height: 18px;
    border-radius: 4px;
    font-size: 11px;
    font-weight: 700;
    color: var(--number, inherit);
    background: var(--ship, transparent);
    flex: none;
  }
  .visually-hidden {
    position: absolute;
    width: 1px;
    height: 1px;
    overflow: hidden;
    clip-path: inset(50%);
    white-space: nowrap;
  }
`;
