/** Own ship's motion, and whether its direction is a heading or a course over ground. */

import type { Frame } from "../protocol.gen";
import type { Motion } from "./geometry";

/** Own ship on its present heading and speed. */
export const ownMotion = ({ own }: Frame): Motion => ({
  east_m: own.east_m,
  north_m: own.north_m,
  course_rad: own.heading_rad,
  speed_m_s: own.speed_m_s,
});

/**
 * Whether `own.heading_rad` is a heading. It is where the pilot steers: the simulation has no
 * current. Of recorded and live own ships only the course over ground is known, which frames
 * carry in the same field.
 */
export const isHeadingKnown = (frame: Frame): boolean => frame.decision?.applied !== false;
