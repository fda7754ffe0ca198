import { describe, expect, it, vi } from "vitest";

import { bandForFrame, bracketEnds } from "../src/domain/certified-band";
import type { Banded } from "../src/protocol.gen";
import { frame, frameMessage, session } from "./fixtures";

vi.stubGlobal("location", { href: "http://here/" });
vi.stubGlobal("window", globalThis);
const { Store } = await import("../src/store");

const told = (some: Partial<Banded> = {}): Banded => ({
  type: "band",
  time_s: 5,
  pilot: "paper-sum",
  rudder_rad: 0.02,
  short: "certain: to starboard",
  full: "",
  band: { low_rad: 0.01, high_rad: 0.03, position_m: 10, course_rad: 0.0087, speed_m_s: 0.05 },
  ...some,
});

const shown = (time_s: number, rudder_rad: number, pilot = "paper-sum") =>
  frame(time_s, [], { pilot, decision: { rudder_rad } });

describe("a band belongs to one rudder", () => {
  it("of its time, its pilot and its angle", () => {
    expect(bandForFrame(told(), shown(5, 0.02))).toEqual(told());
    expect(bandForFrame(told(), shown(10, 0.02))).toBeNull();
    expect(bandForFrame(told(), shown(5, 0.021))).toBeNull();
    expect(bandForFrame(told(), shown(5, 0.02, "large-ship-sum"))).toBeNull();
    expect(bandForFrame(told(), null)).toBeNull();
    expect(bandForFrame(null, shown(5, 0.02))).toBeNull();
  });

  it("and says why there is none where nothing is advised", () => {
    const none = told({ rudder_rad: null, band: null, full: "no certified band" });
    expect(bandForFrame(none, frame(5, [], { pilot: "paper-sum" }))).toEqual(none);
  });
});

describe("the store", () => {
  it("shows a band until the next frame, and never beside another one", () => {
    const page = new Store();
    page.receive(session());
    page.receive(frameMessage(shown(5, 0.02)));
    expect(page.band).toBeNull();
    page.receive(told());
    expect(page.band?.short).toBe("certain: to starboard");
    page.receive(frameMessage(shown(10, 0.02)));
    expect(page.band).toBeNull();
    page.receive(told());
    expect(page.band).toBeNull();
  });

  it("forgets it with the voyage", () => {
    const page = new Store();
    page.receive(frameMessage(shown(5, 0.02)));
    page.receive(told());
    page.receive({ type: "history", frames: [shown(5, 0.02)], compare: [] });
    expect(page.band).toBeNull();
  });
});

describe("its place on a scale", () => {
  const x = (rad: number): number => 100 + 1000 * rad;

  it("is where its rudders are", () => {
    expect(bracketEnds(told().band!, x, 8)).toEqual([110, 130]);
  });

  it("is wide enough to be seen, about the same middle", () => {
    expect(bracketEnds({ low_rad: 0.02, high_rad: 0.02 }, x, 8)).toEqual([116, 124]);
  });
});
