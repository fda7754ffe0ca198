import { describe, expect, it } from "vitest";

import { deadReckon, MAX_DEAD_RECKONING_S } from "../src/domain/dead-reckoning";
import { closestApproach } from "../src/domain/geometry";
import { frame, target } from "./fixtures";

const before = frame(
  10,
  [
    target("1", { speed_m_s: 7, age_s: 3, dcpa_m: 0, tcpa_s: 411 }),
    target("2", { east_m: 1000, north_m: 0, lost: true, age_s: 370 }),
  ],
  { time_utc: "2014-08-15T17:00:10Z" },
);

describe("dead reckoning between two live frames", () => {
  const now = deadReckon(before, 4);
  const [one, lost] = now.targets;

  it("moves own ship, targets and time", () => {
    expect(now.own.north_m).toBeCloseTo(4 * 5.144, 6);
    expect(one!.north_m).toBeCloseTo(5000 - 4 * 7, 6);
    expect(one!.range_m).toBeCloseTo(5000 - 4 * (7 + 5.144), 6);
    expect(now.time_s).toBe(14);
    expect(now.time_utc).toBe("2014-08-15T17:00:14.000Z");
  });

  it("increases ages, and keeps the position of a lost ship", () => {
    expect(now.targets.map((t) => t.age_s)).toEqual([7, 374]);
    expect([lost!.east_m, lost!.north_m]).toEqual([1000, 0]);
    expect(lost!.bearing_rad).toBeGreaterThan(Math.PI / 2);
  });

  it("keeps the CPA and its position", () => {
    expect([one!.dcpa_m, one!.tcpa_s]).toEqual([0, 411]);
    const motion = (f: typeof before) => ({ ...f.own, course_rad: f.own.heading_rad });
    const [was, is] = [before, now].map((f) => closestApproach(motion(f), f.targets[0]!));
    expect(is!.target.north_m).toBeCloseTo(was!.target.north_m, 6);
  });

  it("is limited in time, and leaves the frame unchanged", () => {
    expect(deadReckon(before, 60)).toEqual(deadReckon(before, MAX_DEAD_RECKONING_S));
    expect(deadReckon(before, 0)).toBe(before);
    expect(before.targets[0]!.age_s).toBe(3);
  });
});
