/** The picture read back: which ship is under the pointer, and all of it in words. */

import { wrapAngle } from "../domain/geometry";
import { degrees, formatMiles } from "../domain/units";
import { formatRingInterval, type Point } from "../domain/view";
import type { Target } from "../protocol.gen";
import type { Scene } from "./scene";

/** The ship under a point of the screen, the nearest within `reach` pixels. */
export function targetAt(scene: Scene, p: Point, reach = 18): Target | null {
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
export function describePlan(scene: Scene): string {
  const { settings, rows, frame } = scene;
  const near = [...rows].sort((a, b) => b.prominence - a.prominence).slice(0, 3);
  const ships = near.map(({ target }) => {
    const deg = Math.round(degrees(wrapAngle(target.bearing_rad)));
    const side = deg === 0 ? "ahead" : `${Math.abs(deg)}° to ${deg > 0 ? "starboard" : "port"}`;
    return `${target.name}, ${formatMiles(target.range_m)} miles, ${side}`;
  });
  return (
    `Plan display, ${settings.orientation}, ${settings.motion} motion, range ${settings.range_nm} ` +
    `miles, rings every ${formatRingInterval(settings.range_nm)}; ${frame.targets.length} ships. ${ships.join("; ")}`
  );
}
