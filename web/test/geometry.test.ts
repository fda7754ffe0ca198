import { describe, expect, it } from "vitest";

import {
  bearing,
  closestApproach,
  distance,
  DOMAIN_HALF_AXES_LOA,
  domainOutline,
  fromBody,
  type Motion,
  positionAfter,
  wrapAngle,
} from "../src/domain/geometry";
import { radians } from "../src/domain/units";

const motion = (
  east_m: number,
  north_m: number,
  course_deg: number,
  speed_m_s: number,
): Motion => ({
  east_m,
  north_m,
  course_rad: radians(course_deg),
  speed_m_s,
});

describe("closest approach", () => {
  it("is the minimum of the distance over time", () => {
    const own = motion(0, 0, 10, 5.1);
    const target = motion(6000, 5000, 260, 6.3);
    const cpa = closestApproach(own, target);
    let least = Infinity;
    let when = 0;
    for (let t = 0; t < 3600; t += 0.25) {
      const d = distance(positionAfter(own, t), positionAfter(target, t));
      if (d < least) [least, when] = [d, t];
    }
    expect(cpa.tcpa_s).toBeCloseTo(when, 0);
    expect(cpa.dcpa_m).toBeCloseTo(least, 2);
    expect(distance(cpa.own, cpa.target)).toBeCloseTo(cpa.dcpa_m, 9);
  });

  it("is now for ships without relative motion", () => {
    expect(closestApproach(motion(0, 0, 90, 5), motion(300, 400, 90, 5))).toMatchObject({
      tcpa_s: 0,
      dcpa_m: 500,
    });
  });

  it("is in the past for opening ships", () => {
    expect(closestApproach(motion(0, 0, 0, 5), motion(0, -500, 180, 5)).tcpa_s).toBeLessThan(0);
  });
});

describe("bearings", () => {
  it("run clockwise from north", () => {
    const here = { east_m: 0, north_m: 0 };
    expect(bearing(here, { east_m: 1, north_m: 0 })).toBeCloseTo(Math.PI / 2);
    expect(bearing(here, { east_m: -1, north_m: 0 })).toBeCloseTo((3 * Math.PI) / 2);
    expect(wrapAngle(radians(190))).toBeCloseTo(radians(-170));
    expect(wrapAngle(Math.PI)).toBeCloseTo(-Math.PI);
  });

  it("rotate the body frame by the heading", () => {
    const east = fromBody({ east_m: 10, north_m: 20 }, radians(90), { x: 0, y: 5 });
    expect(east.east_m).toBeCloseTo(15);
    expect(east.north_m).toBeCloseTo(20);
    const south = fromBody({ east_m: 0, north_m: 0 }, radians(90), { x: 3, y: 0 });
    expect(south.north_m).toBeCloseTo(-3);
  });
});

describe("the domain (Eq. 14-15)", () => {
  it("extends farthest ahead, and farther to starboard than to port", () => {
    const edge = domainOutline(340);
    const reach = (of: (p: { x: number; y: number }) => number): number =>
      Math.max(...edge.map(of));
    expect(reach((p) => p.y)).toBeCloseTo(6.4 * 340);
    expect(reach((p) => -p.y)).toBeCloseTo(1.6 * 340);
    expect(reach((p) => p.x)).toBeCloseTo(3.2 * 340);
    expect(reach((p) => -p.x)).toBeCloseTo(1.6 * 340);
  });

  it("lies where Eq. 13 is 0", () => {
    for (const p of domainOutline(340)) {
      const across = (p.x >= 0 ? DOMAIN_HALF_AXES_LOA.starboard : DOMAIN_HALF_AXES_LOA.port) * 340;
      const along = (p.y >= 0 ? DOMAIN_HALF_AXES_LOA.ahead : DOMAIN_HALF_AXES_LOA.astern) * 340;
      expect(Math.hypot(p.x / across, p.y / along)).toBeCloseTo(1, 9);
    }
  });
});
