import { describe, expect, it } from "vitest";

import {
  ColourRegistry,
  contrast,
  linearRgb,
  luminance,
  N_SHIP_COLOURS,
  type Palette,
  PALETTES,
  SHIP_COLOURS,
  textColourOn,
} from "../src/domain/colours";
import css from "../src/style/theme.css?raw";

type Rgb = [number, number, number];

/** A colour of theme.css. */
function theme(palette: Palette, name: string): string {
  const block = css.split(`html[data-obc-theme="${palette}"]`)[1]!.split("}")[0]!;
  return new RegExp(`--gh-${name}: (#[0-9a-f]{6})`).exec(block)![1]!;
}

const apply = (m: readonly number[][], v: Rgb): Rgb =>
  m.map((row) =>
    Math.min(
      1,
      Math.max(
        0,
        row.reduce((s, x, k) => s + x * v[k]!, 0),
      ),
    ),
  ) as Rgb;

/** Colour vision deficiencies by Machado, Oliveira and Fernandes (2009), severity 1. */
const COLOUR_VISIONS: Record<string, number[][]> = {
  full: [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ],
  protan: [
    [0.152286, 1.052583, -0.204868],
    [0.114503, 0.786281, 0.099216],
    [-0.003882, -0.048116, 1.051998],
  ],
  deutan: [
    [0.367322, 0.860646, -0.227968],
    [0.280085, 0.672501, 0.047413],
    [-0.01182, 0.04294, 0.968881],
  ],
  tritan: [
    [1.255528, -0.076749, -0.178779],
    [-0.078411, 0.930809, 0.147602],
    [0.004733, 0.691367, 0.3039],
  ],
};

function lab(rgb: Rgb): Rgb {
  const xyz = apply(
    [
      [0.4124, 0.3576, 0.1805],
      [0.2126, 0.7152, 0.0722],
      [0.0193, 0.1192, 0.9505],
    ],
    rgb,
  );
  const white = [0.95047, 1, 1.08883];
  const [x, y, z] = xyz.map((v, k) => {
    const t = v / white[k]!;
    return t > 0.008856 ? Math.cbrt(t) : 7.787 * t + 16 / 116;
  }) as Rgb;
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

function difference(a: string, b: string, vision: number[][]): number {
  const [p, q] = [lab(apply(vision, linearRgb(a))), lab(apply(vision, linearRgb(b)))];
  return Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

describe.each(PALETTES)("the %s palette", (palette) => {
  const colours = SHIP_COLOURS[palette];

  it.each(Object.keys(COLOUR_VISIONS))("tells ships apart with %s colour vision", (vision) => {
    for (let i = 0; i < N_SHIP_COLOURS; i++)
      for (let j = 0; j < i; j++)
        expect(
          difference(colours[i]!, colours[j]!, COLOUR_VISIONS[vision]!),
          `${colours[i]} and ${colours[j]}`,
        ).toBeGreaterThan(12);
  });

  it("has no ship colour close to the red of alarms", () => {
    for (const colour of colours)
      expect(
        difference(colour, theme(palette, "alarm"), COLOUR_VISIONS.full!),
        colour,
      ).toBeGreaterThan(35);
  });

  it("has enough contrast with sea and panels (3:1), as have own ship and alarms", () => {
    for (const ground of ["sea", "panel"])
      for (const colour of [...colours, theme(palette, "own"), theme(palette, "alarm")])
        expect(contrast(colour, theme(palette, ground)), `${colour} on ${ground}`).toBeGreaterThan(
          3,
        );
  });

  it("has readable numbers on ship colours (4.5:1)", () => {
    for (const colour of colours)
      expect(contrast(colour, textColourOn(colour, palette)), colour).toBeGreaterThanOrEqual(4.5);
  });

  it("has readable text (4.5:1)", () => {
    const pairs = [
      ["text", "panel"],
      ["muted", "panel"],
      ["muted", "sea"],
      ["ring-text", "sea"],
      ["on-warn", "warn"],
      ["on-alarm", "alarm"],
      ["on-accent", "accent"],
      ["alarm", "panel"],
    ];
    for (const [ink, ground] of pairs)
      expect(
        contrast(theme(palette, ink!), theme(palette, ground!)),
        `${ink} on ${ground}`,
      ).toBeGreaterThanOrEqual(4.5);
  });
});

it("measures contrast as WCAG does", () => {
  expect(contrast("#000000", "#ffffff")).toBeCloseTo(21);
  expect(contrast("#777777", "#ffffff")).toBeCloseTo(4.48, 2);
});

it("does not dazzle at night", () => {
  for (const colour of [...SHIP_COLOURS.night, theme("night", "text"), theme("night", "own")])
    expect(luminance(colour), colour).toBeLessThan(0.3);
});

describe("the colour registry", () => {
  const sea = (...ids: string[]): Set<string> => new Set(ids);

  it("keeps a ship's colour while it is present", () => {
    const registry = new ColourRegistry();
    registry.update(["a", "b"], sea("a", "b", "c"));
    const before = registry.indexOf("b");
    registry.update(["c", "a"], sea("a", "b", "c"));
    expect(registry.indexOf("b")).toBe(before);
    expect(registry.indexOf("c")).not.toBe(before);
  });

  it("assigns no colour twice, and reassigns those of the least prominent ships", () => {
    const registry = new ColourRegistry();
    const all = Array.from({ length: N_SHIP_COLOURS + 2 }, (_, k) => `s${k}`);
    registry.update(all.slice(0, N_SHIP_COLOURS), new Set(all));
    registry.update(["s6", "s7", "s0", "s1", "s2", "s3"], new Set(all));
    const assigned = all.map((id) => registry.indexOf(id)).filter((p) => p !== null);
    expect(new Set(assigned).size).toBe(assigned.length);
    expect(assigned.length).toBe(N_SHIP_COLOURS);
    expect(registry.indexOf("s6")).not.toBeNull();
    expect(registry.indexOf("s0")).toBe(0);
  });

  it("gives ship 3 the third colour while it is free", () => {
    const registry = new ColourRegistry();
    registry.update(["3", "1", "230008070"], sea("3", "1", "230008070"));
    expect([registry.indexOf("3"), registry.indexOf("1"), registry.indexOf("230008070")]).toEqual([
      2, 0, 1,
    ]);
  });

  it("frees the colour of a ship that is gone", () => {
    const registry = new ColourRegistry();
    registry.update(["a"], sea("a"));
    registry.update(["b"], sea("b"));
    expect(registry.indexOf("a")).toBeNull();
    expect(registry.indexOf("b")).toBe(0);
  });
});
