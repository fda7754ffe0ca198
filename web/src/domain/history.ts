/** The frames that the page holds. */

import type { Frame } from "../protocol.gen";

/** One hour of 5 s steps. */
export const MAX_FRAMES = 720;

/** Frames in the order of their time; a frame of a time already held replaces what follows. */
export function appendFrame(frames: Frame[], frame: Frame): Frame[] {
  const earlier = frames.at(-1);
  const kept =
    !earlier || earlier.time_s < frame.time_s
      ? frames
      : frames.filter((f) => f.time_s < frame.time_s);
  return [...kept.slice(-(MAX_FRAMES - 1)), frame];
}

/** Past frames are drawn as tracks and lines only: their sweeps need not be kept. */
export function dropSweeps(frame: Frame): void {
  delete frame.sweep;
  for (const target of frame.targets) delete target.q_sweep;
}
