/** Everything one picture of the plan display is made of. */

import type { Motion, Position } from "../domain/geometry";
import type { Ranked } from "../domain/ranking";
import { metres } from "../domain/units";
import type { Point, View } from "../domain/view";
import type { Choices } from "../settings";
import type { Frame } from "../protocol.gen";
import type { Inks } from "./plan-colours";

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
  rows: readonly Ranked[];
  selected: string | null;
  hovered: string | null;
  /** Position of a ship of note in the palette, `null` for all others. */
  place: (id: string) => number | null;
  choices: Readonly<Choices>;
  inks: Inks;
  view: View;
  width: number;
  height: number;
  /** Radius of the outer ring [px]. */
  radius: number;
  /** Whether flashing symbols are in their bright half. */
  bright: boolean;
}

export function inkOf(scene: Scene, id: string): string {
  const place = scene.place(id);
  return place === null ? scene.inks.other : (scene.inks.ships[place] ?? scene.inks.other);
}

/** Own ship as what keeps her heading and speed. */
export const ownMotion = (frame: Frame): Motion => ({
  east_m: frame.own.east_m,
  north_m: frame.own.north_m,
  course_rad: frame.own.heading_rad,
  speed_m_s: frame.own.speed_m_s,
});

export function inside(scene: Scene, p: Point, margin = 0): boolean {
  return (
    p.x >= -margin && p.y >= -margin && p.x <= scene.width + margin && p.y <= scene.height + margin
  );
}

export const radiusFor = (width: number, height: number): number =>
  Math.min(width, height) / 2 - 34;
export const scaleFor = (radius: number, range_nm: number): number => radius / metres(range_nm);
export const asPlaces = (path: readonly [number, number][]): Position[] =>
  path.map(([east_m, north_m]) => ({ east_m, north_m }));
