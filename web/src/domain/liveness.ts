/** Whether what is on the screen is now: stale data is never shown as live. */

import type { Session } from "../protocol.gen";

export interface ConnectionStatus {
  open: boolean;
  since_s: number;
}

export type Liveness =
  | { state: "live" | "playing" | "paused" | "ended"; text: string }
  | { state: "waiting"; text: string }
  | { state: "stale"; text: string };

/** A step of the world [s]. */
const STEP_S = 5;
/** Seconds of grace before a missing frame is called missing. */
const GRACE_S = 10;
/** A live source that was not heard for so long is silent, own ship's position so old is not now. */
export const MAX_DATA_AGE_S = 30;

/**
 * What to say of the picture. `frame_s` is the time since the last frame came in (`null`:
 * none yet), `said_s` since the session's ages were said, by this computer's own clock.
 */
export function liveness(
  link: ConnectionStatus,
  session: Session | null,
  frame_s: number | null,
  said_s: number,
): Liveness {
  if (!link.open)
    return frame_s === null
      ? { state: "waiting", text: "Connecting to the server" }
      : stale(`No connection for ${Math.round(link.since_s)} s`);
  if (!session || frame_s === null)
    return { state: "waiting", text: "Waiting for the first frame" };
  if (session.mode === "live") {
    if (session.connected === false) return stale("The source is not connected");
    const silent = age(session.heard_s, said_s, frame_s);
    const own = age(session.own_s, said_s, frame_s);
    if (silent > MAX_DATA_AGE_S) return stale(`Nothing heard for ${Math.round(silent)} s`);
    if (own > MAX_DATA_AGE_S) return stale(`Own position ${Math.round(own)} s old`);
    if (frame_s > MAX_DATA_AGE_S) return stale(`No new frame for ${Math.round(frame_s)} s`);
    return { state: "live", text: "Live" };
  }
  if (session.end_s !== null && session.time_s >= session.end_s && !session.playing)
    return { state: "ended", text: "End" };
  if (!session.playing) return { state: "paused", text: "Paused" };
  if (frame_s > GRACE_S + STEP_S / Math.max(session.rate, 0.1))
    return stale(`No new frame for ${Math.round(frame_s)} s`);
  return { state: "playing", text: session.rate === 1 ? "Playing" : `Playing ×${session.rate}` };
}

/** Now, of what had an age when that was said; what nobody told is as old as the last frame. */
function age(told_s: number | null | undefined, said_s: number, frame_s: number): number {
  return told_s === null || told_s === undefined ? frame_s : told_s + said_s;
}

function stale(text: string): Liveness {
  return { state: "stale", text };
}
