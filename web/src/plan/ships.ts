/** Own ship with its domain, and the targets with their vectors and hulls. */

import { domainOutline, fromBody, type Position } from "../domain/geometry";
import { isHeadingKnown, ownMotion } from "../domain/own-motion";
import type { RankedTarget } from "../domain/ranking";
import { turnDirection } from "../domain/turn-detection";
import { type Point, pointFrom, vectorEnd } from "../domain/view";
import type { Target } from "../protocol.gen";
import { type Context, FONT, isVisible, type Scene, targetColour } from "./scene";
import * as symbol from "./symbols";

/** Length of the mark at a vector's tip that shows a turn. */
const FLAG_PX = 9;

/** Own ship's domain (Eq. 14-15). */
export function drawDomain(c: Context, scene: Scene): void {
  const { frame, view, colours } = scene;
  const edge = domainOutline(frame.ship.loa_m).map((body) =>
    view.toScreen(fromBody(frame.own, frame.own.heading_rad, body)),
  );
  symbol.polyline(c, [...edge, edge[0]!], colours.domain, 1.2, [5, 3]);
}

export function drawTargets(c: Context, scene: Scene): void {
  // The most prominent last, on top of the others.
  const order = [...scene.rows].sort(
    (p, q) => p.prominence - q.prominence || p.target.id.localeCompare(q.target.id),
  );
  for (const row of order) drawTarget(c, scene, row);
}

function drawTarget(c: Context, scene: Scene, row: RankedTarget): void {
  const { view, colours } = scene;
  const { target, alarm } = row;
  const at = view.toScreen(target);
  if (!isVisible(scene, at, 60)) return;
  const angle = view.angle(target.course_rad);
  const coloured = scene.colourIndex(target.id) !== null;
  const colour = targetColour(scene, row);
  const flashing = alarm?.state === "unacknowledged";
  const size = coloured || alarm ? symbol.TARGET_PX : symbol.SLEEPING_PX;
  const moving = target.speed_m_s > 0.25 && !target.lost;
  const awake = coloured || alarm !== null || target.selected !== false;
  if (moving && awake) {
    const [end, width] = [
      view.toScreen(vectorTip(scene, target)),
      alarm ? 2.4 : coloured ? 1.7 : 1,
    ];
    symbol.line(c, at, end, colour, width, [6, 4]);
    const side = turnDirection(scene.frames, target.id);
    if (side) symbol.line(c, end, flagTip(end, angle, side), colour, width);
  }
  if (!flashing || scene.flashOn)
    symbol.triangle(
      c,
      at,
      angle,
      size,
      colour,
      alarm ? 3 : coloured ? 2 : 1.2,
      coloured ? colours.sea : undefined,
    );
  if (target.length_m) drawHull(c, scene, target, colour);
  if (target.lost) symbol.lostMark(c, at, size + 3, colour);
  if (target.id === scene.selected) symbol.selectionCorners(c, at, 16, colours.text, 2.2);
  else if (target.id === scene.hovered) symbol.selectionCorners(c, at, 16, colours.muted, 1.4);
}

/** The end of a turn flag: at right angles to the course, on the side of the turn. */
function flagTip(end: Point, angle: number, side: -1 | 1): Point {
  return pointFrom(end, angle + (side * Math.PI) / 2, FLAG_PX);
}

/** The tip of a target's vector. */
export function vectorTip({ settings, frame }: Scene, target: Target): Position {
  const { heading_rad, speed_m_s } = frame.own;
  const relative = settings.vectors === "relative" ? { course_rad: heading_rad, speed_m_s } : null;
  return vectorEnd(target, target.course_rad, target.speed_m_s, settings.vector_min, relative);
}

/** The outline to scale, once it is larger than the symbol. */
function drawHull(c: Context, scene: Scene, target: Target, colour: string): void {
  const length = (target.length_m ?? 0) * scene.view.px_m;
  if (length < 3 * symbol.TARGET_PX) return;
  const at = scene.view.toScreen(target);
  symbol.hull(c, at, scene.view.angle(target.course_rad), length, length / 6.5, colour);
}

/** Own ship: symbol, heading or course line to the outermost ring, beam line, vector, hull to scale. */
export function drawOwnShip(c: Context, scene: Scene): void {
  const { view, colours, frame, radius, settings } = scene;
  const at = view.toScreen(frame.own);
  const ahead = view.angle(frame.own.heading_rad);
  const along = (distance: number, turn = 0): Point => pointFrom(at, ahead + turn, distance);
  symbol.line(c, at, along(radius), colours.own, 1);
  if (!isHeadingKnown(frame)) {
    const end = along(radius - 14);
    c.font = `11px ${FONT}`;
    symbol.text(c, "COG", end.x, end.y, colours.own, colours.sea, "center");
  }
  symbol.line(c, along(18, -Math.PI / 2), along(18, Math.PI / 2), colours.own, 1.2);
  if (settings.vectors === "true") {
    const m = ownMotion(frame);
    const end = vectorEnd(m, m.course_rad, m.speed_m_s, settings.vector_min, null);
    symbol.line(c, at, view.toScreen(end), colours.own, 2.6, [6, 4]);
  }
  const length = frame.ship.loa_m * view.px_m;
  if (length > 24) symbol.hull(c, at, ahead, length, frame.ship.beam_m * view.px_m, colours.own);
  if (length < 60) symbol.ownShip(c, at, colours.own);
}
