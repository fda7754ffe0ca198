/** Symbols after IEC 62288: own ship, AIS targets, marks for selected, dangerous, lost. */

import type { Point } from "../domain/view";

type Context = CanvasRenderingContext2D;

/** Half height of a target's triangle [px]. */
export const TARGET_PX = 9;
export const SLEEPING_PX = 6;

/** Two circles, one in the other. */
export function ownShip(c: Context, at: Point, ink: string): void {
  c.strokeStyle = ink;
  c.lineWidth = 1.6;
  for (const radius of [4, 9]) {
    c.beginPath();
    c.arc(at.x, at.y, radius, 0, 2 * Math.PI);
    c.stroke();
  }
}

/** A hull to scale, bow along `angle` (clockwise from up): five corners, pointed ahead. */
export function hull(
  c: Context,
  at: Point,
  angle: number,
  length_px: number,
  beam_px: number,
  ink: string,
): void {
  const [l, b] = [length_px / 2, beam_px / 2];
  c.save();
  c.translate(at.x, at.y);
  c.rotate(angle);
  c.beginPath();
  c.moveTo(0, -l);
  c.lineTo(b, -l + Math.min(1.6 * b, l));
  c.lineTo(b, l);
  c.lineTo(-b, l);
  c.lineTo(-b, -l + Math.min(1.6 * b, l));
  c.closePath();
  c.strokeStyle = ink;
  c.lineWidth = 1.4;
  c.stroke();
  c.restore();
}

/** An AIS triangle, its apex along `angle`; small and thin for a sleeping target. */
export function triangle(
  c: Context,
  at: Point,
  angle: number,
  size: number,
  ink: string,
  width: number,
  fill?: string,
): void {
  c.save();
  c.translate(at.x, at.y);
  c.rotate(angle);
  c.beginPath();
  c.moveTo(0, -size * 1.15);
  c.lineTo(size * 0.68, size * 0.85);
  c.lineTo(-size * 0.68, size * 0.85);
  c.closePath();
  if (fill) {
    c.fillStyle = fill;
    c.fill();
  }
  c.strokeStyle = ink;
  c.lineWidth = width;
  c.lineJoin = "miter";
  c.stroke();
  c.restore();
}

/** The corners of a square: a selected target. */
export function selectionCorners(
  c: Context,
  at: Point,
  half: number,
  ink: string,
  width = 2,
): void {
  const arm = half * 0.5;
  c.strokeStyle = ink;
  c.lineWidth = width;
  c.beginPath();
  for (const sx of [-1, 1])
    for (const sy of [-1, 1]) {
      c.moveTo(at.x + sx * half, at.y + sy * (half - arm));
      c.lineTo(at.x + sx * half, at.y + sy * half);
      c.lineTo(at.x + sx * (half - arm), at.y + sy * half);
    }
  c.stroke();
}

/** Two bold crossing lines: a lost target. */
export function lostMark(c: Context, at: Point, half: number, ink: string): void {
  c.strokeStyle = ink;
  c.lineWidth = 2.6;
  c.beginPath();
  c.moveTo(at.x - half, at.y - half);
  c.lineTo(at.x + half, at.y + half);
  c.moveTo(at.x + half, at.y - half);
  c.lineTo(at.x - half, at.y + half);
  c.stroke();
}

/** A waypoint: a circle with a dot. */
export function waypoint(c: Context, at: Point, ink: string): void {
  c.strokeStyle = ink;
  c.fillStyle = ink;
  c.lineWidth = 1.5;
  c.beginPath();
  c.arc(at.x, at.y, 7, 0, 2 * Math.PI);
  c.stroke();
  c.beginPath();
  c.arc(at.x, at.y, 1.8, 0, 2 * Math.PI);
  c.fill();
}

export function line(
  c: Context,
  a: Point,
  b: Point,
  ink: string,
  width: number,
  dash: number[] = [],
): void {
  c.strokeStyle = ink;
  c.lineWidth = width;
  c.setLineDash(dash);
  c.beginPath();
  c.moveTo(a.x, a.y);
  c.lineTo(b.x, b.y);
  c.stroke();
  c.setLineDash([]);
}

export function polyline(
  c: Context,
  points: readonly Point[],
  ink: string,
  width: number,
  dash: number[] = [],
): void {
  if (points.length < 2) return;
  c.strokeStyle = ink;
  c.lineWidth = width;
  c.setLineDash(dash);
  c.beginPath();
  points.forEach((p, k) => (k ? c.lineTo(p.x, p.y) : c.moveTo(p.x, p.y)));
  c.stroke();
  c.setLineDash([]);
}

export function dot(c: Context, at: Point, radius: number, ink: string): void {
  c.fillStyle = ink;
  c.beginPath();
  c.arc(at.x, at.y, radius, 0, 2 * Math.PI);
  c.fill();
}

/** Text on a plate of the sea's colour, so that lines do not run through it. */
export function text(
  c: Context,
  words: string,
  x: number,
  y: number,
  ink: string,
  plate: string | null,
  align: CanvasTextAlign = "left",
): void {
  c.textAlign = align;
  c.textBaseline = "middle";
  if (plate) {
    c.strokeStyle = plate;
    c.lineWidth = 3.5;
    c.lineJoin = "round";
    c.strokeText(words, x, y);
  }
  c.fillStyle = ink;
  c.fillText(words, x, y);
}
