import { describe, expect, it } from "vitest";

import {
  formatAge,
  formatCourse,
  formatDuration,
  formatMiles,
  formatRateOfTurn,
  formatRelativeBearing,
  formatRudder,
  formatTime,
  formatValue,
  knots,
  metresToMiles,
  milesToMetres,
  radians,
  rudderOrder,
  shortName,
} from "../src/domain/units";

describe("units", () => {
  it("converts knots and miles", () => {
    expect(knots(1852 / 3600)).toBeCloseTo(1, 12);
    expect(metresToMiles(milesToMetres(7.25))).toBeCloseTo(7.25, 12);
  });

  it("formats courses with three digits, never as 360", () => {
    expect(formatCourse(0)).toBe("000°");
    expect(formatCourse(radians(7.4))).toBe("007°");
    expect(formatCourse(radians(-0.4))).toBe("000°");
    expect(formatCourse(radians(359.7))).toBe("000°");
    expect(formatCourse(radians(-90))).toBe("270°");
    expect(formatCourse(radians(450))).toBe("090°");
  });

  it("formats rudder angles with their side, midships without", () => {
    expect(formatRudder(radians(2.54))).toBe("S 2.5°");
    expect(formatRudder(radians(-0.3))).toBe("P 0.3°");
    expect(formatRudder(radians(-0.04))).toBe("0.0°");
    expect(rudderOrder(radians(-3))).toEqual({ side: "Port", angle: "3.0°" });
    expect(rudderOrder(0.0001)).toEqual({ side: "Midships", angle: "0.0°" });
    expect(rudderOrder(radians(0.2))).toEqual({ side: "Midships", angle: "S 0.2°" });
    expect(rudderOrder(radians(-0.46))).toEqual({ side: "Port", angle: "0.5°" });
  });

  it("formats durations as minutes and seconds", () => {
    expect(formatDuration(81)).toBe("01:21");
    expect(formatDuration(59.6)).toBe("01:00");
    expect(formatDuration(3661)).toBe("1:01:01");
    expect(formatDuration(-30)).toBe("−00:30");
  });

  it("chooses the number of digits by size", () => {
    expect(formatMiles(1852 * 0.113)).toBe("0.11");
    expect(formatMiles(1852 * 12.34)).toBe("12.3");
    expect(formatAge(7.2)).toBe("7 s");
    expect(formatAge(240)).toBe("4 min");
    expect(formatValue(-0.104)).toBe("−0.10");
    expect(formatValue(0.0012)).toBe("+0.001");
    expect(formatValue(-0.0001)).toBe("0.000");
    expect(formatValue(13.86)).toBe("+13.9");
  });

  it("formats relative bearings as green and red", () => {
    expect(formatRelativeBearing(radians(45))).toBe("G 045°");
    expect(formatRelativeBearing(radians(-12))).toBe("R 012°");
    expect(formatRelativeBearing(0)).toBe("ahead");
    expect(formatRateOfTurn(radians(0.5))).toBe("S 30.0°/min");
  });

  it("prefers UTC where a source has it", () => {
    expect(formatTime(300, "2014-08-09T19:05:00Z")).toBe("19:05:00 UTC");
    expect(formatTime(300, null)).toBe("05:00");
    expect(formatTime(300, "nonsense")).toBe("05:00");
  });

  it("shortens names", () => {
    expect(shortName("MMSI 230008070")).toBe("230008070");
    expect(shortName("A very long ship's name indeed", 12)).toBe("A very long…");
  });
});
