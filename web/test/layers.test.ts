/** What the plan display draws: the recorded calls to its canvas. */

import { describe, expect, test } from "vitest";

import { closestApproach } from "../src/domain/geometry";
import { ownMotion } from "../src/domain/own-motion";
import { rankTargets } from "../src/domain/ranking";
import { View } from "../src/domain/view";
import { targetAt } from "../src/plan/hit-test";
import { drawPlan } from "../src/plan/layers";
import type { PlanColours } from "../src/plan/plan-colours";
import { describePlan } from "../src/plan/plan-description";
import { type Context, pixelsPerMetre, type Scene } from "../src/plan/scene";
import type { Alarm, Frame } from "../src/protocol.gen";
import { DEFAULT_SETTINGS } from "../src/settings";
import { alarm, frame, target } from "./fixtures";

const SIZE = 600;
const RADIUS = 266;
const INKS: PlanColours = {
  sea: "sea",
  ring: "ring",
  ringText: "ring-text",
  own: "own",
  other: "other",
  domain: "domain",
  path: "path",
  compare: "compare",
  whatIf: "what-if",
  alarm: "alarm",
  text: "ink",
  muted: "soft",
  line: "line",
  ships: ["#111111", "#222222"],
};

interface Call {
  name: string;
  args: number[];
  stroke: string;
  fill: string;
  width: number;
  dash: string;
}

/** A canvas that records all calls with their colours. */
function canvas(): { context: Context; calls: Call[] } {
  const calls: Call[] = [];
  const state: Record<string, unknown> = { globalAlpha: 1, dash: "" };
  const context = new Proxy(state, {
    get: (_, name: string) => {
      if (name in state && typeof state[name] !== "function") return state[name];
      if (name === "measureText") return (words: string) => ({ width: 7 * words.length });
      return (...args: never[]) => {
        if (name === "setLineDash") state.dash = String(args[0]);
        calls.push({
          name,
          args,
          stroke: String(state.strokeStyle),
          fill: String(state.fillStyle),
          width: Number(state.lineWidth),
          dash: String(state.dash),
        });
      };
    },
    set: (_, name: string, value) => ((state[name] = value), true),
  });
  return { context: context as unknown as Context, calls };
}

function scene(now: Frame, some: Partial<Scene> & { alarms?: Alarm[] } = {}): Scene {
  const settings = { ...DEFAULT_SETTINGS, range_nm: 6, ...some.settings };
  const view = new View(
    now.own,
    0,
    { x: SIZE / 2, y: SIZE / 2 },
    pixelsPerMetre(RADIUS, settings.range_nm),
  );
  return {
    frame: now,
    frames: [now],
    compare: [],
    path: [],
    whatIf: [],
    rows: rankTargets(now, some.alarms ?? [], 0.5),
    selected: null,
    hovered: null,
    colourIndex: () => null,
    colours: INKS,
    view,
    width: SIZE,
    height: SIZE,
    radius: RADIUS,
    flashOn: true,
    ...some,
    settings,
  };
}

function drawn(of: Scene): Call[] {
  const { context, calls } = canvas();
  drawPlan(context, of);
  return calls;
}

const arcs = (calls: Call[], ink: string, radius: number): Call[] =>
  calls.filter(
    (c) => c.name === "arc" && c.args[2] === radius && (c.stroke === ink || c.fill === ink),
  );

const near = (call: Call | undefined, p: { x: number; y: number }): void => {
  expect(call).toBeDefined();
  expect(Math.hypot(call!.args[0]! - p.x, call!.args[1]! - p.y)).toBeLessThan(0.01);
};

