/** How old the data shown is, and whether the picture is live: stale data is never shown as live. */

import type { SessionMessage } from "../protocol.gen";

export interface ConnectionStatus {
  open: boolean;
  /** Time since it was opened, or lost. */
  since_s: number;
}

export interface Liveness {
  state: "live" | "playing" | "paused" | "ended" | "waiting" | "stale";
  text: string;
}

/** One time step of the simulation [s]. */
const STEP_S = 5;
/** A frame may be late by so much before the picture is stale [s]. */
const GRACE_S = 10;
/** Live data older than this makes the picture stale [s]. */
export const MAX_DATA_AGE_S = 30;

/**
 * The state of the picture. `frameAge_s` is the time since the last frame arrived (`null`: none
 * yet), `sessionAge_s` the time since the session's ages were sent, both by this computer's clock.
 */
export function liveness(
  connection: ConnectionStatus,
  session: SessionMessage | null,
  frameAge_s: number | null,
  sessionAge_s: number,
): Liveness {
  if (!connection.open)
    return frameAge_s === null
      ? { state: "waiting", text: "Connecting to the server" }
      : stale(`No connection for ${Math.round(connection.since_s)} s`);
  if (!session || frameAge_s === null)
    return { state: "waiting", text: "Waiting for the first frame" };
  if (session.mode === "live") {
    if (!session.connected) return stale("Source not connected");
    const traffic_s =
      session.last_report_age_s === null ? frameAge_s : session.last_report_age_s + sessionAge_s;
    const own_s =
      session.own_position_age_s === null ? frameAge_s : session.own_position_age_s + sessionAge_s;
    if (traffic_s > MAX_DATA_AGE_S) return stale(`No data for ${Math.round(traffic_s)} s`);
    if (own_s > MAX_DATA_AGE_S) return stale(`Own position ${Math.round(own_s)} s old`);
    if (frameAge_s > MAX_DATA_AGE_S) return stale(`No new frame for ${Math.round(frameAge_s)} s`);
    return { state: "live", text: "Live" };
  }
  if (session.end_s !== null && session.time_s >= session.end_s && !session.playing)
    return { state: "ended", text: "End" };
  if (!session.playing) return { state: "paused", text: "Paused" };
  if (frameAge_s > GRACE_S + STEP_S / Math.max(session.rate, 0.1))
    return stale(`No new frame for ${Math.round(frameAge_s)} s`);
  return { state: "playing", text: session.rate === 1 ? "Playing" : `Playing ×${session.rate}` };
}

/**
 * Seconds since the data of the frame shown was received. Live frames continue for a while without
 * new data, so there the ages that the session reports count, not that of the frame.
 */
export function dataAge(
  session: SessionMessage | null,
  frameAge_s: number | null,
  sessionAge_s: number,
): number | null {
  if (frameAge_s === null || session?.mode !== "live") return frameAge_s;
  const ages = [session.last_report_age_s, session.own_position_age_s].filter(
    (age_s) => age_s !== null,
  );
  return ages.length ? Math.max(...ages) + sessionAge_s : frameAge_s;
}

const stale = (text: string): Liveness => ({ state: "stale", text });
