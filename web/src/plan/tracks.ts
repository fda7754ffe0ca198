/** Tracks: past positions, own ship's predicted and what-if tracks, the compared pilot's track. */

import { type Point, pointFrom } from "../domain/view";
import type { Frame } from "../protocol.gen";
import { type Context, isVisible, type Scene, shipColour } from "./scene";
import * as symbol from "./symbols";

/** Time between two points of a predicted track. */
const PATH_STEP_S = 30;
/** Time between two marks on it. */
const MARK_EVERY_S = 300;

/** Past positions as dots equally spaced in time, relative to own ship in relative motion. */
export function drawTrails(c: Context, scene: Scene): void {
  const { trail_min, motion } = scene.settings;
  if (!trail_min) return;
  const span_s = trail_min * 60;
  const every_s = Math.max(30, span_s / 12);
  const newest = scene.frame.time_s;
  let last = Infinity;
  for (let k = scene.frames.length - 1; k >= 0; k--) {
    const past = scene.frames[k]!;
    const age = newest - past.time_s;
    if (age > span_s) break;
    if (age <= 0 || Math.floor(past.time_s / every_s) === last) continue;
    last = Math.floor(past.time_s / every_s);
    drawPastPositions(c, scene, past, motion === "relative", 1 - 0.6 * (age / span_s));
  }
  c.globalAlpha = 1;
}

function drawPastPositions(
  c: Context,
  scene: Scene,
  past: Frame,
  relative: boolean,
  alpha: number,
): void {
  const { view, frame, colours } = scene;
  const shift = relative
    ? { east_m: frame.own.east_m - past.own.east_m, north_m: frame.own.north_m - past.own.north_m }
    : { east_m: 0, north_m: 0 };
  c.globalAlpha = alpha;
  for (const target of past.targets) {
    const p = view.toScreen({
      east_m: target.east_m + shift.east_m,
      north_m: target.north_m + shift.north_m,
    });
    const coloured = scene.colourIndex(target.id) !== null;
    if (isVisible(scene, p)) symbol.dot(c, p, coloured ? 1.7 : 1, shipColour(scene, target.id));
  }
  if (!relative) symbol.dot(c, view.toScreen(past.own), 1.7, colours.own);
}

/** Own ship's track under the pilot. */
export function drawPredictedTrack(c: Context, scene: Scene): void {
  const { path, view, colours } = scene;
  if (path.length < 2) return;
  const points = path.map((p) => view.toScreen(p));
  symbol.polyline(c, points, colours.path, 2.2);
  for (const p of timeMarks(points)) {
    symbol.dot(c, p, 3.4, colours.sea);
    symbol.circle(c, p, 3.4, colours.path, 1.6);
  }
}

/** Own ship's track under the what-if condition. */
export function drawWhatIfTrack(c: Context, scene: Scene): void {
  const { view, colours } = scene;
  const points = scene.whatIf.map((p) => view.toScreen(p));
  symbol.polyline(c, points, colours.whatIf, 2.2, [8, 5]);
  for (const p of timeMarks(points)) symbol.dot(c, p, 2.6, colours.whatIf);
}

const timeMarks = (points: readonly Point[]): Point[] =>
  points.filter((_, k) => k > 0 && (k * PATH_STEP_S) % MARK_EVERY_S === 0);

/** Own ship's track and position under the compared pilot. */
export function drawComparedTrack(c: Context, scene: Scene): void {
  const last = scene.compare.at(-1);
  if (!last) return;
  const { view, colours } = scene;
  symbol.polyline(
    c,
    scene.compare.map((f) => view.toScreen(f.own)),
    colours.compare,
    1.8,
    [7, 4],
  );
  const at = view.toScreen(last.own);
  symbol.ownShip(c, at, colours.compare);
  const ahead = view.angle(last.own.heading_rad);
  symbol.line(c, at, pointFrom(at, ahead, 26), colours.compare, 1.5);
  symbol.text(c, last.pilot, at.x + 13, at.y + 14, colours.compare, colours.sea);
}
