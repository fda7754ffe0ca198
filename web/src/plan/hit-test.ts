/** Which target is under the pointer. */

import type { Point } from "../domain/view";
import type { Target } from "../protocol.gen";
import type { Scene } from "./scene";

/** The target nearest to a point of the screen, within `reach_px`. */
export function targetAt(scene: Scene, p: Point, reach_px = 18): Target | null {
  let nearest: Target | null = null;
  let least = reach_px;
  for (const { target } of scene.rows) {
    const at = scene.view.toScreen(target);
    const distance = Math.hypot(at.x - p.x, at.y - p.y);
    if (distance < least) [nearest, least] = [target, distance];
  }
  return nearest;
}
