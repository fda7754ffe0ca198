import { describe, expect, it } from "vitest";

import { radians } from "../src/domain/units";
import { compareVoyages, summariseVoyage } from "../src/domain/voyage-summary";
import { frame, target } from "./fixtures";

const own = (heading_deg: number) => ({
  east_m: 0,
  north_m: 0,
  heading_rad: radians(heading_deg),
  speed_m_s: 5,
  rate_of_turn_rad_s: 0,
});

const voyage = [
  frame(0, [target("1", { range_m: 900 }), target("2", { range_m: 4000 })], { own: own(-170) }),
  frame(5, [target("1", { range_m: 300, danger: 0.2 })], {
    own: own(175),
    reward: { waypoint: 0.2, collision: -0.5 },
  }),
  frame(10, [target("1", { range_m: 700 })], {
    own: own(170),
    decision: { rudder_rad: -0.05 },
    reward: { waypoint: 0.1, collision: 0 },
  }),
];

describe("the summary of a voyage", () => {
  it("has the nearest ship, time in the domain, total turn and reward", () => {
    const summary = summariseVoyage(voyage)!;
    expect(summary.nearest_m).toBe(300);
    expect(summary.nearest).toBe("ship 1");
    expect(summary.inDomain_s).toBe(5);
    expect(summary.turned_rad).toBeCloseTo(radians(20));
    expect(summary.reward).toBeCloseTo(-0.2);
    expect(summary.rudder_rad).toBe(-0.05);
  });

  it("has null for what the frames lack", () => {
    expect(summariseVoyage([frame(0)])).toMatchObject({
      nearest_m: null,
      reward: null,
      rudder_rad: null,
    });
    expect(summariseVoyage([])).toBeNull();
  });
});

it("compares the time that both voyages have in common", () => {
  const late = voyage.slice(1).map((f) => ({ ...f, pilot: "straight" }));
  const [first, second] = compareVoyages(voyage, late)!;
  expect(first.inDomain_s).toBe(0);
  expect(second.inDomain_s).toBe(0);
  expect(first.turned_rad).toBeCloseTo(radians(5));
  expect(compareVoyages(voyage, [])).toBeNull();
});
