/** Rows for the plots: time in minutes, one column a line, `null` where a frame lacks the value. */

import { degrees } from "./units";
import type { Frame, Target } from "../protocol.gen";

export type Column = (number | null)[];
export type Table = [number[], ...Column[]];

export function minutes(frames: readonly Frame[]): number[] {
  return frames.map((f) => f.time_s / 60);
}

/** Eq. 22: what the decided rudder gains over rudder 0 for the course and for all ships. */
export function prioritySeries(frames: readonly Frame[]): Table {
  return [
    minutes(frames),
    frames.map((f) => f.priority?.waypoint ?? null),
    frames.map((f) => f.priority?.collision ?? null),
  ];
}

/** Degrees of rudder with nobody there, and each named ship's share: they add up to the rudder. */
export function rudderShares(frames: readonly Frame[], ids: readonly string[]): Table {
  const [time, ...ships] = shipSeries(frames, ids, (t) =>
    t.shapley_rad == null ? null : degrees(t.shapley_rad),
  );
  const alone = frames.map((f) =>
    f.decision?.alone_rad == null ? null : degrees(f.decision.alone_rad),
  );
  return [time, alone, ...ships];
}

/** One value of each of the named ships over time. */
export function shipSeries(
  frames: readonly Frame[],
  ids: readonly string[],
  value: (target: Target) => number | null | undefined,
): Table {
  const columns: Column[] = ids.map(() => []);
  for (const frame of frames) {
    const here = new Map(frame.targets.map((t) => [t.id, t]));
    ids.forEach((id, k) => {
      const target = here.get(id);
      columns[k]!.push(target ? (value(target) ?? null) : null);
    });
  }
  return [minutes(frames), ...columns];
}

const cache = new WeakMap<readonly Frame[], Map<string, Table>>();

/** A table of these very frames, made once: lists of frames are never changed, only replaced. */
export function cachedTable(frames: readonly Frame[], name: string, make: () => Table): Table {
  const tables = cache.get(frames) ?? new Map<string, Table>();
  cache.set(frames, tables);
  const table = tables.get(name) ?? make();
  tables.set(name, table);
  return table;
}

export interface SweepTable {
  /** Rudder in degrees, + starboard. */
  rudder_deg: number[];
  total: number[];
  waypoint: number[];
  ships: { id: string; values: number[] }[];
}

/** Q of every rudder minus Q of rudder 0, split by sub-task and by the named ships. */
export function sweepRelativeToMidships(frame: Frame, ids: readonly string[]): SweepTable | null {
  const sweep = frame.sweep;
  if (!sweep) return null;
  const zero = nearestIndex(sweep.rudder_rad, 0);
  const less = (values: number[]): number[] => values.map((v) => v - (values[zero] ?? 0));
  const ships = ids.flatMap((id) => {
    const values = frame.targets.find((t) => t.id === id)?.q_sweep;
    return values ? [{ id, values: less(values) }] : [];
  });
  return {
    rudder_deg: sweep.rudder_rad.map(degrees),
    total: less(sweep.waypoint.map((w, k) => w + (sweep.collision[k] ?? 0))),
    waypoint: less(sweep.waypoint),
    ships,
  };
}

export function nearestIndex(values: readonly number[], wanted: number): number {
  let best = 0;
  values.forEach((v, k) => {
    if (Math.abs(v - wanted) < Math.abs((values[best] ?? Infinity) - wanted)) best = k;
  });
  return best;
}
