/** The layers of the plan display, from the sea up; each draws one thing. */

import { closestApproach, domainOutline, fromBody, wrapped, type Motion } from "../domain/geometry";
import { numberInk } from "../domain/colours";
import { placed, type Box } from "../domain/placing";
import type { Ranked } from "../domain/ranking";
import { clock, degrees, metres, miles, radians, shipName } from "../domain/units";
import { ringText, RINGS, vectorEnd, type Point } from "../domain/view";
import type { Frame, Place, Target } from "../wire";
import { inkOf, type Scene } from "./scene";
import * as symbol from "./symbols";

type Context = CanvasRenderingContext2D;

const PATH_STEP_S = 30;
/** CPA positions are shown for approaches nearer than this [m] and sooner than this [s]. */
const GHOST_M = 3 * 1852;
const GHOST_S = 3600;

export function draw(c: Context, scene: Scene): void {
  c.fillStyle = scene.inks.sea;
  c.fillRect(0, 0, scene.width, scene.height);
  c.font = `12px ${FONT}`;
  rings(c, scene);
  route(c, scene);
  trails(c, scene);
  domain(c, scene);
  predicted(c, scene);
  whatIf(c, scene);
  compared(c, scene);
  ghosts(c, scene);
  targets(c, scene);
  own(c, scene);
  names(c, scene);
}

const VECTOR_BOX_PX = 8;
const FONT = '"Noto Sans", "DejaVu Sans", sans-serif';

const ownMotion = (frame: Frame): Motion => ({
  east_m: frame.own.east_m,
  north_m: frame.own.north_m,
  course_rad: frame.own.heading_rad,
  speed_m_s: frame.own.speed_m_s,
});

/** Range rings about own ship, and true bearings on the outermost one. */
function rings(c: Context, scene: Scene): void {
  const { view, inks, radius, choices } = scene;
  const at = view.toScreen(scene.frame.own);
  c.strokeStyle = inks.ring;
  c.lineWidth = 1;
  for (let k = 1; k <= RINGS; k++) {
    c.lineWidth = k === RINGS ? 1.4 : 0.8;
    c.beginPath();
    c.arc(at.x, at.y, (radius * k) / RINGS, 0, 2 * Math.PI);
    c.stroke();
  }
  c.font = `11px ${FONT}`;
  for (let deg = 0; deg < 360; deg += 5) {
    const angle = view.angle(radians(deg));
    const long = deg % 30 === 0 ? 10 : deg % 10 === 0 ? 6 : 3;
    const edge = (r: number): Point => ({
      x: at.x + r * Math.sin(angle),
      y: at.y - r * Math.cos(angle),
    });
    symbol.line(c, edge(radius), edge(radius + long), inks.ring, 1);
  }
  for (const { words, p } of bearings(scene))
    symbol.text(c, words, p.x, p.y, inks.ringText, null, "center");
  for (const k of [2, 4]) {
    const words = `${Number(((choices.range_nm * k) / RINGS).toFixed(3))}`;
    const p = { x: at.x + ((radius * k) / RINGS) * 0.7071, y: at.y + ((radius * k) / RINGS) * 0.7071 };
    symbol.text(c, words, p.x, p.y, inks.ringText, inks.sea, "center");
  }
}

/** The true bearings written around the outermost ring, and where. */
function bearings({ view, frame, radius }: Scene): { words: string; p: Point }[] {
  const at = view.toScreen(frame.own);
  return Array.from({ length: 12 }, (_, k) => {
    const angle = view.angle(radians(30 * k));
    const p = { x: at.x + (radius + 20) * Math.sin(angle), y: at.y - (radius + 20) * Math.cos(angle) };
    return { words: String(30 * k).padStart(3, "0"), p };
  });
}

