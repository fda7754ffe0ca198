/** How this viewer likes to look; kept in this browser, never sent. */

import type { Palette } from "./domain/colours";
import type { MotionMode, Orientation, VectorMode } from "./domain/view";

export type DetailLevel = 1 | 2 | 3;

export interface SettingValues {
  palette: Palette;
  level: DetailLevel;
  orientation: Orientation;
  motion: MotionMode;
  vectors: VectorMode;
  range_nm: number;
  vector_min: number;
  trail_min: number;
  sound: boolean;
}

export const DEFAULT_SETTINGS: SettingValues = {
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

const STORAGE_KEY = "glasshelm";

export class Settings {
  private current: SettingValues = { ...DEFAULT_SETTINGS, ...stored() };

  constructor(private readonly changed: () => void) {}

  get values(): Readonly<SettingValues> {
    return this.current;
  }

  set(some: Partial<SettingValues>): void {
    this.current = { ...this.current, ...some };
    try {
      localStorage.setItem(STORAGE_KEY, JSON.stringify(this.current));
    } catch {
      // A browser that keeps nothing shows the page all the same.
    }
    this.changed();
  }
}

/** What was kept, as far as it is of the right type. */
function stored(): Partial<SettingValues> {
  try {
    const found: unknown = JSON.parse(localStorage.getItem(STORAGE_KEY) ?? "{}");
    if (typeof found !== "object" || found === null) return {};
    return Object.fromEntries(
      Object.entries(found).filter(
        ([k, v]) =>
          k in DEFAULT_SETTINGS && typeof v === typeof DEFAULT_SETTINGS[k as keyof SettingValues],
      ),
    );
  } catch {
    return {};
  }
}
