/** Which way a ship is turning, from the courses that she was last seen on. */

import type { Frame } from "../protocol.gen";
import { wrapAngle } from "./geometry";
import { radians } from "./units";

/** The course over ground of a ship that drifts is noise. */
const MIN_SPEED_M_S = 1;
/** A course that has changed by so much … */
const MIN_TURN_RAD = radians(3);
/** … within so long is a turn: less is yaw, and the noise of reports. */
const WINDOW_S = 60;

/** 1 to starboard, −1 to port, 0 if she keeps her course or was not seen long enough. */
export function turnDirection(frames: readonly Frame[], id: string): -1 | 0 | 1 {
  const last = frames.at(-1);
  const now = last?.targets.find((t) => t.id === id);
  if (!last || !now || now.lost || now.speed_m_s < MIN_SPEED_M_S) return 0;
  for (let k = frames.length - 2; k >= 0 && last.time_s - frames[k]!.time_s <= WINDOW_S; k--) {
    const then = frames[k]!.targets.find((t) => t.id === id);
    if (!then || then.lost) return 0;
    const turned = wrapAngle(now.course_rad - then.course_rad);
    if (Math.abs(turned) >= MIN_TURN_RAD) return turned > 0 ? 1 : -1;
  }
  return 0;
}