/** The line to the waypoint, and the waypoint where it is within sight. */
function route(c: Context, scene: Scene): void {
  const { view, inks, frame } = scene;
  const [from, to] = [view.toScreen(frame.own), view.toScreen(frame.waypoint)];
  const far = Math.hypot(to.x - from.x, to.y - from.y);
  if (far < 1) return;
  const most = Math.min(far, 3000);
  const end = { x: from.x + ((to.x - from.x) * most) / far, y: from.y + ((to.y - from.y) * most) / far };
  symbol.line(c, from, end, inks.path, 1, [2, 6]);
  if (most === far) symbol.waypoint(c, to, inks.path);
}

/** Past positions: dots equally spaced in time, relative to own ship in relative motion. */
function trails(c: Context, scene: Scene): void {
  const { trail_min, motion } = scene.choices;
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
    pastPositions(c, scene, past, motion === "relative", 1 - 0.6 * (age / span_s));
  }
  c.globalAlpha = 1;
}

function pastPositions(c: Context, scene: Scene, past: Frame, relative: boolean, alpha: number): void {
  const { view, frame, inks } = scene;
  const shift = relative
    ? { east_m: frame.own.east_m - past.own.east_m, north_m: frame.own.north_m - past.own.north_m }
    : { east_m: 0, north_m: 0 };
  c.globalAlpha = alpha;
  for (const target of past.targets) {
    const p = view.toScreen({
      east_m: target.east_m + shift.east_m,
      north_m: target.north_m + shift.north_m,
    });
    const noted = scene.place(target.id) !== null;
    if (inside(scene, p)) symbol.dot(c, p, noted ? 1.7 : 1, inkOf(scene, target.id));
  }
  if (!relative) symbol.dot(c, view.toScreen(past.own), 1.7, inks.own);
}

/** The ship domain of Eq. 14-15 about own ship. */
function domain(c: Context, scene: Scene): void {
  const { frame, view, inks } = scene;
  const edge = domainOutline(frame.ship.loa_m).map((body) =>
    view.toScreen(fromBody(frame.own, frame.own.heading_rad, body)),
  );
  symbol.polyline(c, [...edge, edge[0]!], inks.domain, 1.2, [5, 3]);
}

/** Where own ship goes under the pilot, with a mark every five minutes. */
function predicted(c: Context, scene: Scene): void {
  const { path, view, inks } = scene;
  if (path.length < 2) return;
  const points = path.map((p) => view.toScreen(p));
  symbol.polyline(c, points, inks.path, 2.2);
  points.forEach((p, k) => {
    if (k && (k * PATH_STEP_S) % 300 === 0) {
      symbol.dot(c, p, 3.4, inks.sea);
      c.strokeStyle = inks.path;
      c.lineWidth = 1.6;
      c.beginPath();
      c.arc(p.x, p.y, 3.4, 0, 2 * Math.PI);
      c.stroke();
    }
  });
}

/** Where own ship would go under the condition asked about, with the same marks as the prediction. */
function whatIf(c: Context, scene: Scene): void {
  const { view, inks } = scene;
  const points = scene.whatIf.map((p) => view.toScreen(p));
  symbol.polyline(c, points, inks.whatIf, 2.2, [8, 5]);
  points.forEach((p, k) => {
    if (k && (k * PATH_STEP_S) % 300 === 0) symbol.dot(c, p, 2.6, inks.whatIf);
  });
}

/** Own ship as another pilot would have steered her. */
function compared(c: Context, scene: Scene): void {
  const last = scene.compare.at(-1);
  if (!last) return;
  const { view, inks } = scene;
  symbol.polyline(c, scene.compare.map((f) => view.toScreen(f.own)), inks.compare, 1.8, [7, 4]);
  const at = view.toScreen(last.own);
  symbol.ownShip(c, at, inks.compare);
  const ahead = view.angle(last.own.heading_rad);
  symbol.line(
    c, at, { x: at.x + 26 * Math.sin(ahead), y: at.y - 26 * Math.cos(ahead) }, inks.compare, 1.5,
  );
  symbol.text(c, last.pilot, at.x + 13, at.y + 14, inks.compare, inks.sea);
}

