/** All that one picture of the plan display depends on. */

import type { Position } from "../domain/geometry";
import type { RankedTarget } from "../domain/ranking";
import { milesToMetres } from "../domain/units";
import type { Point, View } from "../domain/view";
import type { Frame } from "../protocol.gen";
import type { SettingValues } from "../settings";
import type { PlanColours } from "./plan-colours";

export type Context = CanvasRenderingContext2D;
export const FONT = '"Noto Sans", "DejaVu Sans", sans-serif';

export interface Scene {
  frame: Frame;
  /** Past frames; the last one is `frame`. */
  frames: readonly Frame[];
  /** Frames of the compared pilot. */
  compare: readonly Frame[];
  /** Own ship's predicted track. */
  path: readonly Position[];
  /** Own ship's track of the last what-if answer, or empty. */
  whatIf: readonly Position[];
  rows: readonly RankedTarget[];
  selected: string | null;
  hovered: string | null;
  /** Index of a ship's colour, `null` for ships without one. */
  colourIndex: (id: string) => number | null;
  settings: Readonly<SettingValues>;
  colours: PlanColours;
  view: View;
  width: number;
  height: number;
  /** Radius of the outermost ring [px]. */
  radius: number;
  /** Whether flashing symbols are in their bright half. */
  flashOn: boolean;
}

export function shipColour(scene: Scene, id: string): string {
  const index = scene.colourIndex(id);
  return index === null ? scene.colours.other : (scene.colours.ships[index] ?? scene.colours.other);
}

/** The alarm colour for a ship under alarm, else its own. */
export const targetColour = (scene: Scene, { target, alarm }: RankedTarget): string =>
  alarm ? scene.colours.alarm : shipColour(scene, target.id);

export const isHighlighted = (scene: Scene, id: string): boolean =>
  id === scene.selected || id === scene.hovered;

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
