import { describe, expect, it } from "vitest";

import { cpaWatch } from "../src/domain/cpa-watch";

const limits = { dcpa_m: 1852, tcpa_s: 600 };

describe("without a CPA alarm", () => {
  it("a current picture says that there is none", () => {
    for (const state of ["live", "playing", "paused", "ended"] as const)
      expect(cpaWatch({ state, text: "" }, limits)).toEqual({
        active: true,
        text: "No CPA alarm (limits 1.00 NM, 10 min)",
      });
  });

  it("a stale or missing picture says that none is computed", () => {
    const text = "CPA not monitored: no current data";
    for (const state of ["stale", "waiting"] as const)
      expect(cpaWatch({ state, text: "" }, limits)).toEqual({ active: false, text });
    expect(cpaWatch({ state: "live", text: "" }, null)).toEqual({ active: false, text });
  });
});
