/** The certified rudder band: which frame it belongs to, and where it lies on a scale. */

import type { BandMessage, Frame } from "../protocol.gen";

/** `band` if it was computed for this frame: the same time, pilot and rudder. */
export function bandForFrame(band: BandMessage | null, frame: Frame | null): BandMessage | null {
  if (!band || !frame) return null;
  const same =
    band.time_s === frame.time_s &&
    band.pilot === frame.pilot &&
    band.rudder_rad === (frame.decision?.rudder_rad ?? null);
  return same ? band : null;
}

/** The ends of the band on a scale `x`, at least `minWidth` apart so that both can be seen. */
export function bracketEnds(
  band: { low_rad: number; high_rad: number },
  x: (rad: number) => number,
  minWidth: number,
): [number, number] {
  const [low, high] = [x(band.low_rad), x(band.high_rad)];
  const margin = Math.max(0, minWidth - (high - low)) / 2;
  return [low - margin, high + margin];
}
