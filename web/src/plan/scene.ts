/** Everything one picture of the plan display is made of. */

import type { Motion, Position } from "../domain/geometry";
import type { RankedTarget } from "../domain/ranking";
import { milesToMetres } from "../domain/units";
import type { Point, View } from "../domain/view";
import type { SettingValues } from "../settings";
import type { Frame } from "../protocol.gen";
import type { PlanColours } from "./plan-colours";

export type Context = CanvasRenderingContext2D;
export const FONT = '"Noto Sans", "DejaVu Sans", sans-serif';

export interface Scene {
  frame: Frame;
  /** Past frames, the last of them `frame`. */
  frames: readonly Frame[];
  compare: readonly Frame[];
  path: readonly Position[];
  /** Own ship's track under the condition that was asked about; empty when nothing was. */
  whatIf: readonly Position[];
  rows: readonly RankedTarget[];
  selected: string | null;
  hovered: string | null;
  /** Position of a ship of note in the palette, `null` for all others. */
  colourIndex: (id: string) => number | null;
  settings: Readonly<SettingValues>;
  colours: PlanColours;
  view: View;
  width: number;
  height: number;
  /** Radius of the outer ring [px]. */
  radius: number;
  /** Whether flashing symbols are in their bright half. */
  flashOn: boolean;
}

export function shipColour(scene: Scene, id: string): string {
  const place = scene.colourIndex(id);
  return place === null ? scene.colours.other : (scene.colours.ships[place] ?? scene.colours.other);
}

/** Own ship as what keeps her heading and speed. */
export const ownMotion = (frame: Frame): Motion => ({
  east_m: frame.own.east_m,
  north_m: frame.own.north_m,
  course_rad: frame.own.heading_rad,
  speed_m_s: frame.own.speed_m_s,
});

export function isVisible(scene: Scene, p: Point, margin = 0): boolean {
  return (
    p.x >= -margin && p.y >= -margin && p.x <= scene.width + margin && p.y <= scene.height + margin
  );
}

export const ringRadius = (width: number, height: number): number =>
  Math.min(width, height) / 2 - 34;
export const pixelsPerMetre = (radius: number, range_nm: number): number =>
  radius / milesToMetres(range_nm);
export const toPositions = (path: readonly [number, number][]): Position[] =>
  path.map(([east_m, north_m]) => ({ east_m, north_m }));
