/** Between two frames of live traffic: how it has moved on since the last one. */

import { distance, positionAfter, wrapAngle } from "./geometry";
import type { Frame } from "../protocol.gen";

/** Live frames are 5 s apart; one that is later than this is not made up for [s]. */
export const MAX_DEAD_RECKONING_S = 10;

/**
 * The frame with everybody dead-reckoned for so many seconds: places, range and bearing, ages
 * and the clock. What was computed and decided (CPA, danger, advice) stays that of the frame, as
 * the sentence and the alarms are. A lost ship stays where she was.
 */
export function deadReckon(frame: Frame, seconds: number): Frame {
  const s = Math.min(seconds, MAX_DEAD_RECKONING_S);
  if (s <= 0) return frame;
  const { own } = frame;
  const here = { ...own, ...positionAfter({ ...own, course_rad: own.heading_rad }, s) };
  return {
    ...frame,
    time_s: frame.time_s + s,
    ...(frame.time_utc ? { time_utc: utcLater(frame.time_utc, s) } : {}),
    own: here,
    targets: frame.targets.map((target) => {
      const there = target.lost ? target : { ...target, ...positionAfter(target, s) };
      const toward = Math.atan2(there.east_m - here.east_m, there.north_m - here.north_m);
      return {
        ...there,
        range_m: distance(here, there),
        bearing_rad: wrapAngle(toward - own.heading_rad),
        ...(target.age_s == null ? {} : { age_s: target.age_s + s }),
      };
    }),
  };
}

const utcLater = (utc: string, seconds: number): string =>
  new Date(Date.parse(utc) + 1000 * seconds).toISOString();
