/** Dead reckoning of live traffic between two frames. */

import type { Frame } from "../protocol.gen";
import { bearing, distance, positionAfter, wrapAngle } from "./geometry";
import { ownMotion } from "./own-motion";

/** Live frames are 5 s apart; nothing is extrapolated for longer than this [s]. */
export const MAX_DEAD_RECKONING_S = 10;

/**
 * The frame with all ships dead-reckoned for some seconds: positions, range and bearing, ages and
 * time. CPA, danger and advice stay those of the frame. A lost target keeps its last position.
 */
export function deadReckon(frame: Frame, seconds: number): Frame {
  const s = Math.min(seconds, MAX_DEAD_RECKONING_S);
  if (s <= 0) return frame;
  const own = { ...frame.own, ...positionAfter(ownMotion(frame), s) };
  return {
    ...frame,
    time_s: frame.time_s + s,
    ...(frame.time_utc ? { time_utc: addSeconds(frame.time_utc, s) } : {}),
    own,
    targets: frame.targets.map((target) => {
      const moved = target.lost ? target : { ...target, ...positionAfter(target, s) };
      return {
        ...moved,
        range_m: distance(own, moved),
        bearing_rad: wrapAngle(bearing(own, moved) - own.heading_rad),
        ...(target.age_s == null ? {} : { age_s: target.age_s + s }),
      };
    }),
  };
}

const addSeconds = (utc: string, seconds: number): string =>
  new Date(Date.parse(utc) + 1000 * seconds).toISOString();