describe("own ship", () => {
  test("is two circles in the centre of six rings", () => {
    const calls = drawn(scene(frame(0)));
    near(arcs(calls, "own", 4)[0], { x: 300, y: 300 });
    near(arcs(calls, "own", 9)[0], { x: 300, y: 300 });
    for (let k = 1; k <= 6; k++) expect(arcs(calls, "ring", (RADIUS * k) / 6)).toHaveLength(1);
  });

  test("has a heading line to the outermost ring, and a vector of its run", () => {
    const of = scene(frame(0), { settings: { ...DEFAULT_SETTINGS, vector_min: 12 } });
    const ends = drawn(of).filter((c) => c.name === "lineTo" && c.stroke === "own");
    near(ends[0], { x: 300, y: 300 - RADIUS });
    const run = of.view.toScreen({ east_m: 0, north_m: 5.144 * 12 * 60 });
    expect(ends.some((c) => Math.hypot(c.args[0]! - run.x, c.args[1]! - run.y) < 0.01)).toBe(true);
  });

  test("has marks every five minutes on the predicted and the what-if track", () => {
    const path = Array.from({ length: 41 }, (_, k) => ({ east_m: 0, north_m: 154 * k }));
    const calls = drawn(scene(frame(0), { path, whatIf: path }));
    expect(arcs(calls, "path", 3.4)).toHaveLength(2 * 4); // filled, then outlined
    expect(arcs(calls, "what-if", 2.6)).toHaveLength(4);
  });

  test("is also drawn under the compared pilot, with that pilot's name", () => {
    const other = frame(0, [], { pilot: "straight", own: { ...frame(0).own, east_m: 1000 } });
    const of = scene(frame(0), { compare: [other] });
    near(arcs(drawn(of), "compare", 9)[0], of.view.toScreen({ east_m: 1000, north_m: 0 }));
    expect(drawn(of).some((c) => c.name === "fillText" && String(c.args[0]) === "straight")).toBe(
      true,
    );
  });
});

describe("the domain", () => {
  test("has the half axes of Eq. 14-15, and turns with own ship", () => {
    const east = { ...frame(0).own, heading_rad: Math.PI / 2 };
    const of = scene(frame(0, [], { own: east }));
    const edge = drawn(of).filter(
      (c) => c.stroke === "domain" && (c.name === "moveTo" || c.name === "lineTo"),
    );
    const at = (east_m: number, north_m: number): number => {
      const p = of.view.toScreen({ east_m, north_m });
      return Math.min(...edge.map((c) => Math.hypot(c.args[0]! - p.x, c.args[1]! - p.y)));
    };
    const loa = 340;
    expect(at(6.4 * loa, 0)).toBeLessThan(0.01); // ahead
    expect(at(-1.6 * loa, 0)).toBeLessThan(0.01); // astern
    expect(at(0, -3.2 * loa)).toBeLessThan(0.01); // starboard
    expect(at(0, 1.6 * loa)).toBeLessThan(0.01); // port
    const [first, last] = [edge[0]!, edge.at(-1)!];
    expect(first.args).toEqual(last.args); // closed
  });
});

