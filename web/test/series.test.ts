import { describe, expect, it } from "vitest";

import { appendFrame, MAX_FRAMES } from "../src/domain/history";
import {
  cachedTable,
  prioritySeries,
  rudderShares,
  shipSeries,
  sweepRelativeToMidships,
} from "../src/domain/series";
import { radians } from "../src/domain/units";
import { frame, target } from "./fixtures";

const sweep = {
  rudder_rad: [-2, -1, 0, 1, 2].map(radians),
  waypoint: [28, 29, 30, 29, 28],
  collision: [-9, -6, -3, -2, -1],
};

describe("plot data", () => {
  it("has a gap where a ship or a value is absent", () => {
    const frames = [
      frame(0, [target("1", { attention: 0.4 })]),
      frame(5, [target("2", { attention: 1 })]),
      frame(10, [target("1"), target("2", { attention: 0.7 })]),
    ];
    expect(shipSeries(frames, ["1", "2"], (t) => t.attention)).toEqual([
      [0, 5 / 60, 10 / 60],
      [0.4, null, null],
      [null, 1, 0.7],
    ]);
  });

  it("splits the rudder in degrees, with a gap where there are no shares", () => {
    const withShare = target("1", { shapley_rad: radians(3) });
    const frames = [
      frame(0),
      frame(60, [withShare], { decision: { rudder_rad: radians(2), base_rad: radians(-1) } }),
    ];
    const [, alone, ship] = rudderShares(frames, ["1"]);
    expect(alone![0]).toBeNull();
    expect(alone![1]).toBeCloseTo(-1);
    expect(ship![0]).toBeNull();
    expect(alone![1]! + ship![1]!).toBeCloseTo(2);
  });

  it("has the priorities of the frames", () => {
    const frames = [frame(0), frame(60, [], { priority: { waypoint: -0.3, collision: 0.5 } })];
    expect(prioritySeries(frames)).toEqual([
      [0, 1],
      [null, -0.3],
      [null, 0.5],
    ]);
  });
});

it("tables are cached per list of frames and name", () => {
  const frames = [frame(0)];
  let made = 0;
  const make = () => {
    made++;
    return prioritySeries(frames);
  };
  expect(cachedTable(frames, "a", make)).toBe(cachedTable(frames, "a", make));
  expect(made).toBe(1);
  cachedTable([...frames], "a", make);
  cachedTable(frames, "b", make);
  expect(made).toBe(3);
});

describe("the rudder sweep", () => {
  const here = frame(0, [target("1", { q_sweep: [-5, -4, -2, -1, 0] }), target("2")], { sweep });

  it("is zero at midships, in total and in each part", () => {
    const table = sweepRelativeToMidships(here, ["1"])!;
    expect(table.total[2]).toBe(0);
    expect(table.waypoint[2]).toBe(0);
    expect(table.ships[0]!.values[2]).toBe(0);
  });

  it("adds up the sub-tasks", () => {
    const table = sweepRelativeToMidships(here, [])!;
    expect(table.total).toEqual([-8, -4, 0, 0, 0]);
  });

  it("omits ships without a sweep, and is null without a critic", () => {
    expect(sweepRelativeToMidships(here, ["1", "2"])!.ships.map((s) => s.id)).toEqual(["1"]);
    expect(sweepRelativeToMidships(frame(0), [])).toBeNull();
  });
});

describe("the history of frames", () => {
  it("holds at most one hour", () => {
    let frames = [frame(0)];
    for (let k = 1; k < MAX_FRAMES + 50; k++) frames = appendFrame(frames, frame(5 * k));
    expect(frames.length).toBe(MAX_FRAMES);
    expect(frames.at(-1)!.time_s).toBe(5 * (MAX_FRAMES + 49));
  });

  it("drops later frames after a jump back in time", () => {
    const frames = [0, 5, 10, 15].map((t) => frame(t));
    expect(appendFrame(frames, frame(5)).map((f) => f.time_s)).toEqual([0, 5]);
  });
});
