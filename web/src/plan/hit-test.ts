/** The picture read back: which ship is under the pointer, and all of it in words. */

import { wrapped } from "../domain/geometry";
import { degrees, miles } from "../domain/units";
import { ringText, type Point } from "../domain/view";
import type { Target } from "../protocol.gen";
import type { Scene } from "./scene";

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
