import { describe, expect, it } from "vitest";

import { ColourRegistry, N_SHIP_COLOURS } from "../src/domain/colours";
import {
  compareByIntention,
  criticDanger,
  idsByProminence,
  rankTargets,
  roundScale,
} from "../src/domain/ranking";
import { alarm, frame, target } from "./fixtures";

const ids = (rows: { target: { id: string } }[]): string => rows.map((r) => r.target.id).join("");

describe("danger", () => {
  it("is zero for the value of a distant ship, and grows as Q falls", () => {
    expect(criticDanger(target("1", { q: -0.14, q_far: -0.14 }))).toBe(0);
    expect(criticDanger(target("1", { q: -2.14, q_far: -0.14 }))).toBeCloseTo(2);
    expect(criticDanger(target("1", { q: 0.1, q_far: -0.14 }))).toBeLessThan(0);
  });

  it("is null without a critic, not zero", () => {
    expect(criticDanger(target("1"))).toBeNull();
    expect(criticDanger(target("1", { q: -1, q_far: null }))).toBeNull();
  });

  it("has a round scale that is large enough", () => {
    expect([0, 0.3, 0.51, 1.2, 4, 13.9, 99, 101].map((v) => roundScale(v))).toEqual([
      0.5, 0.5, 1, 2, 5, 20, 100, 200,
    ]);
  });
});

describe("order", () => {
  it("puts the largest absolute intention first, and ships without one last", () => {
    const ships = [
      target("a"),
      target("b", { intention: -0.5 }),
      target("c", { intention: 0.2 }),
      target("d", { intention: 1.5 }),
    ];
    expect(ids(rankTargets(frame(0, ships), [], 1))).toBe("dbca");
  });

  it("puts unacknowledged alarms first, then the smallest TCPA, then other ships", () => {
    const ships = ["a", "b", "c", "d"].map((id, k) => target(id, { intention: 9 - k }));
    const alarms = [
      alarm("b", { state: "acknowledged", tcpa_s: 20 }),
      alarm("c", { tcpa_s: 90 }),
      alarm("d", { tcpa_s: 30 }),
    ];
    expect(ids(rankTargets(frame(0, ships), alarms, 1))).toBe("dcba");
  });

  it("breaks ties by attention, then danger, then closeness", () => {
    const zero = { intention: 0 };
    const ships = [
      target("near", { ...zero, attention: 0.1, dcpa_m: 10 }),
      target("seen", { ...zero, attention: 0.9 }),
    ];
    expect([...ships].sort(compareByIntention)[0]!.id).toBe("seen");
    const equal = [
      target("safe", { ...zero, q: -0.1, q_far: -0.1 }),
      target("fear", { ...zero, q: -3, q_far: -0.1 }),
    ];
    expect([...equal].sort(compareByIntention)[0]!.id).toBe("fear");
    const classical = [target("far", { dcpa_m: 9000 }), target("close", { dcpa_m: 50 })];
    expect([...classical].sort(compareByIntention)[0]!.id).toBe("close");
  });

  it("does not depend on the order in the frame", () => {
    const ships = ["1", "2", "10"].map((id) => target(id));
    expect(ids(rankTargets(frame(0, ships), [], 1))).toBe(
      ids(rankTargets(frame(0, ships.reverse()), [], 1)),
    );
  });
});

describe("coloured ships", () => {
  const noColour = (): boolean => false;

  it("include every ship under alarm, whatever its intention", () => {
    const ships = [1, 2, 3, 4].map((k) =>
      target(String(k), { intention: 9, attention: 0.3, tcpa_s: 60 }),
    );
    ships.push(target("quiet", { intention: 0, attention: 0, dcpa_m: 900 }));
    expect(idsByProminence(rankTargets(frame(0, ships), [alarm("quiet")], 1), noColour)[0]).toBe(
      "quiet",
    );
    expect(idsByProminence(rankTargets(frame(0, ships), [], 1), noColour).at(-1)).toBe("quiet");
  });

  it("are first those that the alarm strip names", () => {
    const all = Array.from({ length: N_SHIP_COLOURS + 3 }, (_, k) => `s${k}`);
    const ships = all.map((id) => target(id));
    const alarms = all.map((id, k) => alarm(id, { tcpa_s: 100 - k }));
    const order = idsByProminence(rankTargets(frame(0, ships), alarms, 1), (id) => id < "s6");
    expect(order.slice(0, 3)).toEqual(["s8", "s7", "s6"]);
  });

  it("do not swap colours back and forth", () => {
    const all = Array.from({ length: N_SHIP_COLOURS + 1 }, (_, k) => `s${k}`);
    for (const alarmed of [false, true]) {
      const registry = new ColourRegistry();
      /** The colours where the last two ships differ by a second of TCPA, to one side or the other. */
      const colours = (second: number): (number | null)[] => {
        const tcpa_s = (k: number): number => (k < N_SHIP_COLOURS - 1 ? 200 + k : 300 + k * second);
        const ships = all.map((id, k) => target(id, { tcpa_s: tcpa_s(k) }));
        const alarms = all.map((id, k) => alarm(id, { tcpa_s: tcpa_s(k) }));
        const rows = rankTargets(frame(0, ships), alarmed ? alarms : [], 1);
        registry.update(
          idsByProminence(rows, (id) => registry.indexOf(id) !== null),
          new Set(all),
        );
        return all.map((id) => registry.indexOf(id));
      };
      const first = colours(1);
      expect(first).toEqual([0, 1, 2, 3, 4, 5, null]);
      for (const second of [-1, 1, -1]) expect(colours(second)).toEqual(first);
    }
  });
});

describe("danger of a pilot that compares manoeuvres", () => {
  it("is what keeping course and speed would cost", () => {
    const avoided = target("1", { q: -2, q_far: 0, priority: 300, course_shapley_rad: 0.4 });
    expect(criticDanger(avoided)).toBe(302);
  });
});
