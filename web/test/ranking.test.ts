import { describe, expect, it } from "vitest";

import { byIntention, dangerOf, foremost, ranked, roundScale } from "../src/domain/ranking";
import { alarm, frame, target } from "./frames";

const ids = (rows: { target: { id: string } }[]): string => rows.map((r) => r.target.id).join("");

describe("danger", () => {
  it("is zero where the critic values a ship as one far off, and grows as Q falls", () => {
    expect(dangerOf(target("1", { q: -0.14, q_far: -0.14 }))).toBe(0);
    expect(dangerOf(target("1", { q: -2.14, q_far: -0.14 }))).toBeCloseTo(2);
    expect(dangerOf(target("1", { q: 0.1, q_far: -0.14 }))).toBeLessThan(0);
  });

  it("is absent without a critic, not zero", () => {
    expect(dangerOf(target("1"))).toBeNull();
    expect(dangerOf(target("1", { q: -1, q_far: null }))).toBeNull();
  });

  it("has a round scale that holds every value", () => {
    expect([0, 0.3, 0.51, 1.2, 4, 13.9, 99, 101].map((v) => roundScale(v))).toEqual([
      0.5, 0.5, 1, 2, 5, 20, 100, 200,
    ]);
  });
});

describe("order", () => {
  it("puts the largest intention first, whichever its sign, and those without last", () => {
    const ships = [
      target("a"),
      target("b", { intention: -0.5 }),
      target("c", { intention: 0.2 }),
      target("d", { intention: 1.5 }),
    ];
    expect(ids(ranked(frame(0, ships), [], 1))).toBe("dbca");
  });

  it("goes by attention, then danger, then closeness where intention is equal", () => {
    const zero = { intention: 0 };
    const ships = [
      target("near", { ...zero, attention: 0.1, dcpa_m: 10 }),
      target("seen", { ...zero, attention: 0.9 }),
    ];
    expect([...ships].sort(byIntention)[0]!.id).toBe("seen");
    const equal = [
      target("safe", { ...zero, q: -0.1, q_far: -0.1 }),
      target("fear", { ...zero, q: -3, q_far: -0.1 }),
    ];
    expect([...equal].sort(byIntention)[0]!.id).toBe("fear");
    const classical = [target("far", { dcpa_m: 9000 }), target("close", { dcpa_m: 50 })];
    expect([...classical].sort(byIntention)[0]!.id).toBe("close");
  });

  it("does not depend on the order of the frame", () => {
    const ships = ["1", "2", "10"].map((id) => target(id));
    expect(ids(ranked(frame(0, ships), [], 1))).toBe(ids(ranked(frame(0, ships.reverse()), [], 1)));
  });
});

describe("ships of note", () => {
  it("hold every ship in alarm, whatever the pilot makes of her", () => {
    const ships = [1, 2, 3, 4].map((k) => target(String(k), { intention: 9, attention: 0.3, tcpa_s: 60 }));
    ships.push(target("quiet", { intention: 0, attention: 0, dcpa_m: 900 }));
    const rows = ranked(frame(0, ships), [alarm("quiet")], 1);
    expect(ids(foremost(rows, 2))).toContain("quiet");
    expect(ids(foremost(ranked(frame(0, ships), [], 1), 2))).not.toContain("quiet");
  });

  it("stay in the order of the list", () => {
    const ships = [target("a", { intention: 2 }), target("b", { intention: 1, attention: 1 })];
    expect(ids(foremost(ranked(frame(0, ships), [], 1), 2))).toBe("ab");
  });
});
