/** How this viewer likes to look; kept in this browser, never sent. */

import type { Palette } from "./domain/colours";
import type { MotionMode, Orientation, VectorMode } from "./domain/view";

export type Level = 1 | 2 | 3;

export interface Choices {
  palette: Palette;
  level: Level;
  orientation: Orientation;
  motion: MotionMode;
  vectors: VectorMode;
  range_nm: number;
  vector_min: number;
  trail_min: number;
  sound: boolean;
}

export const DEFAULTS: Choices = {
  palette: "day",
  level: 1,
  orientation: "north-up",
  motion: "relative",
  vectors: "true",
  range_nm: 6,
  vector_min: 6,
  trail_min: 6,
  sound: true,
};

const KEY = "glasshelm";

export class Settings {
  private choices: Choices = { ...DEFAULTS, ...kept() };

  constructor(private readonly changed: () => void) {}

  get all(): Readonly<Choices> {
    return this.choices;
  }

  set(some: Partial<Choices>): void {
    this.choices = { ...this.choices, ...some };
    try {
      localStorage.setItem(KEY, JSON.stringify(this.choices));
    } catch {
      // A browser that keeps nothing shows the page all the same.
    }
    this.changed();
  }
}

/** What was kept, as far as it is of the right type. */
function kept(): Partial<Choices> {
  try {
    const found: unknown = JSON.parse(localStorage.getItem(KEY) ?? "{}");
    if (typeof found !== "object" || found === null) return {};
    return Object.fromEntries(
      Object.entries(found).filter(
        ([k, v]) => k in DEFAULTS && typeof v === typeof DEFAULTS[k as keyof Choices],
      ),
    );
  } catch {
    return {};
  }
}
