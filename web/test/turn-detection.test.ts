import { describe, expect, test } from "vitest";

import { turnDirection } from "../src/domain/turn-detection";
import { frame, target } from "./fixtures";

const seen = (...courses: (number | null)[]) =>
  courses.map((course_rad, k) =>
    frame(10 * k, course_rad === null ? [] : [target("1", { course_rad })]),
  );

describe("a ship", () => {
  test("turns where her course changes, through north too", () => {
    expect(turnDirection(seen(0, 0.1), "1")).toBe(1);
    expect(turnDirection(seen(0.05, 2 * Math.PI - 0.05), "1")).toBe(-1);
  });

  test("that yaws, was not there, or turned long ago does not", () => {
    expect(turnDirection(seen(0, 0.03, 0), "1")).toBe(0);
    expect(turnDirection(seen(1, null, 0), "1")).toBe(0);
    expect(turnDirection(seen(1, 0, 0, 0, 0, 0, 0, 0), "1")).toBe(0);
    expect(turnDirection([], "1")).toBe(0);
  });
});
