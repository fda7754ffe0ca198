import { describe, expect, it, vi } from "vitest";

import { bandForFrame, bracketEnds } from "../src/domain/certified-band";
import type { BandMessage } from "../src/protocol.gen";
import { frame, frameMessage, session } from "./fixtures";

vi.stubGlobal("location", { href: "http://here/" });
vi.stubGlobal("window", globalThis);
const { Store } = await import("../src/store");

const band = (some: Partial<BandMessage> = {}): BandMessage => ({
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

describe("a band belongs to one frame", () => {
  it("with the same time, pilot and rudder", () => {
    expect(bandForFrame(band(), shown(5, 0.02))).toEqual(band());
    expect(bandForFrame(band(), shown(10, 0.02))).toBeNull();
    expect(bandForFrame(band(), shown(5, 0.021))).toBeNull();
    expect(bandForFrame(band(), shown(5, 0.02, "large-ship-sum"))).toBeNull();
    expect(bandForFrame(band(), null)).toBeNull();
    expect(bandForFrame(null, shown(5, 0.02))).toBeNull();
  });

  it("and says why there is none without advice", () => {
    const none = band({ rudder_rad: null, band: null, full: "no certified band" });
    expect(bandForFrame(none, frame(5, [], { pilot: "paper-sum" }))).toEqual(none);
  });
});

describe("the store", () => {
  it("shows a band until the next frame, never beside another one", () => {
    const store = new Store();
    store.receive(session());
    store.receive(frameMessage(shown(5, 0.02)));
    expect(store.band).toBeNull();
    store.receive(band());
    expect(store.band?.short).toBe("certain: to starboard");
    store.receive(frameMessage(shown(10, 0.02)));
    expect(store.band).toBeNull();
    store.receive(band());
    expect(store.band).toBeNull();
  });

  it("drops the band with a new history", () => {
    const store = new Store();
    store.receive(frameMessage(shown(5, 0.02)));
    store.receive(band());
    store.receive({ type: "history", frames: [shown(5, 0.02)], compare: [] });
    expect(store.band).toBeNull();
  });
});

describe("the bracket on a scale", () => {
  const x = (rad: number): number => 100 + 1000 * rad;

  it("spans the band", () => {
    expect(bracketEnds(band().band!, x, 8)).toEqual([110, 130]);
  });

  it("has a minimum width about the same middle", () => {
    expect(bracketEnds({ low_rad: 0.02, high_rad: 0.02 }, x, 8)).toEqual([116, 124]);
  });
});
