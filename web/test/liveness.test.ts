import { describe, expect, it } from "vitest";

import { dataAge, liveness, MAX_DATA_AGE_S } from "../src/domain/liveness";
import { session } from "./fixtures";

const open = { open: true, since_s: 100 };
const shut = { open: false, since_s: 7 };

describe("stale data is never shown as live", () => {
  it("when the connection is lost", () => {
    for (const mode of ["simulated", "recorded", "live", "replay"] as const)
      expect(
        liveness(shut, session({ mode, connected: true, last_report_age_s: 0 }), 1, 0).state,
      ).toBe("stale");
    expect(liveness(shut, null, null, 0).state).toBe("waiting");
  });

  it("when a live source is silent or disconnected", () => {
    const live = session({
      mode: "live",
      connected: true,
      last_report_age_s: 2,
      own_position_age_s: 2,
    });
    expect(liveness(open, live, 1, 1).state).toBe("live");
    expect(liveness(open, live, MAX_DATA_AGE_S, MAX_DATA_AGE_S).text).toBe("No data for 32 s");
    expect(liveness(open, { ...live, last_report_age_s: MAX_DATA_AGE_S + 1 }, 0, 0).state).toBe(
      "stale",
    );
    expect(
      liveness(open, { ...live, last_report_age_s: null, own_position_age_s: null }, 31, 1).state,
    ).toBe("stale");
    expect(liveness(open, { ...live, connected: false }, 0, 0).state).toBe("stale");
  });

  it("when only other ships are received", () => {
    const others = session({
      mode: "live",
      connected: true,
      last_report_age_s: 1,
      own_position_age_s: 26,
    });
    expect(liveness(open, others, 4, 4)).toEqual({ state: "live", text: "Live" });
    const later = liveness(open, { ...others, own_position_age_s: 40 }, 1, 1);
    expect(later).toEqual({ state: "stale", text: "Own position 41 s old" });
    // A lost own ship has no new frames; the age reported a second ago still counts.
    const lost = liveness(open, { ...others, own_position_age_s: 400 }, 45, 1);
    expect(lost.text).toBe("Own position 401 s old");
  });

  it("when data arrives but no frames", () => {
    const live = session({
      mode: "live",
      connected: true,
      last_report_age_s: 1,
      own_position_age_s: 1,
    });
    expect(liveness(open, live, 31, 1).text).toBe("No new frame for 31 s");
  });

  it("when frames stop while playing", () => {
    expect(liveness(open, session(), 6, 0).state).toBe("playing");
    expect(liveness(open, session(), 16, 0).state).toBe("stale");
    expect(liveness(open, session({ rate: 60 }), 11, 0).state).toBe("stale");
  });
});

it("a paused or ended voyage says so", () => {
  expect(liveness(open, session({ playing: false }), 500, 0).state).toBe("paused");
  expect(liveness(open, session({ playing: false, time_s: 3600 }), 500, 0).state).toBe("ended");
  expect(liveness(open, session({ rate: 10 }), 1, 0).text).toBe("Playing ×10");
});

it("live advice is as old as the received data, however new its frame", () => {
  const live = session({
    mode: "live",
    connected: true,
    last_report_age_s: 40,
    own_position_age_s: null,
  });
  expect(dataAge(live, 1, 2)).toBe(42);
  expect(dataAge({ ...live, own_position_age_s: 55 }, 1, 2)).toBe(57);
  expect(dataAge({ ...live, last_report_age_s: null }, 7, 2)).toBe(7);
});

it("any other advice is as old as its frame", () => {
  expect(dataAge(session(), 12, 30)).toBe(12);
  expect(dataAge(session({ mode: "live", last_report_age_s: 40 }), null, 2)).toBeNull();
});
