/** The frames that the page keeps. */

import type { Frame } from "../protocol.gen";

/** One hour of 5 s steps. */
export const MAX_FRAMES = 720;

/** The frames in order of time; one of an earlier time removes those from that time on. */
export function appendFrame(frames: Frame[], frame: Frame): Frame[] {
  const last = frames.at(-1);
  const kept =
    !last || last.time_s < frame.time_s ? frames : frames.filter((f) => f.time_s < frame.time_s);
  return [...kept.slice(-(MAX_FRAMES - 1)), frame];
}

/** Remove what only the present frame needs: of past frames tracks and time series are drawn. */
export function dropSweeps(frame: Frame): void {
  delete frame.sweep;
  for (const target of frame.targets) delete target.q_sweep;
}
