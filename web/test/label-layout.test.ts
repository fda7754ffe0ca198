import { expect, it } from "vitest";

import { type Box, overlaps, placeLabel } from "../src/domain/label-layout";

const picture: Box = { x: 0, y: 0, w: 400, h: 300 };
const size = { w: 60, h: 16 };

it("labels do not overlap", () => {
  const occupied: Box[] = [];
  const labels: Box[] = [];
  for (let k = 0; k < 40; k++) {
    const at = { x: 200 + 3 * Math.sin(k), y: 150 + 3 * Math.cos(k) };
    const box = placeLabel(at, size, 12, picture, occupied);
    if (box) labels.push(box);
  }
  expect(labels.length).toBeGreaterThan(2);
  labels.forEach((a, i) => labels.slice(0, i).forEach((b) => expect(overlaps(a, b)).toBe(false)));
});

it("a label at the edge stays inside", () => {
  const box = placeLabel({ x: 395, y: 150 }, size, 12, picture, [])!;
  expect(box.x + box.w).toBeLessThanOrEqual(400);
});

it("there is no label without room", () => {
  expect(placeLabel({ x: 5, y: 5 }, { w: 500, h: 16 }, 4, picture, [])).toBeNull();
});
