import { describe, expect, it } from "vitest";

import { comparedCourses } from "../src/domain/alternatives";
import type { Alternative } from "../src/protocol.gen";
import { frame, target } from "./fixtures";

const alternative = (
  name: string,
  waypoint: number,
  helm: number,
  by_target: Record<string, number>,
): Alternative => {
  const collision = Object.values(by_target).reduce((sum, q) => sum + q, 0);
  const value = { waypoint, collision, helm, total: waypoint + collision + helm };
  return { name, course_rad: 0.5, value, by_target };
};

const shown = frame(0, [target("1", { q: -2 }), target("2", { q: 0 })], {
  value: { waypoint: 80, collision: -2, helm: -4, total: 74 },
  alternatives: [
    alternative("keep", 90, 0, { "1": -500, "2": -1 }),
    alternative("best to starboard", 80, -4, { "1": -2, "2": 0 }),
    alternative("best to port", 60, -4, { "1": -2, "2": 0 }),
    alternative("without ships", 90, 0, { "1": -500, "2": -1 }),
  ],
});

describe("compared courses", () => {
  it("are in the order of the table, those that there are", () => {
    expect(comparedCourses(shown).map((c) => c.label)).toEqual([
      "Starboard",
      "Port",
      "Keep course",
    ]);
  });

  it("say what they cost and for whom", () => {
    const [starboard, port, keep] = comparedCourses(shown);
    expect(starboard).toMatchObject({ loss: 0, reason: null });
    expect(port).toMatchObject({ loss: 20, reason: { task: "waypoint" }, reasonLoss: 20 });
    expect(keep).toMatchObject({ loss: 485, reason: { ship: "1" }, reasonLoss: 498 });
  });

  it("are none for a pilot that compares none", () => {
    expect(comparedCourses(frame(0))).toEqual([]);
  });
});
