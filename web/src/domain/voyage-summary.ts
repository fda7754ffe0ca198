/** Two pilots in the same encounter: what each has done so far. */

import { wrapped } from "./geometry";
import type { Frame } from "../protocol.gen";

export interface Account {
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

export function account(frames: readonly Frame[]): Account | null {
  const last = frames.at(-1);
  if (!last) return null;
  const told: Account = {
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
      if (told.nearest_m === null || target.range_m < told.nearest_m)
        [told.nearest_m, told.nearest] = [target.range_m, target.name];
    if (before) {
      if (frame.targets.some((t) => t.danger > 0)) told.inside_s += frame.time_s - before.time_s;
      told.turned_rad += Math.abs(wrapped(frame.own.heading_rad - before.own.heading_rad));
    }
    if (frame.reward) {
      const { waypoint, collision } = frame.reward;
      told.reward = (told.reward ?? 0) + waypoint + collision;
    }
    before = frame;
  }
  return told;
}

/** Both accounts over the time that both have sailed. */
export function compared(
  frames: readonly Frame[],
  others: readonly Frame[],
): [Account, Account] | null {
  const from = Math.max(frames[0]?.time_s ?? 0, others[0]?.time_s ?? 0);
  const to = Math.min(frames.at(-1)?.time_s ?? -1, others.at(-1)?.time_s ?? -1);
  const common = (all: readonly Frame[]): Frame[] =>
    all.filter((f) => f.time_s >= from && f.time_s <= to);
  const [mine, hers] = [account(common(frames)), account(common(others))];
  return mine && hers ? [mine, hers] : null;
}
