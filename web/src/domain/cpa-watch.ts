/** What is said where there is no CPA alarm: that there is none, or that nobody can tell. */

import type { Liveness } from "./liveness";
import { miles } from "./units";
import type { Bounds } from "../protocol.gen";

export interface Quiet {
  /** Whether the alarms are of now, or of the instant that is looked at. */
  watched: boolean;
  text: string;
}

export function quiet(alive: Liveness, limits: Bounds | null): Quiet {
  if (alive.state === "stale" || alive.state === "waiting" || !limits)
    return { watched: false, text: "CPA not watched: no picture of now" };
  const within = `${miles(limits.dcpa_m)} NM, ${Math.round(limits.tcpa_s / 60)} min`;
  return { watched: true, text: `No CPA alarm (limits ${within})` };
}
