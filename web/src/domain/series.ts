/** Data of the plots: time in minutes and one column per line, `null` where a value is absent. */

import type { Frame, Target } from "../protocol.gen";
import { degrees } from "./units";

type Column = (number | null)[];
export type Table = [number[], ...Column[]];

function minutes(frames: readonly Frame[]): number[] {
  return frames.map((f) => f.time_s / 60);
}

/** The gain of the decided rudder over midships, for the waypoint and for all ships (Eq. 22). */
export function prioritySeries(frames: readonly Frame[]): Table {
  return [
    minutes(frames),
    frames.map((f) => f.priority?.waypoint ?? null),
    frames.map((f) => f.priority?.collision ?? null),
  ];
}

/** The rudder without other ships and each ship's share [°]: together they are the rudder. */
export function rudderShares(frames: readonly Frame[], ids: readonly string[]): Table {
  const [time, ...ships] = shipSeries(frames, ids, (t) =>
    t.shapley_rad == null ? null : degrees(t.shapley_rad),
  );
  const alone = frames.map((f) =>
    f.decision?.base_rad == null ? null : degrees(f.decision.base_rad),
  );
  return [time, alone, ...ships];
}

/** One value of each ship over time. */
export function shipSeries(
  frames: readonly Frame[],
  ids: readonly string[],
  value: (target: Target) => number | null | undefined,
): Table {
  const columns: Column[] = ids.map(() => []);
  for (const frame of frames) {
    const byId = new Map(frame.targets.map((t) => [t.id, t]));
    ids.forEach((id, k) => {
      const target = byId.get(id);
      columns[k]!.push(target ? (value(target) ?? null) : null);
    });
  }
  return [minutes(frames), ...columns];
}

const cache = new WeakMap<readonly Frame[], Map<string, Table>>();

/** A table made once per list of frames: lists are replaced, never changed. */
export function cachedTable(frames: readonly Frame[], name: string, make: () => Table): Table {
  const tables = cache.get(frames) ?? new Map<string, Table>();
  cache.set(frames, tables);
  const table = tables.get(name) ?? make();
  tables.set(name, table);
  return table;
}

export interface SweepTable {
  /** Starboard positive. */
  rudder_deg: number[];
  total: number[];
  waypoint: number[];
  ships: { id: string; values: number[] }[];
}

/** Q of each rudder minus Q of midships: total, of the waypoint and of each ship. */
export function sweepRelativeToMidships(frame: Frame, ids: readonly string[]): SweepTable | null {
  const sweep = frame.sweep;
  if (!sweep) return null;
  const midships = nearestIndex(sweep.rudder_rad, 0);
  const relative = (values: number[]): number[] => values.map((v) => v - (values[midships] ?? 0));
  const ships = ids.flatMap((id) => {
    const values = frame.targets.find((t) => t.id === id)?.q_sweep;
    return values ? [{ id, values: relative(values) }] : [];
  });
  return {
    rudder_deg: sweep.rudder_rad.map(degrees),
    total: relative(sweep.waypoint.map((w, k) => w + (sweep.collision[k] ?? 0))),
    waypoint: relative(sweep.waypoint),
    ships,
  };
}

function nearestIndex(values: readonly number[], value: number): number {
  let best = 0;
  values.forEach((v, k) => {
    if (Math.abs(v - value) < Math.abs((values[best] ?? Infinity) - value)) best = k;
  });
  return best;
}
