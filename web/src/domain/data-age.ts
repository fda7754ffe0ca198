/** How old what is shown is. */

import type { Session } from "../protocol.gen";

/**
 * Seconds since the data of the frame shown were heard. Frames of live traffic go on for a while
 * when nothing is heard, so that the age of the last one (`frame_s`) says too little there: `said_s`
 * is the time since the session told the ages of its data.
 */
export function dataAge(
  session: Session | null,
  frame_s: number | null,
  said_s: number,
): number | null {
  if (frame_s === null || session?.mode !== "live") return frame_s;
  const told = [session.heard_s, session.own_s].filter((age_s) => age_s != null);
  return told.length ? Math.max(...told) + said_s : frame_s;
}
