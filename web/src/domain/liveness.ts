/** Whether what is on the screen is now: stale data is never shown as live. */

import type { Session } from "../wire";

export type LinkView = { open: boolean; since_s: number };

export type Liveness =
  | { state: "live" | "playing" | "paused" | "ended"; text: string }
  | { state: "waiting"; text: string }
  | { state: "stale"; text: string };

/** A step of the world [s]. */
const STEP_S = 5;
/** Seconds of grace before a missing frame is called missing. */
const GRACE_S = 10;
/** A live source that was not heard for so long is silent. */
export const SILENT_S = 30;

/**
 * What to say of the picture. `frame_s` is the time since the last frame came in (`null`:
 * none yet), by this computer's own clock.
 */
export function liveness(
  link: LinkView,
  session: Session | null,
  frame_s: number | null,
): Liveness {
  if (!link.open)
    return frame_s === null
      ? { state: "waiting", text: "Connecting to the server" }
      : { state: "stale", text: `No connection for ${Math.round(link.since_s)} s` };
  if (!session || frame_s === null) return { state: "waiting", text: "Waiting for the first frame" };
  if (session.mode === "live") {
    const heard = session.heard_s ?? null;
    if (session.connected === false) return { state: "stale", text: "The source is not connected" };
    const silent = heard === null ? frame_s : heard + frame_s;
    if (silent > SILENT_S)
      return { state: "stale", text: `Nothing heard for ${Math.round(silent)} s` };
    return { state: "live", text: "Live" };
  }
  if (session.end_s !== null && session.time_s >= session.end_s && !session.playing)
    return { state: "ended", text: "End" };
  if (!session.playing) return { state: "paused", text: "Paused" };
  if (frame_s > GRACE_S + STEP_S / Math.max(session.rate, 0.1))
    return { state: "stale", text: `No new frame for ${Math.round(frame_s)} s` };
  return { state: "playing", text: session.rate === 1 ? "Playing" : `Playing ×${session.rate}` };
}
