/** Keyboard shortcuts; the menu lists them. */

import { seekTo, togglePlay } from "./components/transport";
import { PALETTES } from "./domain/colours";
import { RANGE_SCALES_NM, stepThrough, VECTOR_MINUTES } from "./domain/view";
import type { DetailLevel } from "./settings";
import { store } from "./store";

/** Keys, what they do, and whether only an owner may use them. */
export const SHORTCUTS: [string, string, "owner"?][] = [
  ["Space", "Play or pause", "owner"],
  ["← →", "One minute back, forward", "owner"],
  ["↑ ↓", "Select the ship above, below"],
  ["Esc", "Deselect"],
  ["A", "Acknowledge the most urgent alarm", "owner"],
  ["+ −", "Smaller, larger range"],
  ["H N C", "Head, north, course up"],
  ["M", "Relative or true motion"],
  ["V", "True or relative vectors"],
  ["[ ]", "Shorter, longer vectors"],
  ["1 2 3", "Level of detail"],
  ["P", "Next palette"],
  ["?", "Menu"],
];

export function handleKey(event: KeyboardEvent, openMenu: () => void): void {
  if (event.ctrlKey || event.metaKey || event.altKey || isKeyTaken(event)) return;
  const action = actions(openMenu)[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action) return;
  event.preventDefault();
  action();
}

function actions(openMenu: () => void): Record<string, () => void> {
  const { settings } = store;
  const now = settings.values;
  const level = (n: DetailLevel) => () => settings.set({ level: n });
  const range = (step: -1 | 1) => () =>
    settings.set({ range_nm: stepThrough<number>(RANGE_SCALES_NM, now.range_nm, step) });
  const vector = (step: -1 | 1) => () =>
    settings.set({ vector_min: stepThrough<number>(VECTOR_MINUTES, now.vector_min, step) });
  return {
    " ": togglePlay,
    ArrowLeft: () => seekBy(-60),
    ArrowRight: () => seekBy(60),
    ArrowUp: () => selectNeighbour(-1),
    ArrowDown: () => selectNeighbour(1),
    Escape: () => store.select(null),
    a: acknowledgeMostUrgent,
    "+": range(-1),
    "=": range(-1),
    "-": range(1),
    h: () => settings.set({ orientation: "head-up" }),
    n: () => settings.set({ orientation: "north-up" }),
    c: () => settings.set({ orientation: "course-up" }),
    m: () => settings.set({ motion: now.motion === "true" ? "relative" : "true" }),
    v: () => settings.set({ vectors: now.vectors === "true" ? "relative" : "true" }),
    "[": vector(-1),
    "]": vector(1),
    "1": level(1),
    "2": level(2),
    "3": level(3),
    p: () =>
      settings.set({ palette: PALETTES[(PALETTES.indexOf(now.palette) + 1) % PALETTES.length]! }),
    "?": openMenu,
  };
}

const NAVIGATION_KEYS = [
  "ArrowLeft",
  "ArrowRight",
  "ArrowUp",
  "ArrowDown",
  "Home",
  "End",
  "PageUp",
  "PageDown",
];

/** Whether an open dialog or the focused field, list, slider or button uses the key itself. */
function isKeyTaken(event: KeyboardEvent): boolean {
  const path = event.composedPath();
  const [focus, key] = [path[0], event.key];
  if (path.some((e) => e instanceof HTMLDialogElement)) return true;
  if (focus instanceof HTMLInputElement)
    return focus.type !== "range" || NAVIGATION_KEYS.includes(key);
  if (focus instanceof HTMLSelectElement)
    return (
      NAVIGATION_KEYS.includes(key) || [" ", "Enter", "Escape"].includes(key) || /^\d$/.test(key)
    );
  return focus instanceof HTMLButtonElement && key === " ";
}

function seekBy(by_s: number): void {
  if (store.frame) seekTo(store.frame.time_s + by_s);
}

function selectNeighbour(step: -1 | 1): void {
  const ids = store.rows.map((row) => row.target.id);
  const k = store.selected ? ids.indexOf(store.selected) : step > 0 ? -1 : ids.length;
  const next = ids[Math.min(Math.max(k + step, 0), ids.length - 1)];
  if (next && next !== store.selected) store.select(next);
}

function acknowledgeMostUrgent(): void {
  if (store.viewOnly) return;
  const open = store.alarms.filter((a) => a.state === "unacknowledged");
  const nearest = open.sort((a, b) => a.tcpa_s - b.tcpa_s)[0];
  if (nearest) store.send({ type: "acknowledge", id: nearest.id });
}
