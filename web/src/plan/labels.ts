/** Numbers and names beside the ships, where they hide nothing. */

import { numberInk } from "../domain/colours";
import { placed, type Box } from "../domain/label-layout";
import type { Ranked } from "../domain/ranking";
import { shipName } from "../domain/units";
import type { Point } from "../domain/view";
import type { Target } from "../protocol.gen";
import { bearings } from "./range-rings";
import { ghostWords } from "./cpa-ghosts";
import { FONT, inkOf, inside, type Context, type Scene } from "./scene";
import { vector } from "./ships";
import * as symbol from "./symbols";

const VECTOR_BOX_PX = 8;

/** Numbers of the ships of note, names where there is room. */
export function names(c: Context, scene: Scene): void {
  const picture: Box = { x: 2, y: 2, w: scene.width - 4, h: scene.height - 4 };
  const taken: Box[] = [
    around(scene.view.toScreen(scene.frame.own), 14),
    ...bearings(scene).map(({ p }) => around(p, 10)),
  ];
  const told = [...scene.rows]
    .filter((row) => scene.place(row.target.id) !== null || row.target.id === scene.hovered)
    .sort((a, b) => b.note - a.note);
  for (const row of told) {
    const at = scene.view.toScreen(row.target);
    if (inside(scene, at)) taken.push(around(at, 11), ...alongVector(scene, row.target));
  }
  for (const row of told) name(c, scene, row, picture, taken);
  for (const row of scene.rows) ghostWords(c, scene, row, picture, taken);
}

/** A ship's vector as small boxes, so that no words hide it. */
function alongVector(scene: Scene, target: Target): Box[] {
  if (target.lost) return [];
  const [a, b] = [target, vector(scene, target)].map((p) => scene.view.toScreen(p)) as [
    Point,
    Point,
  ];
  const count = Math.min(Math.floor(Math.hypot(b.x - a.x, b.y - a.y) / VECTOR_BOX_PX), 40);
  return Array.from({ length: count }, (_, k) => {
    const share = (k + 1) / count;
    return around(
      { x: a.x + share * (b.x - a.x), y: a.y + share * (b.y - a.y) },
      VECTOR_BOX_PX / 2,
    );
  });
}

function name(c: Context, scene: Scene, row: Ranked, picture: Box, taken: Box[]): void {
  const { target } = row;
  const at = scene.view.toScreen(target);
  if (!inside(scene, at)) return;
  const place = scene.place(target.id);
  const lit = target.id === scene.selected || target.id === scene.hovered;
  c.font = `${lit ? 700 : 500} 12px ${FONT}`;
  const full = shipName(target.name);
  const chip = place === null ? "" : String(place + 1);
  const width = c.measureText(full).width + (chip ? 19 : 0);
  const box = placed(at, { w: width, h: 16 }, 15, picture, taken);
  const small = box ? null : chip ? placed(at, { w: 16, h: 16 }, 13, picture, taken) : null;
  const there = box ?? small;
  if (!there) return;
  const y = there.y + there.h / 2;
  if (chip) badge(c, scene, chip, there.x, there.y, inkOf(scene, target.id));
  if (box)
    symbol.text(
      c,
      full,
      there.x + (chip ? 20 : 0),
      y,
      lit ? scene.inks.ink : scene.inks.soft,
      scene.inks.sea,
    );
}

function badge(c: Context, scene: Scene, chip: string, x: number, y: number, ink: string): void {
  c.fillStyle = ink;
  c.beginPath();
  c.roundRect(x, y, 16, 16, 4);
  c.fill();
  c.font = `700 11px ${FONT}`;
  symbol.text(c, chip, x + 8, y + 8.5, numberInk(ink, scene.choices.palette), null, "center");
}

const around = (p: Point, half: number): Box => ({
  x: p.x - half,
  y: p.y - half,
  w: 2 * half,
  h: 2 * half,
});
