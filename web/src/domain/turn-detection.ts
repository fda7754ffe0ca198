/** Which way a target is turning, from its recent courses. */

import type { Frame } from "../protocol.gen";
import { wrapAngle } from "./geometry";
import { radians } from "./units";

/** Below this speed the course over ground is noise. */
const MIN_SPEED_M_S = 1;
/** A smaller change of course is yaw or the noise of reports. */
const MIN_TURN_RAD = radians(3);
/** Courses of the last so many seconds are compared. */
const WINDOW_S = 60;

/** 1 to starboard, −1 to port, 0 where the target keeps its course or was not seen long enough. */
export function turnDirection(frames: readonly Frame[], id: string): -1 | 0 | 1 {
  const last = frames.at(-1);
  const now = last?.targets.find((t) => t.id === id);
  if (!last || !now || now.lost || now.speed_m_s < MIN_SPEED_M_S) return 0;
  for (let k = frames.length - 2; k >= 0 && last.time_s - frames[k]!.time_s <= WINDOW_S; k--) {
    const before = frames[k]!.targets.find((t) => t.id === id);
    if (!before || before.lost) return 0;
    const turn_rad = wrapAngle(now.course_rad - before.course_rad);
    if (Math.abs(turn_rad) >= MIN_TURN_RAD) return turn_rad > 0 ? 1 : -1;
  }
  return 0;
}
