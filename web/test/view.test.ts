import { describe, expect, it } from "vitest";

import { milesToMetres, radians } from "../src/domain/units";
import {
  formatRingDistance,
  RANGE_SCALES_NM,
  stepThrough,
  upBearing,
  vectorEnd,
  View,
  viewCentre,
} from "../src/domain/view";
import { frame } from "./fixtures";

const own = { east_m: 1000, north_m: 2000 };

describe("view", () => {
  it("puts what lies ahead straight up in head up", () => {
    const heading = radians(70);
    const view = new View(own, heading, { x: 400, y: 300 }, 0.1);
    const ahead = view.toScreen({
      east_m: own.east_m + 1000 * Math.sin(heading),
      north_m: own.north_m + 1000 * Math.cos(heading),
    });
    expect(ahead.x).toBeCloseTo(400);
    expect(ahead.y).toBeCloseTo(200);
    expect(view.angle(heading)).toBeCloseTo(0);
  });

  it("puts east to the right in north up", () => {
    const p = new View(own, 0, { x: 0, y: 0 }, 1).toScreen({ east_m: 1005, north_m: 2000 });
    expect(p).toEqual({ x: 5, y: 0 });
  });
});

describe("orientation and motion", () => {
  const turning = frame(0, [], {
    own: { east_m: 0, north_m: 0, heading_rad: radians(40), speed_m_s: 5, rate_of_turn_rad_s: 0 },
    waypoint: { east_m: 1000, north_m: 1000 },
  });

  it("points north, the heading or the course up", () => {
    expect(upBearing("north-up", turning)).toBe(0);
    expect(upBearing("head-up", turning)).toBeCloseTo(radians(40));
    expect(upBearing("course-up", turning)).toBeCloseTo(radians(45));
  });

  it("centres own ship in relative motion", () => {
    expect(viewCentre("relative", turning, 6, { east_m: 9, north_m: 9 })).toBe(turning.own);
  });

  it("stays fixed in true motion until own ship nears the edge", () => {
    const still = { east_m: 0, north_m: milesToMetres(3) };
    expect(viewCentre("true", turning, 6, still)).toBe(still);
    const far = { east_m: 0, north_m: milesToMetres(3.7) };
    const reset = viewCentre("true", turning, 6, far);
    expect(reset).not.toBe(far);
    expect(Math.hypot(reset.east_m, reset.north_m)).toBeCloseTo(milesToMetres(3), 6);
  });
});

describe("vectors and scales", () => {
  it("has no relative vector for a ship that moves like own ship", () => {
    const end = vectorEnd(own, 1.2, 5, 6, { course_rad: 1.2, speed_m_s: 5 });
    expect(end.east_m).toBeCloseTo(own.east_m);
    expect(end.north_m).toBeCloseTo(own.north_m);
  });

  it("has true vectors of speed times time", () => {
    const end = vectorEnd(own, Math.PI / 2, 5, 6, null);
    expect(end.east_m - own.east_m).toBeCloseTo(1800);
  });

  it("formats ring distances, and stops at the ends of a list", () => {
    expect(formatRingDistance(0.75)).toBe("0.125");
    expect(formatRingDistance(24)).toBe("4");
    expect(stepThrough(RANGE_SCALES_NM, 24, 1)).toBe(24);
    expect(stepThrough(RANGE_SCALES_NM, 6, -1)).toBe(3);
  });
});
