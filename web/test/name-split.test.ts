import { expect, it } from "vitest";

import { splitAtNames } from "../src/domain/name-split";

it("finds names as whole words, the longest first", () => {
  expect(splitAtNames("Danger from ship 1 and ship 12", ["ship 1", "ship 12"])).toEqual([
    "Danger from ",
    "ship 1",
    " and ",
    "ship 12",
  ]);
  expect(splitAtNames("ship 13 passes", ["ship 1"])).toEqual(["ship 13 passes"]);
});

it("takes special characters in names literally", () => {
  expect(splitAtNames("for M/V (A+B), turn", ["M/V (A+B)"])).toEqual([
    "for ",
    "M/V (A+B)",
    ", turn",
  ]);
  expect(splitAtNames("no names", [])).toEqual(["no names"]);
});
