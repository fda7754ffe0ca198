import { describe, expect, test } from "vitest";

import { turnDirection } from "../src/domain/turn-detection";
import { frame, target } from "./fixtures";

const seen = (...courses: (number | null)[]) =>
  courses.map((course_rad, k) =>
    frame(10 * k, course_rad === null ? [] : [target("1", { course_rad })]),
  );

describe("a turn", () => {
  test("is a change of course, also through north", () => {
    expect(turnDirection(seen(0, 0.1), "1")).toBe(1);
    expect(turnDirection(seen(0.05, 2 * Math.PI - 0.05), "1")).toBe(-1);
  });

  test("is not yaw, a gap in the data, or a change long ago", () => {
    expect(turnDirection(seen(0, 0.03, 0), "1")).toBe(0);
    expect(turnDirection(seen(1, null, 0), "1")).toBe(0);
    expect(turnDirection(seen(1, 0, 0, 0, 0, 0, 0, 0), "1")).toBe(0);
    expect(turnDirection([], "1")).toBe(0);
  });
});
