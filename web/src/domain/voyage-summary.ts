/** Two pilots in the same encounter: what each has done so far. */

import { wrapAngle } from "./geometry";
import type { Frame } from "../protocol.gen";

export interface VoyageSummary {
  pilot: string;
  rudder_rad: number | null;
  /** The nearest that any ship has come so far, and who. */
  nearest_m: number | null;
  nearest: string | null;
  /** Steps with a ship inside the domain (Eq. 13 > 0). */
  inside_s: number;
  /** Sum of all changes of heading. */
  turned_rad: number;
  /** Sum of the rewards of the steps (Eq. 16-18), where frames carry them. */
  reward: number | null;
}

export function summariseVoyage(frames: readonly Frame[]): VoyageSummary | null {
  const last = frames.at(-1);
  if (!last) return null;
  const summary: VoyageSummary = {
    pilot: last.pilot,
    rudder_rad: last.decision?.rudder_rad ?? null,
    nearest_m: null,
    nearest: null,
    inside_s: 0,
    turned_rad: 0,
    reward: null,
  };
  let before: Frame | null = null;
  for (const frame of frames) {
    for (const target of frame.targets)
      if (summary.nearest_m === null || target.range_m < summary.nearest_m)
        [summary.nearest_m, summary.nearest] = [target.range_m, target.name];
    if (before) {
      if (frame.targets.some((t) => t.danger > 0)) summary.inside_s += frame.time_s - before.time_s;
      summary.turned_rad += Math.abs(wrapAngle(frame.own.heading_rad - before.own.heading_rad));
    }
    if (frame.reward) {
      const { waypoint, collision } = frame.reward;
      summary.reward = (summary.reward ?? 0) + waypoint + collision;
    }
    before = frame;
  }
  return summary;
}

/** Both accounts over the time that both have sailed. */
export function compareVoyages(
  frames: readonly Frame[],
  others: readonly Frame[],
): [VoyageSummary, VoyageSummary] | null {
  const from = Math.max(frames[0]?.time_s ?? 0, others[0]?.time_s ?? 0);
  const to = Math.min(frames.at(-1)?.time_s ?? -1, others.at(-1)?.time_s ?? -1);
  const common = (all: readonly Frame[]): Frame[] =>
    all.filter((f) => f.time_s >= from && f.time_s <= to);
  const [mine, hers] = [summariseVoyage(common(frames)), summariseVoyage(common(others))];
  return mine && hers ? [mine, hers] : null;
}
