import { css } from "lit";

export const listStyle = css`
  :host {
    display: flex;
    flex-direction: column;
    min-height: 0;
    background: var(--gh-panel);
    padding: 8px 0 0;
  }
  header {
    display: flex;
    align-items: center;
    justify-content: space-between;
    padding: 0 14px;
    min-height: 28px;
  }
  .toggle {
    min-height: 28px;
    font-size: 12px;
  }
  .count {
    font-weight: 700;
    color: var(--gh-text);
  }
  .scroll {
    overflow: auto;
    min-height: 0;
    flex: 1;
  }
  table {
    width: 100%;
    border-collapse: collapse;
    font-size: 12.5px;
  }
  thead th {
    position: sticky;
    top: 0;
    z-index: 1;
    background: var(--gh-panel);
    font-weight: 500;
    font-size: 11px;
    color: var(--gh-muted);
    text-align: left;
    padding: 4px 4px;
    white-space: nowrap;
    border-bottom: 1px solid var(--gh-line);
  }
  .scale {
    font-weight: 400;
  }
  th:first-child {
    padding-left: 10px;
  }
  td,
  tbody th {
    padding: 0 4px;
    height: var(--row);
    border-bottom: 1px solid var(--gh-line);
    text-align: left;
    line-height: 1.2;
  }
  tbody th {
    padding: 0;
    font-weight: 500;
    max-width: 132px;
    min-width: 88px;
  }
  td:last-child,
  thead th:last-child {
    padding-right: 10px;
  }
  tr {
    cursor: pointer;
  }
  tr.hovered {
    background: color-mix(in srgb, var(--ship) 12%, var(--gh-panel));
  }
  tr.selected {
    background: color-mix(in srgb, var(--ship) 20%, var(--gh-panel));
    box-shadow: inset 4px 0 0 var(--ship);
  }
  .right,
  thead th.right {
    text-align: right;
  }
  .ship {
    display: flex;
    align-items: center;
    gap: 7px;
    width: 100%;
    height: calc(var(--row) - 1px);
    border: 0;
    border-radius: 0;
    background: none;
    padding: 0 4px 0 10px;
    text-align: left;
    min-width: 0;
  }
  .ship[aria-pressed="true"] {
    background: none;
    color: inherit;
    font-weight: 700;
  }
  .name {
    overflow: hidden;
    text-overflow: ellipsis;
  }
  .meter {
    position: relative;
    display: block;
    height: 7px;
    width: 100%;
    min-width: 30px;
    background: var(--gh-track);
    border-radius: 2px;
    overflow: hidden;
  }
  .meter i {
    position: absolute;
    left: 0;
    top: 0;
    bottom: 0;
    background: var(--ship);
    border-radius: 2px;
  }
  .meter.signed::after {
    content: "";
    position: absolute;
    left: calc(50% - 0.5px);
    top: 0;
    bottom: 0;
    width: 1px;
    background: var(--gh-muted);
  }
  .meter.minus i {
    background: repeating-linear-gradient(45deg, var(--ship) 0 2px, transparent 2px 4px);
  }
  .value {
    font-size: 11px;
    color: var(--gh-muted);
  }
  .encounter {
    font-size: 11.5px;
    white-space: nowrap;
  }
  .in-alarm {
    color: var(--gh-alarm);
    font-weight: 700;
  }
  tr.alarm .badge {
    outline: 2px solid var(--gh-alarm);
    outline-offset: 1px;
  }
  tr.unacknowledged .in-alarm {
    animation: flash 1s steps(2, jump-none) infinite;
  }
  @keyframes flash {
    to {
      color: var(--gh-on-alarm);
      background: var(--gh-alarm);
    }
  }
  .age.old {
    color: var(--gh-on-warn);
    background: var(--gh-warn);
  }
  tr.lost .name {
    text-decoration: line-through;
  }
  .scroll {
    container-type: inline-size;
  }
  @container (max-width: 720px) {
    .c-course {
      display: none;
    }
  }
  @container (max-width: 620px) {
    .c-bearing {
      display: none;
    }
  }
  @container (max-width: 540px) {
    .c-range {
      display: none;
    }
  }
  @container (max-width: 570px) {
    table {
      font-size: 12px;
    }
    thead th,
    td {
      padding-left: 3px;
      padding-right: 3px;
    }
    thead .scale {
      display: block;
    }
    tbody th {
      max-width: 96px;
      min-width: 72px;
    }
    .ship {
      gap: 5px;
      padding: 0 2px 0 6px;
    }
  }
  .none {
    padding: 12px 14px;
    color: var(--gh-muted);
  }
`;
