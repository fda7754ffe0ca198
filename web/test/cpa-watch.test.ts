import { describe, expect, it } from "vitest";

import { cpaWatch } from "../src/domain/cpa-watch";

const limits = { dcpa_m: 1852, tcpa_s: 600 };

describe("that there is no CPA alarm", () => {
  it("is said of a picture that is looked at", () => {
    for (const state of ["live", "playing", "paused", "ended"] as const)
      expect(cpaWatch({ state, text: "" }, limits)).toEqual({
        active: true,
        text: "No CPA alarm (limits 1.00 NM, 10 min)",
      });
  });

  it("is not said where nobody watches", () => {
    const text = "CPA not monitored: no current data";
    for (const state of ["stale", "waiting"] as const)
      expect(cpaWatch({ state, text: "" }, limits)).toEqual({ active: false, text });
    expect(cpaWatch({ state: "live", text: "" }, null)).toEqual({ active: false, text });
  });
});
