/** The certified rudder band: of which rudder it is, and where it lies on a scale. */

import type { Banded, Frame } from "../protocol.gen";

/** The band that was told last, if it is of this frame: of its time, its pilot, its rudder. */
export function bandForFrame(told: Banded | null, frame: Frame | null): Banded | null {
  if (!told || !frame) return null;
  const same =
    told.time_s === frame.time_s &&
    told.pilot === frame.pilot &&
    told.rudder_rad === (frame.decision?.rudder_rad ?? null);
  return same ? told : null;
}

/** Its ends on a scale, never nearer to each other than `least`, so that they can be told apart. */
export function bracketEnds(
  band: { low_rad: number; high_rad: number },
  x: (rad: number) => number,
  least: number,
): [number, number] {
  const [low, high] = [x(band.low_rad), x(band.high_rad)];
  const more = Math.max(0, least - (high - low)) / 2;
  return [low - more, high + more];
}