/** Both ships where they will be nearest, for the ships that a viewer should know it of. */
function ghosts(c: Context, scene: Scene): void {
  const me = ownMotion(scene.frame);
  for (const row of scene.rows) {
    const { target } = row;
    const lit = target.id === scene.selected || target.id === scene.hovered;
    const told = lit || row.alarm !== null || scene.place(target.id) !== null;
    if (!told || target.lost || target.tcpa_s <= 0 || target.tcpa_s > GHOST_S) continue;
    if (!lit && !row.alarm && target.dcpa_m > GHOST_M) continue;
    ghost(c, scene, me, row, lit);
  }
  c.globalAlpha = 1;
}

function ghost(c: Context, scene: Scene, me: Motion, row: Ranked, lit: boolean): void {
  const { view, inks, choices } = scene;
  const { target } = row;
  const ink = row.alarm ? inks.alarm : inkOf(scene, target.id);
  const cpa = closestApproach(me, target);
  const relative = choices.motion === "relative" && choices.vectors === "relative";
  const [ownThen, targetThen] = relative
    ? [scene.frame.own, {
        east_m: scene.frame.own.east_m + cpa.target.east_m - cpa.own.east_m,
        north_m: scene.frame.own.north_m + cpa.target.north_m - cpa.own.north_m,
      }]
    : [cpa.own, cpa.target];
  const [a, b] = [view.toScreen(ownThen), view.toScreen(targetThen)];
  if (!inside(scene, a) && !inside(scene, b)) return;
  c.globalAlpha = lit || row.alarm ? 1 : 0.55;
  symbol.line(c, view.toScreen(target), b, ink, 0.8, [1, 4]);
  symbol.line(c, a, b, ink, lit ? 2 : 1.2);
  symbol.triangle(c, b, view.angle(target.course_rad), 6, ink, 1.1);
  c.strokeStyle = ink;
  c.lineWidth = 1.1;
  c.beginPath();
  c.arc(a.x, a.y, 4, 0, 2 * Math.PI);
  c.stroke();
}

/** Distance and time of the closest approach, beside the lit ship's place at that time. */
function ghostWords(c: Context, scene: Scene, row: Ranked, picture: Box, taken: Box[]): void {
  const { target, alarm } = row;
  const lit = target.id === scene.selected || target.id === scene.hovered;
  if (!lit || target.lost || target.tcpa_s <= 0 || target.tcpa_s > GHOST_S) return;
  const cpa = closestApproach(ownMotion(scene.frame), target);
  const at = scene.view.toScreen(cpa.target);
  if (!inside(scene, at)) return;
  c.font = `600 12px ${FONT}`;
  const words = `CPA ${miles(target.dcpa_m)} NM in ${clock(target.tcpa_s)}`;
  const box = placed(at, { w: c.measureText(words).width, h: 16 }, 16, picture, taken);
  if (!box) return;
  const ink = alarm ? scene.inks.alarm : scene.inks.ink;
  symbol.text(c, words, box.x, box.y + 8, ink, scene.inks.sea);
}

function targets(c: Context, scene: Scene): void {
  // Ships of note last, so that they lie on top.
  const order = [...scene.rows].sort(
    (p, q) => p.note - q.note || p.target.id.localeCompare(q.target.id),
  );
  for (const row of order) oneTarget(c, scene, row);
}

