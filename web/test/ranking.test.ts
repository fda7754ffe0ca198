import { describe, expect, it } from "vitest";

import { ColourRegistry, N_SHIP_COLOURS } from "../src/domain/colours";
import {
  compareByIntention,
  idsByProminence,
  criticDanger,
  rankTargets,
  roundScale,
} from "../src/domain/ranking";
import { alarm, frame, target } from "./fixtures";

const ids = (rows: { target: { id: string } }[]): string => rows.map((r) => r.target.id).join("");

describe("danger", () => {
  it("is zero where the critic values a ship as one far off, and grows as Q falls", () => {
    expect(criticDanger(target("1", { q: -0.14, q_far: -0.14 }))).toBe(0);
    expect(criticDanger(target("1", { q: -2.14, q_far: -0.14 }))).toBeCloseTo(2);
    expect(criticDanger(target("1", { q: 0.1, q_far: -0.14 }))).toBeLessThan(0);
  });

  it("is absent without a critic, not zero", () => {
    expect(criticDanger(target("1"))).toBeNull();
    expect(criticDanger(target("1", { q: -1, q_far: null }))).toBeNull();
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
    expect(ids(rankTargets(frame(0, ships), [], 1))).toBe("dbca");
  });

  it("puts ships under alarm before all others, whom nobody has acknowledged and who come soonest", () => {
    const ships = ["a", "b", "c", "d"].map((id, k) => target(id, { intention: 9 - k }));
    const alarms = [
      alarm("b", { state: "acknowledged", tcpa_s: 20 }),
      alarm("c", { tcpa_s: 90 }),
      alarm("d", { tcpa_s: 30 }),
    ];
    expect(ids(rankTargets(frame(0, ships), alarms, 1))).toBe("dcba");
  });

  it("goes by attention, then danger, then closeness where intention is equal", () => {
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

  it("does not depend on the order of the frame", () => {
    const ships = ["1", "2", "10"].map((id) => target(id));
    expect(ids(rankTargets(frame(0, ships), [], 1))).toBe(
      ids(rankTargets(frame(0, ships.reverse()), [], 1)),
    );
  });
});

describe("ships of note", () => {
  const nobody = (): boolean => false;

  it("hold every ship in alarm, whatever the pilot makes of her", () => {
    const ships = [1, 2, 3, 4].map((k) =>
      target(String(k), { intention: 9, attention: 0.3, tcpa_s: 60 }),
    );
    ships.push(target("quiet", { intention: 0, attention: 0, dcpa_m: 900 }));
    expect(idsByProminence(rankTargets(frame(0, ships), [alarm("quiet")], 1), nobody)[0]).toBe(
      "quiet",
    );
    expect(idsByProminence(rankTargets(frame(0, ships), [], 1), nobody).at(-1)).toBe("quiet");
  });

  it("are those whom the alarms name first, before any who has a colour", () => {
    const all = Array.from({ length: N_SHIP_COLOURS + 3 }, (_, k) => `s${k}`);
    const ships = all.map((id) => target(id));
    const alarms = all.map((id, k) => alarm(id, { tcpa_s: 100 - k }));
    const order = idsByProminence(rankTargets(frame(0, ships), alarms, 1), (id) => id < "s6");
    expect(order.slice(0, 3)).toEqual(["s8", "s7", "s6"]);
  });

  it("do not take a colour from one another by turns", () => {
    const all = Array.from({ length: N_SHIP_COLOURS + 1 }, (_, k) => `s${k}`);
    for (const alarmed of [false, true]) {
      const book = new ColourRegistry();
      /** The last two are equally near, but for a second to one side or the other. */
      const look = (second: number): (number | null)[] => {
        const tcpa_s = (k: number): number => (k < N_SHIP_COLOURS - 1 ? 200 + k : 300 + k * second);
        const ships = all.map((id, k) => target(id, { tcpa_s: tcpa_s(k) }));
        const alarms = all.map((id, k) => alarm(id, { tcpa_s: tcpa_s(k) }));
        const rows = rankTargets(frame(0, ships), alarmed ? alarms : [], 1);
        book.update(
          idsByProminence(rows, (id) => book.indexOf(id) !== null),
          new Set(all),
        );
        return all.map((id) => book.indexOf(id));
      };
      const first = look(1);
      expect(first).toEqual([0, 1, 2, 3, 4, 5, null]);
      for (const second of [-1, 1, -1]) expect(look(second)).toEqual(first);
    }
  });
});
