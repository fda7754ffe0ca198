import { describe, expect, it } from "vitest";

import { liveness, SILENT_S } from "../src/domain/liveness";
import { session } from "./frames";

const open = { open: true, since_s: 100 };
const shut = { open: false, since_s: 7 };

describe("stale data is never shown as live", () => {
  it("when the connection is gone", () => {
    for (const mode of ["simulated", "recorded", "live", "replay"] as const)
      expect(liveness(shut, session({ mode, connected: true, heard_s: 0 }), 1).state).toBe("stale");
    expect(liveness(shut, null, null).state).toBe("waiting");
  });

  it("when a live source is silent or gone", () => {
    const live = session({ mode: "live", connected: true, heard_s: 2 });
    expect(liveness(open, live, 1).state).toBe("live");
    expect(liveness(open, live, SILENT_S).state).toBe("stale");
    expect(liveness(open, { ...live, heard_s: SILENT_S + 1 }, 0).state).toBe("stale");
    expect(liveness(open, { ...live, connected: false }, 0).state).toBe("stale");
  });

  it("when frames stop while it plays", () => {
    expect(liveness(open, session(), 6).state).toBe("playing");
    expect(liveness(open, session(), 16).state).toBe("stale");
    expect(liveness(open, session({ rate: 60 }), 11).state).toBe("stale");
  });
});

it("a paused or finished voyage is called so", () => {
  expect(liveness(open, session({ playing: false }), 500).state).toBe("paused");
  expect(liveness(open, session({ playing: false, time_s: 3600 }), 500).state).toBe("ended");
  expect(liveness(open, session({ rate: 10 }), 1).text).toBe("Playing ×10");
});
