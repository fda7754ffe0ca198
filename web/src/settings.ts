/** Display settings, stored in the browser and never sent. */

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

  constructor(private readonly onChange: () => void) {}

  get values(): Readonly<SettingValues> {
    return this.current;
  }

  set(changes: Partial<SettingValues>): void {
    this.current = { ...this.current, ...changes };
    try {
      localStorage.setItem(STORAGE_KEY, JSON.stringify(this.current));
    } catch {
      // Without storage the settings last as long as the page.
    }
    this.onChange();
  }
}

/** The stored values that are of the right type. */
function stored(): Partial<SettingValues> {
  try {
    const values: unknown = JSON.parse(localStorage.getItem(STORAGE_KEY) ?? "{}");
    if (typeof values !== "object" || values === null) return {};
    return Object.fromEntries(
      Object.entries(values).filter(
        ([k, v]) =>
          k in DEFAULT_SETTINGS && typeof v === typeof DEFAULT_SETTINGS[k as keyof SettingValues],
      ),
    );
  } catch {
    return {};
  }
}
