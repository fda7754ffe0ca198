/** Two pilots in the same encounter: what each has done so far. */

import type { Frame } from "../protocol.gen";
import { wrapAngle } from "./geometry";

export interface VoyageSummary {
  pilot: string;
  rudder_rad: number | null;
  /** The smallest range to any target so far, and that target's name. */
  nearest_m: number | null;
  nearest: string | null;
  /** Time with a target inside the ship domain (Eq. 13 > 0). */
  inDomain_s: number;
  /** Sum of the absolute changes of heading. */
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
    inDomain_s: 0,
    turned_rad: 0,
    reward: null,
  };
  let before: Frame | null = null;
  for (const frame of frames) {
    for (const target of frame.targets)
      if (summary.nearest_m === null || target.range_m < summary.nearest_m)
        [summary.nearest_m, summary.nearest] = [target.range_m, target.name];
    if (before) {
      if (frame.targets.some((t) => t.danger > 0))
        summary.inDomain_s += frame.time_s - before.time_s;
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

/** The summaries of both voyages over the time that they have in common. */
export function compareVoyages(
  frames: readonly Frame[],
  compared: readonly Frame[],
): [VoyageSummary, VoyageSummary] | null {
  const from = Math.max(frames[0]?.time_s ?? 0, compared[0]?.time_s ?? 0);
  const to = Math.min(frames.at(-1)?.time_s ?? -1, compared.at(-1)?.time_s ?? -1);
  const common = (all: readonly Frame[]): Frame[] =>
    all.filter((f) => f.time_s >= from && f.time_s <= to);
  const [first, second] = [summariseVoyage(common(frames)), summariseVoyage(common(compared))];
  return first && second ? [first, second] : null;
}
