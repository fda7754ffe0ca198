/** What lies under the ships: range rings with true bearings, and the way to the waypoint. */

import { radians } from "../domain/units";
import { N_RINGS, type Point } from "../domain/view";
import { FONT, type Context, type Scene } from "./scene";
import * as symbol from "./symbols";

/** Range rings about own ship, and true bearings on the outermost one. */
export function drawRangeRings(c: Context, scene: Scene): void {
  const { view, colours, radius, settings } = scene;
  const at = view.toScreen(scene.frame.own);
  c.strokeStyle = colours.ring;
  c.lineWidth = 1;
  for (let k = 1; k <= N_RINGS; k++) {
    c.lineWidth = k === N_RINGS ? 1.4 : 0.8;
    c.beginPath();
    c.arc(at.x, at.y, (radius * k) / N_RINGS, 0, 2 * Math.PI);
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
    symbol.line(c, edge(radius), edge(radius + long), colours.ring, 1);
  }
  for (const { words, p } of bearingLabels(scene))
    symbol.text(c, words, p.x, p.y, colours.ringText, null, "center");
  for (const k of [2, 4]) {
    const words = `${Number(((settings.range_nm * k) / N_RINGS).toFixed(3))}`;
    const p = {
      x: at.x + ((radius * k) / N_RINGS) * 0.7071,
      y: at.y + ((radius * k) / N_RINGS) * 0.7071,
    };
    symbol.text(c, words, p.x, p.y, colours.ringText, colours.sea, "center");
  }
}

/** The true bearings written around the outermost ring, and where. */
export function bearingLabels({ view, frame, radius }: Scene): { words: string; p: Point }[] {
  const at = view.toScreen(frame.own);
  return Array.from({ length: 12 }, (_, k) => {
    const angle = view.angle(radians(30 * k));
    const p = {
      x: at.x + (radius + 20) * Math.sin(angle),
      y: at.y - (radius + 20) * Math.cos(angle),
    };
    return { words: String(30 * k).padStart(3, "0"), p };
  });
}

/** The line to the waypoint, and the waypoint where it is within sight. */
export function drawRoute(c: Context, scene: Scene): void {
  const { view, colours, frame } = scene;
  const [from, to] = [view.toScreen(frame.own), view.toScreen(frame.waypoint)];
  const far = Math.hypot(to.x - from.x, to.y - from.y);
  if (far < 1) return;
  const most = Math.min(far, 3000);
  const end = {
    x: from.x + ((to.x - from.x) * most) / far,
    y: from.y + ((to.y - from.y) * most) / far,
  };
  symbol.line(c, from, end, colours.path, 1, [2, 6]);
  if (most === far) symbol.waypoint(c, to, colours.path);
}
