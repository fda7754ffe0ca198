/** Numbers and names beside the ships, where there is room. */

import { textColourOn } from "../domain/colours";
import { type Box, placeLabel } from "../domain/label-layout";
import type { RankedTarget } from "../domain/ranking";
import { shortName } from "../domain/units";
import type { Point } from "../domain/view";
import type { Target } from "../protocol.gen";
import { drawCpaLabel } from "./cpa-ghosts";
import { bearingLabels } from "./range-rings";
import { type Context, FONT, isHighlighted, isVisible, type Scene, shipColour } from "./scene";
import { vectorTip } from "./ships";
import * as symbol from "./symbols";

const VECTOR_BOX_PX = 8;
const BADGE_PX = 16;

/** Labels of the coloured and hovered ships, the most prominent first, then of CPA ghosts. */
export function drawLabels(c: Context, scene: Scene): void {
  const bounds: Box = { x: 2, y: 2, w: scene.width - 4, h: scene.height - 4 };
  const occupied: Box[] = [
    squareAround(scene.view.toScreen(scene.frame.own), 14),
    ...bearingLabels(scene).map(({ p }) => squareAround(p, 10)),
  ];
  const labelled = scene.rows
    .filter((row) => scene.colourIndex(row.target.id) !== null || row.target.id === scene.hovered)
    .filter((row) => isVisible(scene, scene.view.toScreen(row.target)))
    .sort((a, b) => b.prominence - a.prominence);
  for (const { target } of labelled)
    occupied.push(squareAround(scene.view.toScreen(target), 11), ...vectorBoxes(scene, target));
  for (const row of labelled) drawLabel(c, scene, row, bounds, occupied);
  for (const row of scene.rows) drawCpaLabel(c, scene, row, bounds, occupied);
}

/** A ship's vector as small boxes, so that no label hides it. */
function vectorBoxes(scene: Scene, target: Target): Box[] {
  if (target.lost) return [];
  const a = scene.view.toScreen(target);
  const b = scene.view.toScreen(vectorTip(scene, target));
  const count = Math.min(Math.floor(Math.hypot(b.x - a.x, b.y - a.y) / VECTOR_BOX_PX), 40);
  return Array.from({ length: count }, (_, k) => {
    const share = (k + 1) / count;
    const centre = { x: a.x + share * (b.x - a.x), y: a.y + share * (b.y - a.y) };
    return squareAround(centre, VECTOR_BOX_PX / 2);
  });
}

/** The number and name of a ship; the number alone where the name does not fit. */
function drawLabel(
  c: Context,
  scene: Scene,
  { target }: RankedTarget,
  bounds: Box,
  occupied: Box[],
): void {
  const { view, colours } = scene;
  const at = view.toScreen(target);
  const index = scene.colourIndex(target.id);
  const highlighted = isHighlighted(scene, target.id);
  c.font = `${highlighted ? 700 : 500} 12px ${FONT}`;
  const name = shortName(target.name);
  const width = c.measureText(name).width + (index === null ? 0 : 19);
  const full = placeLabel(at, { w: width, h: BADGE_PX }, 15, bounds, occupied);
  const box =
    full ??
    (index === null ? null : placeLabel(at, { w: BADGE_PX, h: BADGE_PX }, 13, bounds, occupied));
  if (!box) return;
  if (index !== null) drawBadge(c, scene, String(index + 1), box, shipColour(scene, target.id));
  if (full) {
    const x = box.x + (index === null ? 0 : 20);
    const colour = highlighted ? colours.text : colours.muted;
    symbol.text(c, name, x, box.y + box.h / 2, colour, colours.sea);
  }
}

function drawBadge(c: Context, scene: Scene, number: string, at: Point, colour: string): void {
  c.fillStyle = colour;
  c.beginPath();
  c.roundRect(at.x, at.y, BADGE_PX, BADGE_PX, 4);
  c.fill();
  c.font = `700 11px ${FONT}`;
  const textColour = textColourOn(colour, scene.settings.palette);
  symbol.text(c, number, at.x + 8, at.y + 8.5, textColour, null, "center");
}

const squareAround = (p: Point, half: number): Box => ({
  x: p.x - half,
  y: p.y - half,
  w: 2 * half,
  h: 2 * half,
});
