/** What the alarm strip says without a CPA alarm: that there is none, or that none is computed. */

import type { AlarmLimits } from "../protocol.gen";
import type { Liveness } from "./liveness";
import { formatMiles } from "./units";

export interface CpaWatch {
  /** Whether alarms are computed for the picture shown. */
  active: boolean;
  text: string;
}

export function cpaWatch(liveness: Liveness, limits: AlarmLimits | null): CpaWatch {
  if (liveness.state === "stale" || liveness.state === "waiting" || !limits)
    return { active: false, text: "CPA not monitored: no current data" };
  const within = `${formatMiles(limits.dcpa_m)} NM, ${Math.round(limits.tcpa_s / 60)} min`;
  return { active: true, text: `No CPA alarm (limits ${within})` };
}
