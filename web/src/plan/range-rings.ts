/** Range rings with true bearings, and the line to the waypoint. */

import { radians } from "../domain/units";
import { formatRingDistance, N_RINGS, type Point, pointFrom } from "../domain/view";
import { type Context, FONT, type Scene } from "./scene";
import * as symbol from "./symbols";

/** A waypoint's line is drawn no longer than this [px]. */
const MAX_LINE_PX = 3000;

/** Range rings around own ship, with a bearing scale on the outermost one. */
export function drawRangeRings(c: Context, scene: Scene): void {
  const { view, colours, radius, settings } = scene;
  const own = view.toScreen(scene.frame.own);
  for (let k = 1; k <= N_RINGS; k++)
    symbol.circle(c, own, (radius * k) / N_RINGS, colours.ring, k === N_RINGS ? 1.4 : 0.8);
  c.font = `11px ${FONT}`;
  for (let deg = 0; deg < 360; deg += 5) {
    const angle = view.angle(radians(deg));
    const length = deg % 30 === 0 ? 10 : deg % 10 === 0 ? 6 : 3;
    const [a, b] = [pointFrom(own, angle, radius), pointFrom(own, angle, radius + length)];
    symbol.line(c, a, b, colours.ring, 1);
  }
  for (const { text, p } of bearingLabels(scene))
    symbol.text(c, text, p.x, p.y, colours.ringText, null, "center");
  for (const k of [2, 4]) {
    const p = pointFrom(own, (3 * Math.PI) / 4, (radius * k) / N_RINGS);
    const text = formatRingDistance(settings.range_nm, k);
    symbol.text(c, text, p.x, p.y, colours.ringText, colours.sea, "center");
  }
}

/** The bearing labels around the outermost ring and their positions. */
export function bearingLabels({ view, frame, radius }: Scene): { text: string; p: Point }[] {
  const own = view.toScreen(frame.own);
  return Array.from({ length: 12 }, (_, k) => ({
    text: String(30 * k).padStart(3, "0"),
    p: pointFrom(own, view.angle(radians(30 * k)), radius + 20),
  }));
}

/** The line to the waypoint, and the waypoint's symbol. */
export function drawRoute(c: Context, scene: Scene): void {
  const { view, colours, frame } = scene;
  const [from, to] = [view.toScreen(frame.own), view.toScreen(frame.waypoint)];
  const distance = Math.hypot(to.x - from.x, to.y - from.y);
  if (distance < 1) return;
  const share = Math.min(1, MAX_LINE_PX / distance);
  const end = { x: from.x + (to.x - from.x) * share, y: from.y + (to.y - from.y) * share };
  symbol.line(c, from, end, colours.path, 1, [2, 6]);
  if (share === 1) symbol.waypoint(c, to, colours.path);
}
