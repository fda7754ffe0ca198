/** Numbers and names beside the ships, where they hide nothing. */

import { textColourOn } from "../domain/colours";
import { placeLabel, type Box } from "../domain/label-layout";
import type { RankedTarget } from "../domain/ranking";
import { shortName } from "../domain/units";
import type { Point } from "../domain/view";
import type { Target } from "../protocol.gen";
import { bearingLabels } from "./range-rings";
import { drawCpaLabel } from "./cpa-ghosts";
import { FONT, shipColour, isVisible, type Context, type Scene } from "./scene";
import { vectorTip } from "./ships";
import * as symbol from "./symbols";

const VECTOR_BOX_PX = 8;

/** Numbers of the ships of note, names where there is room. */
export function drawLabels(c: Context, scene: Scene): void {
  const picture: Box = { x: 2, y: 2, w: scene.width - 4, h: scene.height - 4 };
  const occupied: Box[] = [
    squareAround(scene.view.toScreen(scene.frame.own), 14),
    ...bearingLabels(scene).map(({ p }) => squareAround(p, 10)),
  ];
  const labelled = [...scene.rows]
    .filter((row) => scene.colourIndex(row.target.id) !== null || row.target.id === scene.hovered)
    .sort((a, b) => b.prominence - a.prominence);
  for (const row of labelled) {
    const at = scene.view.toScreen(row.target);
    if (isVisible(scene, at))
      occupied.push(squareAround(at, 11), ...vectorBoxes(scene, row.target));
  }
  for (const row of labelled) drawLabel(c, scene, row, picture, occupied);
  for (const row of scene.rows) drawCpaLabel(c, scene, row, picture, occupied);
}

/** A ship's vector as small boxes, so that no words hide it. */
function vectorBoxes(scene: Scene, target: Target): Box[] {
  if (target.lost) return [];
  const [a, b] = [target, vectorTip(scene, target)].map((p) => scene.view.toScreen(p)) as [
    Point,
    Point,
  ];
  const count = Math.min(Math.floor(Math.hypot(b.x - a.x, b.y - a.y) / VECTOR_BOX_PX), 40);
  return Array.from({ length: count }, (_, k) => {
    const share = (k + 1) / count;
    return squareAround(
      { x: a.x + share * (b.x - a.x), y: a.y + share * (b.y - a.y) },
      VECTOR_BOX_PX / 2,
    );
  });
}

function drawLabel(c: Context, scene: Scene, row: RankedTarget, picture: Box, taken: Box[]): void {
  const { target } = row;
  const at = scene.view.toScreen(target);
  if (!isVisible(scene, at)) return;
  const place = scene.colourIndex(target.id);
  const lit = target.id === scene.selected || target.id === scene.hovered;
  c.font = `${lit ? 700 : 500} 12px ${FONT}`;
  const full = shortName(target.name);
  const chip = place === null ? "" : String(place + 1);
  const width = c.measureText(full).width + (chip ? 19 : 0);
  const box = placeLabel(at, { w: width, h: 16 }, 15, picture, taken);
  const small = box ? null : chip ? placeLabel(at, { w: 16, h: 16 }, 13, picture, taken) : null;
  const there = box ?? small;
  if (!there) return;
  const y = there.y + there.h / 2;
  if (chip) drawBadge(c, scene, chip, there.x, there.y, shipColour(scene, target.id));
  if (box)
    symbol.text(
      c,
      full,
      there.x + (chip ? 20 : 0),
      y,
      lit ? scene.colours.text : scene.colours.muted,
      scene.colours.sea,
    );
}

function drawBadge(
  c: Context,
  scene: Scene,
  chip: string,
  x: number,
  y: number,
  ink: string,
): void {
  c.fillStyle = ink;
  c.beginPath();
  c.roundRect(x, y, 16, 16, 4);
  c.fill();
  c.font = `700 11px ${FONT}`;
  symbol.text(c, chip, x + 8, y + 8.5, textColourOn(ink, scene.settings.palette), null, "center");
}

const squareAround = (p: Point, half: number): Box => ({
  x: p.x - half,
  y: p.y - half,
  w: 2 * half,
  h: 2 * half,
});
