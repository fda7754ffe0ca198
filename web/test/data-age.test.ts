import { expect, it } from "vitest";

import { dataAge } from "../src/domain/data-age";
import { session } from "./fixtures";

it("live advice is as old as what was heard, however new its frame", () => {
  const live = session({ mode: "live", connected: true, heard_s: 40, own_s: null });
  expect(dataAge(live, 1, 2)).toBe(42);
  expect(dataAge({ ...live, own_s: 55 }, 1, 2)).toBe(57);
  expect(dataAge({ ...live, heard_s: null }, 7, 2)).toBe(7);
});

it("any other advice is as old as its frame", () => {
  expect(dataAge(session(), 12, 30)).toBe(12);
  expect(dataAge(session({ mode: "live", heard_s: 40 }), null, 2)).toBeNull();
});