function oneTarget(c: Context, scene: Scene, row: Ranked): void {
  const { view, inks } = scene;
  const { target, alarm } = row;
  const at = view.toScreen(target);
  if (!inside(scene, at, 60)) return;
  const angle = view.angle(target.course_rad);
  const noted = scene.place(target.id) !== null;
  const ink = alarm ? inks.alarm : inkOf(scene, target.id);
  const flashing = alarm?.state === "unacknowledged";
  const size = noted || alarm ? symbol.TARGET_PX : symbol.SLEEPING_PX;
  const moving = target.speed_m_s > 0.25 && !target.lost;
  const awake = noted || alarm || target.fed !== false;
  if (moving && awake) {
    symbol.line(c, at, view.toScreen(vector(scene, target)), ink, alarm ? 2.4 : noted ? 1.7 : 1, [6, 4]);
  }
  if (!flashing || scene.bright)
    symbol.triangle(c, at, angle, size, ink, alarm ? 3 : noted ? 2 : 1.2, noted ? inks.sea : undefined);
  if (target.length_m) outline(c, scene, target, ink);
  if (target.lost) symbol.crossed(c, at, size + 3, ink);
  if (target.id === scene.selected) symbol.corners(c, at, 16, inks.ink, 2.2);
  else if (target.id === scene.hovered) symbol.corners(c, at, 16, inks.soft, 1.4);
}

/** Where a ship's vector ends. */
function vector({ choices, frame }: Scene, target: Target): Place {
  const { heading_rad, speed_m_s } = frame.own;
  const relative = choices.vectors === "relative" ? { course_rad: heading_rad, speed_m_s } : null;
  return vectorEnd(target, target.course_rad, target.speed_m_s, choices.vector_min, relative);
}

/** True-scale outline, once it is larger than the symbol. */
function outline(c: Context, scene: Scene, target: Target, ink: string): void {
  const length = (target.length_m ?? 0) * scene.view.px_m;
  if (length < 3 * symbol.TARGET_PX) return;
  const at = scene.view.toScreen(target);
  symbol.hull(c, at, scene.view.angle(target.course_rad), length, length / 6.5, ink);
}

/** Own ship: circles, heading line to the edge, beam line, her vector, her hull to scale. */
function own(c: Context, scene: Scene): void {
  const { view, inks, frame, radius, choices } = scene;
  const at = view.toScreen(frame.own);
  const ahead = view.angle(frame.own.heading_rad);
  const along = (r: number, turn = 0): Point => ({
    x: at.x + r * Math.sin(ahead + turn),
    y: at.y - r * Math.cos(ahead + turn),
  });
  symbol.line(c, at, along(radius), inks.own, 1);
  symbol.line(c, along(18, -Math.PI / 2), along(18, Math.PI / 2), inks.own, 1.2);
  if (choices.vectors === "true") {
    const m = ownMotion(frame);
    const end = vectorEnd(m, m.course_rad, m.speed_m_s, choices.vector_min, null);
    symbol.line(c, at, view.toScreen(end), inks.own, 2.6, [6, 4]);
  }
  const length = frame.ship.loa_m * view.px_m;
  if (length > 24) symbol.hull(c, at, ahead, length, frame.ship.beam_m * view.px_m, inks.own);
  if (length < 60) symbol.ownShip(c, at, inks.own);
}

/** Numbers of the ships of note, names where there is room. */
function names(c: Context, scene: Scene): void {
  const picture: Box = { x: 2, y: 2, w: scene.width - 4, h: scene.height - 4 };
  const taken: Box[] = [
    around(scene.view.toScreen(scene.frame.own), 14),
    ...bearings(scene).map(({ p }) => around(p, 10)),
  ];
  const told = [...scene.rows]
    .filter((row) => scene.place(row.target.id) !== null || row.target.id === scene.hovered)
    .sort((a, b) => b.note - a.note);
  for (const row of told) {
    const at = scene.view.toScreen(row.target);
    if (inside(scene, at)) taken.push(around(at, 11), ...alongVector(scene, row.target));
  }
  for (const row of told) name(c, scene, row, picture, taken);
  for (const row of scene.rows) ghostWords(c, scene, row, picture, taken);
}

