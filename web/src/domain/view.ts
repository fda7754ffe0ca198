/** From positions to pixels: orientation, motion mode and range scale of the plan display. */

import type { Frame } from "../protocol.gen";
import { bearing, distance, type Position, velocity, wrapAngle } from "./geometry";
import { milesToMetres, radians } from "./units";

export type Orientation = "head-up" | "north-up" | "course-up";
export type MotionMode = "relative" | "true";
export type VectorMode = "true" | "relative";

/** Radius of the outermost ring: the usual radar range scales. */
export const RANGE_SCALES_NM = [0.75, 1.5, 3, 6, 12, 24] as const;
export const N_RINGS = 6;
export const VECTOR_MINUTES = [1, 3, 6, 12, 20, 30] as const;
export const TRAIL_MINUTES = [0, 3, 6, 12, 30] as const;

export interface Point {
  x: number;
  y: number;
}

/** A map projection: the position at the centre, the bearing that points up, the scale. */
export class View {
  private readonly sin: number;
  private readonly cos: number;

  constructor(
    readonly centre: Position,
    readonly up_rad: number,
    readonly screenCentre: Point,
    readonly px_m: number,
  ) {
    this.sin = Math.sin(up_rad);
    this.cos = Math.cos(up_rad);
  }

  toScreen(p: Position): Point {
    const e = p.east_m - this.centre.east_m;
    const n = p.north_m - this.centre.north_m;
    return {
      x: this.screenCentre.x + (e * this.cos - n * this.sin) * this.px_m,
      y: this.screenCentre.y - (e * this.sin + n * this.cos) * this.px_m,
    };
  }

  /** A bearing as an angle on the screen, clockwise from up. */
  angle(bearing_rad: number): number {
    return wrapAngle(bearing_rad - this.up_rad);
  }
}

/** The bearing that points up. Course-up follows the course to the waypoint in steps of 5°. */
export function upBearing(orientation: Orientation, frame: Frame): number {
  if (orientation === "north-up") return 0;
  if (orientation === "head-up") return frame.own.heading_rad;
  const step = radians(5);
  return Math.round(bearing(frame.own, frame.waypoint) / step) * step;
}

/**
 * The position at the centre of the picture. In relative motion it is own ship. In true motion it
 * stays fixed until own ship is farther away than 0.6 of the range; it is then moved ahead of own
 * ship by half the range.
 */
export function viewCentre(
  motion: MotionMode,
  frame: Frame,
  range_nm: number,
  previous: Position | null,
): Position {
  if (motion === "relative") return frame.own;
  const range_m = milesToMetres(range_nm);
  if (previous && distance(previous, frame.own) <= 0.6 * range_m) return previous;
  const ahead = velocity(frame.own.heading_rad, 0.5 * range_m);
  return {
    east_m: frame.own.east_m + ahead.east_m,
    north_m: frame.own.north_m + ahead.north_m,
  };
}

/** The tip of a ship's vector after `minutes`, true or relative to another motion. */
export function vectorEnd(
  from: Position,
  course_rad: number,
  speed_m_s: number,
  minutes: number,
  relativeTo: { course_rad: number; speed_m_s: number } | null,
): Position {
  const v = velocity(course_rad, speed_m_s);
  const o = relativeTo ? velocity(relativeTo.course_rad, relativeTo.speed_m_s) : null;
  const t = minutes * 60;
  return {
    east_m: from.east_m + (v.east_m - (o?.east_m ?? 0)) * t,
    north_m: from.north_m + (v.north_m - (o?.north_m ?? 0)) * t,
  };
}

/** The point at an angle (clockwise from up) and a distance from another one. */
export const pointFrom = (from: Point, angle: number, distance: number): Point => ({
  x: from.x + distance * Math.sin(angle),
  y: from.y - distance * Math.cos(angle),
});

/** The radius of a ring in miles: that of the first one is also the interval of the rings. */
export function formatRingDistance(range_nm: number, ring = 1): string {
  return String(Number(((range_nm * ring) / N_RINGS).toFixed(3)));
}

/** The next or previous of the values; at either end the value stays. */
export function stepThrough<T>(values: readonly T[], now: T, step: -1 | 1): T {
  const k = values.indexOf(now);
  return values[Math.min(Math.max(k + step, 0), values.length - 1)] ?? now;
}