describe("targets", () => {
  const triangles = (calls: Call[], ink: string): Call[] =>
    calls.filter((c) => c.name === "stroke" && c.stroke === ink && c.dash === "");

  test("under alarm are bold and red, and flash until acknowledged", () => {
    const now = frame(0, [target("1", { tcpa_s: -1 })]);
    const bold = (some: Partial<Scene> & { alarms?: Alarm[] }) =>
      triangles(drawn(scene(now, some)), "alarm").filter((c) => c.width === 3).length;
    expect(bold({})).toBe(0);
    expect(bold({ alarms: [alarm("1")] })).toBe(1);
    expect(bold({ alarms: [alarm("1")], flashOn: false })).toBe(0);
    expect(bold({ alarms: [alarm("1", { state: "acknowledged" })], flashOn: false })).toBe(1);
  });

  test("that are lost have no vector and no ghost", () => {
    const lines = (lost: boolean) => {
      const of = scene(frame(0, [target("1", { lost })]), { colourIndex: () => 0 });
      return drawn(of).filter(
        (c) => c.name === "lineTo" && c.stroke === "#111111" && c.dash === "6,4",
      );
    };
    expect(lines(false)).toHaveLength(1);
    expect(lines(true)).toHaveLength(0);
    const of = (lost: boolean) =>
      scene(frame(0, [target("1", { lost })]), { colourIndex: () => 0 });
    expect(arcs(drawn(of(false)), "#111111", 4)).toHaveLength(1);
    expect(arcs(drawn(of(true)), "#111111", 4)).toHaveLength(0);
  });

  test("that turn have a flag on that side of their vector's tip", () => {
    const flags = (turn_rad: number, lost = false, vectors: "true" | "relative" = "true") => {
      const frames = [0, 30].map((t, k) =>
        frame(t, [target("1", { course_rad: k * turn_rad, lost })]),
      );
      const of = scene(frames.at(-1)!, {
        frames,
        colourIndex: () => 0,
        settings: { ...DEFAULT_SETTINGS, vectors },
      });
      const lines = drawn(of).filter((c) => c.name === "moveTo" || c.name === "lineTo");
      const end = lines.find(
        (c) => c.name === "lineTo" && c.dash === "6,4" && c.stroke === "#111111",
      );
      const begun = lines.findIndex(
        (c) => c.name === "moveTo" && String(c.args) === String(end?.args),
      );
      return end && begun >= 0 ? lines.slice(begun, begun + 2) : [];
    };
    for (const [turn, vectors] of [
      [0.2, "true"],
      [-0.2, "true"],
      [0.2, "relative"],
      [-0.2, "relative"],
    ] as const) {
      const [end, tip] = flags(turn, false, vectors);
      expect(tip!.args[0]! - end!.args[0]!).toBeCloseTo(9 * Math.sign(turn) * Math.cos(0.2), 3);
      expect(tip!.args[1]! - end!.args[1]!).toBeCloseTo(9 * Math.sin(0.2), 3);
    }
    expect(flags(0.03)).toHaveLength(0); // less than 3 degrees
    expect(flags(0.2, true)).toHaveLength(0);
  });

  test("leave a trail of dots equally spaced in time, relative to own ship", () => {
    const frames = Array.from({ length: 73 }, (_, k) => {
      const t = 5 * k;
      const own = { ...frame(0).own, north_m: 5 * t };
      return frame(t, [target("1", { east_m: 2000, north_m: 2000 - 5 * t })], { own });
    });
    const of = scene(frames.at(-1)!, { frames });
    const dots = arcs(drawn(of), "other", 1);
    expect(dots).toHaveLength(12); // six minutes, every 30 s
    const ys = dots.map((c) => c.args[1]!).sort((a, b) => a - b);
    const step = 30 * 10 * of.view.px_m; // both ships' speeds
    ys.slice(1).forEach((y, k) => expect(y - ys[k]!).toBeCloseTo(step, 6));
    const off = scene(frames.at(-1)!, { frames, settings: { ...DEFAULT_SETTINGS, trail_min: 0 } });
    expect(arcs(drawn(off), "other", 1)).toHaveLength(0);
  });
});

describe("CPA ghosts", () => {
  const now = frame(0, [
    target("1", { east_m: 1500, north_m: 4000, course_rad: Math.PI, tcpa_s: 395, dcpa_m: 1500 }),
  ]);

  test("are at the closest point of approach", () => {
    const of = scene(now, { colourIndex: () => 0 });
    const cpa = closestApproach(ownMotion(now), now.targets[0]!);
    near(arcs(drawn(of), "#111111", 4)[0], of.view.toScreen(cpa.own));
    const calls = drawn(of).filter((c) => c.name === "translate");
    const ghost = of.view.toScreen(cpa.target);
    expect(calls.some((c) => Math.hypot(c.args[0]! - ghost.x, c.args[1]! - ghost.y) < 0.01)).toBe(
      true,
    );
  });

  test("are of coloured, alarmed or selected ships; the selected one has a label", () => {
    expect(arcs(drawn(scene(now)), "other", 4)).toHaveLength(0);
    expect(arcs(drawn(scene(now, { alarms: [alarm("1")] })), "alarm", 4)).toHaveLength(1);
    const calls = drawn(scene(now, { selected: "1" }));
    expect(arcs(calls, "other", 4)).toHaveLength(1);
    expect(
      calls.some((c) => c.name === "fillText" && String(c.args[0]) === "CPA 0.81 NM in 06:35"),
    ).toBe(true);
  });
});

test("the pointer finds the nearest ship, and the picture is described in words", () => {
  const now = frame(0, [
    target("1"),
    target("2", { east_m: 500, range_m: 5024, bearing_rad: 0.1 }),
  ]);
  const of = scene(now);
  const at = of.view.toScreen({ east_m: 480, north_m: 5000 });
  expect(targetAt(of, at)?.id).toBe("2");
  expect(targetAt(of, { x: 5, y: 5 })).toBeNull();
  expect(describePlan(of)).toContain(
    "north-up, relative motion, range 6 miles, rings every 1 NM; 2 ships",
  );
  expect(describePlan(of)).toContain("ship 2, 2.71 miles, 6° to starboard");
});
