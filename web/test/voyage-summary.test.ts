import { describe, expect, it } from "vitest";

import { summariseVoyage, compareVoyages } from "../src/domain/voyage-summary";
import { radians } from "../src/domain/units";
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

describe("an account of a voyage", () => {
  it("names the nearest ship, the time inside the domain, the way turned and the reward", () => {
    const told = summariseVoyage(voyage)!;
    expect(told.nearest_m).toBe(300);
    expect(told.nearest).toBe("ship 1");
    expect(told.inDomain_s).toBe(5);
    expect(told.turned_rad).toBeCloseTo(radians(20));
    expect(told.reward).toBeCloseTo(-0.2);
    expect(told.rudder_rad).toBe(-0.05);
  });

  it("leaves out what the frames do not have", () => {
    expect(summariseVoyage([frame(0)])).toMatchObject({
      nearest_m: null,
      reward: null,
      rudder_rad: null,
    });
    expect(summariseVoyage([])).toBeNull();
  });
});

it("compares only the time that both have sailed", () => {
  const late = voyage.slice(1).map((f) => ({ ...f, pilot: "straight" }));
  const [mine, hers] = compareVoyages(voyage, late)!;
  expect(mine.inDomain_s).toBe(0);
  expect(hers.inDomain_s).toBe(0);
  expect(mine.turned_rad).toBeCloseTo(radians(5));
  expect(compareVoyages(voyage, [])).toBeNull();
});
