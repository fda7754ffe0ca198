/** What is said where there is no CPA alarm: that there is none, or that nobody can tell. */

import type { Liveness } from "./liveness";
import { formatMiles } from "./units";
import type { Bounds } from "../protocol.gen";

export interface CpaWatch {
  /** Whether the alarms are of now, or of the instant that is looked at. */
  active: boolean;
  text: string;
}

export function cpaWatch(liveness: Liveness, limits: Bounds | null): CpaWatch {
  if (liveness.state === "stale" || liveness.state === "waiting" || !limits)
    return { active: false, text: "CPA not watched: no picture of now" };
  const within = `${formatMiles(limits.dcpa_m)} NM, ${Math.round(limits.tcpa_s / 60)} min`;
  return { active: true, text: `No CPA alarm (limits ${within})` };
}
