import { expect, it } from "vitest";

import { overlaps, placeLabel, type Box } from "../src/domain/label-layout";

const picture: Box = { x: 0, y: 0, w: 400, h: 300 };
const size = { w: 60, h: 16 };

it("labels never lie on each other nor outside", () => {
  const taken: Box[] = [];
  const found: Box[] = [];
  for (let k = 0; k < 40; k++) {
    const at = { x: 200 + 3 * Math.sin(k), y: 150 + 3 * Math.cos(k) };
    const box = placeLabel(at, size, 12, picture, taken);
    if (box) found.push(box);
  }
  expect(found.length).toBeGreaterThan(2);
  found.forEach((a, i) => found.slice(0, i).forEach((b) => expect(overlaps(a, b)).toBe(false)));
});

it("a label at the edge turns inward", () => {
  const box = placeLabel({ x: 395, y: 150 }, size, 12, picture, [])!;
  expect(box.x + box.w).toBeLessThanOrEqual(400);
});

it("there is no label where there is no room", () => {
  expect(placeLabel({ x: 5, y: 5 }, { w: 500, h: 16 }, 4, picture, [])).toBeNull();
});
