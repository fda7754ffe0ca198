import { describe, expect, it } from "vitest";

import {
  age,
  amount,
  clock,
  course,
  instant,
  knots,
  metres,
  miles,
  nm,
  radians,
  rateOfTurn,
  relativeBearing,
  rudder,
  rudderWords,
  shipName,
} from "../src/domain/units";

describe("units", () => {
  it("knows the knot and the mile", () => {
    expect(knots(1852 / 3600)).toBeCloseTo(1, 12);
    expect(nm(metres(7.25))).toBeCloseTo(7.25, 12);
  });

  it("writes courses with three digits and never 360", () => {
    expect(course(0)).toBe("000°");
    expect(course(radians(7.4))).toBe("007°");
    expect(course(radians(-0.4))).toBe("000°");
    expect(course(radians(359.7))).toBe("000°");
    expect(course(radians(-90))).toBe("270°");
    expect(course(radians(450))).toBe("090°");
  });

  it("says the side of a rudder, and none amidships", () => {
    expect(rudder(radians(2.54))).toBe("S 2.5°");
    expect(rudder(radians(-0.3))).toBe("P 0.3°");
    expect(rudder(radians(-0.04))).toBe("0.0°");
    expect(rudderWords(radians(-3))).toEqual({ side: "Port", angle: "3.0°" });
    expect(rudderWords(0.0001)).toEqual({ side: "Midships", angle: "0.0°" });
    expect(rudderWords(radians(0.2))).toEqual({ side: "Midships", angle: "S 0.2°" });
    expect(rudderWords(radians(-0.46))).toEqual({ side: "Port", angle: "0.5°" });
  });

  it("writes spans as minutes and seconds", () => {
    expect(clock(81)).toBe("01:21");
    expect(clock(59.6)).toBe("01:00");
    expect(clock(3661)).toBe("1:01:01");
    expect(clock(-30)).toBe("−00:30");
  });

  it("chooses digits by size", () => {
    expect(miles(1852 * 0.113)).toBe("0.11");
    expect(miles(1852 * 12.34)).toBe("12.3");
    expect(age(7.2)).toBe("7 s");
    expect(age(240)).toBe("4 min");
    expect(amount(-0.104)).toBe("−0.10");
    expect(amount(0.0012)).toBe("+0.001");
    expect(amount(-0.0001)).toBe("0.000");
    expect(amount(13.86)).toBe("+13.9");
  });

  it("says bearings as on a bridge", () => {
    expect(relativeBearing(radians(45))).toBe("G 045°");
    expect(relativeBearing(radians(-12))).toBe("R 012°");
    expect(relativeBearing(0)).toBe("ahead");
    expect(rateOfTurn(radians(0.5))).toBe("S 30.0°/min");
  });

  it("prefers UTC where a source has it", () => {
    expect(instant(300, "2014-08-09T19:05:00Z")).toBe("19:05:00 UTC");
    expect(instant(300, null)).toBe("05:00");
    expect(instant(300, "nonsense")).toBe("05:00");
  });

  it("shortens names without losing them", () => {
    expect(shipName("MMSI 230008070")).toBe("230008070");
    expect(shipName("A very long ship's name indeed", 12)).toBe("A very long…");
  });
});
