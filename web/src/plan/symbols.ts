/** Symbols after IEC 62288: own ship, AIS targets, marks for selected, dangerous and lost ones. */

import type { Point } from "../domain/view";

type Context = CanvasRenderingContext2D;

/** Half height of a target's triangle [px]. */
export const TARGET_PX = 9;
export const SLEEPING_PX = 6;

/** Two concentric circles. */
export function ownShip(c: Context, at: Point, colour: string): void {
  for (const radius of [4, 9]) circle(c, at, radius, colour, 1.6);
}

/** A hull to scale, its bow along `angle` (clockwise from up). */
export function hull(
  c: Context,
  at: Point,
  angle: number,
  length_px: number,
  beam_px: number,
  colour: string,
): void {
  const [l, b] = [length_px / 2, beam_px / 2];
  const shoulder = -l + Math.min(1.6 * b, l);
  const outline = [
    { x: 0, y: -l },
    { x: b, y: shoulder },
    { x: b, y: l },
    { x: -b, y: l },
    { x: -b, y: shoulder },
  ];
  polygon(c, at, angle, outline, colour, 1.4);
}

/** An AIS triangle, its apex along `angle`; small and thin for a sleeping target. */
export function triangle(
  c: Context,
  at: Point,
  angle: number,
  size: number,
  colour: string,
  width: number,
  fill?: string,
): void {
  const outline = [
    { x: 0, y: -size * 1.15 },
    { x: size * 0.68, y: size * 0.85 },
    { x: -size * 0.68, y: size * 0.85 },
  ];
  polygon(c, at, angle, outline, colour, width, fill);
}

function polygon(
  c: Context,
  at: Point,
  angle: number,
  outline: readonly Point[],
  colour: string,
  width: number,
  fill?: string,
): void {
  c.save();
  c.translate(at.x, at.y);
  c.rotate(angle);
  c.beginPath();
  trace(c, outline);
  c.closePath();
  if (fill) {
    c.fillStyle = fill;
    c.fill();
  }
  c.strokeStyle = colour;
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
  colour: string,
  width: number,
): void {
  const arm = half * 0.5;
  c.strokeStyle = colour;
  c.lineWidth = width;
  c.beginPath();
  for (const sx of [-1, 1])
    for (const sy of [-1, 1])
      trace(c, [
        { x: at.x + sx * half, y: at.y + sy * (half - arm) },
        { x: at.x + sx * half, y: at.y + sy * half },
        { x: at.x + sx * (half - arm), y: at.y + sy * half },
      ]);
  c.stroke();
}

/** A bold cross: a lost target. */
export function lostMark(c: Context, at: Point, half: number, colour: string): void {
  for (const s of [-1, 1])
    line(
      c,
      { x: at.x - half, y: at.y - s * half },
      { x: at.x + half, y: at.y + s * half },
      colour,
      2.6,
    );
}

/** A circle with a dot. */
export function waypoint(c: Context, at: Point, colour: string): void {
  circle(c, at, 7, colour, 1.5);
  dot(c, at, 1.8, colour);
}

export function line(
  c: Context,
  a: Point,
  b: Point,
  colour: string,
  width: number,
  dash: number[] = [],
): void {
  polyline(c, [a, b], colour, width, dash);
}

export function polyline(
  c: Context,
  points: readonly Point[],
  colour: string,
  width: number,
  dash: number[] = [],
): void {
  if (points.length < 2) return;
  c.strokeStyle = colour;
  c.lineWidth = width;
  c.setLineDash(dash);
  c.beginPath();
  trace(c, points);
  c.stroke();
  c.setLineDash([]);
}

function trace(c: Context, points: readonly Point[]): void {
  points.forEach((p, k) => (k ? c.lineTo(p.x, p.y) : c.moveTo(p.x, p.y)));
}

export function circle(c: Context, at: Point, radius: number, colour: string, width: number): void {
  c.strokeStyle = colour;
  c.lineWidth = width;
  c.beginPath();
  c.arc(at.x, at.y, radius, 0, 2 * Math.PI);
  c.stroke();
}

export function dot(c: Context, at: Point, radius: number, colour: string): void {
  c.fillStyle = colour;
  c.beginPath();
  c.arc(at.x, at.y, radius, 0, 2 * Math.PI);
  c.fill();
}

/** Text, with a halo that keeps lines behind it from touching the letters. */
export function text(
  c: Context,
  words: string,
  x: number,
  y: number,
  colour: string,
  halo: string | null,
  align: CanvasTextAlign = "left",
): void {
  c.textAlign = align;
  c.textBaseline = "middle";
  if (halo) {
    c.strokeStyle = halo;
    c.lineWidth = 3.5;
    c.lineJoin = "round";
    c.strokeText(words, x, y);
  }
  c.fillStyle = colour;
  c.fillText(words, x, y);
}