/** A ship's vector as small boxes, so that no words hide it. */
function alongVector(scene: Scene, target: Target): Box[] {
  if (target.lost) return [];
  const [a, b] = [target, vector(scene, target)].map((p) => scene.view.toScreen(p)) as [Point, Point];
  const count = Math.min(Math.floor(Math.hypot(b.x - a.x, b.y - a.y) / VECTOR_BOX_PX), 40);
  return Array.from({ length: count }, (_, k) => {
    const share = (k + 1) / count;
    return around({ x: a.x + share * (b.x - a.x), y: a.y + share * (b.y - a.y) }, VECTOR_BOX_PX / 2);
  });
}

function name(c: Context, scene: Scene, row: Ranked, picture: Box, taken: Box[]): void {
  const { target } = row;
  const at = scene.view.toScreen(target);
  if (!inside(scene, at)) return;
  const place = scene.place(target.id);
  const lit = target.id === scene.selected || target.id === scene.hovered;
  c.font = `${lit ? 700 : 500} 12px ${FONT}`;
  const full = shipName(target.name);
  const chip = place === null ? "" : String(place + 1);
  const width = c.measureText(full).width + (chip ? 19 : 0);
  const box = placed(at, { w: width, h: 16 }, 15, picture, taken);
  const small = box ? null : chip ? placed(at, { w: 16, h: 16 }, 13, picture, taken) : null;
  const there = box ?? small;
  if (!there) return;
  const y = there.y + there.h / 2;
  if (chip) badge(c, scene, chip, there.x, there.y, inkOf(scene, target.id));
  if (box)
    symbol.text(c, full, there.x + (chip ? 20 : 0), y, lit ? scene.inks.ink : scene.inks.soft, scene.inks.sea);
}

function badge(c: Context, scene: Scene, chip: string, x: number, y: number, ink: string): void {
  c.fillStyle = ink;
  c.beginPath();
  c.roundRect(x, y, 16, 16, 4);
  c.fill();
  c.font = `700 11px ${FONT}`;
  symbol.text(c, chip, x + 8, y + 8.5, numberInk(ink, scene.choices.palette), null, "center");
}

const around = (p: Point, half: number): Box => ({
  x: p.x - half, y: p.y - half, w: 2 * half, h: 2 * half,
});

function inside(scene: Scene, p: Point, margin = 0): boolean {
  return (
    p.x >= -margin && p.y >= -margin && p.x <= scene.width + margin && p.y <= scene.height + margin
  );
}

/** The ship under a point of the screen, the nearest within `reach` pixels. */
export function under(scene: Scene, p: Point, reach = 18): Target | null {
  let found: Target | null = null;
  let least = reach;
  for (const { target } of scene.rows) {
    const at = scene.view.toScreen(target);
    const away = Math.hypot(at.x - p.x, at.y - p.y);
    if (away < least) [found, least] = [target, away];
  }
  return found;
}

/** What the picture shows, in words for those who cannot see it. */
export function described(scene: Scene): string {
  const { choices, rows, frame } = scene;
  const near = [...rows].sort((a, b) => b.note - a.note).slice(0, 3);
  const ships = near.map(({ target }) => {
    const deg = Math.round(degrees(wrapped(target.bearing_rad)));
    const side = deg === 0 ? "ahead" : `${Math.abs(deg)}° to ${deg > 0 ? "starboard" : "port"}`;
    return `${target.name}, ${miles(target.range_m)} miles, ${side}`;
  });
  return (
    `Plan display, ${choices.orientation}, ${choices.motion} motion, range ${choices.range_nm} ` +
    `miles, rings every ${ringText(choices.range_nm)}; ${frame.targets.length} ships. ${ships.join("; ")}`
  );
}

export const radiusFor = (width: number, height: number): number => Math.min(width, height) / 2 - 34;
export const scaleFor = (radius: number, range_nm: number): number => radius / metres(range_nm);
export const asPlaces = (path: readonly [number, number][]): Place[] =>
  path.map(([east_m, north_m]) => ({ east_m, north_m }));
