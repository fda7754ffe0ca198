/** Ghosts: both ships where they will be nearest, for the ships that a viewer should know it of. */

import { closestApproach, type Motion } from "../domain/geometry";
import { placed, type Box } from "../domain/label-layout";
import type { Ranked } from "../domain/ranking";
import { clock, miles } from "../domain/units";
import { FONT, inkOf, inside, ownMotion, type Context, type Scene } from "./scene";
import * as symbol from "./symbols";

/** CPA positions are shown for approaches nearer than this [m] and sooner than this [s]. */
const GHOST_M = 3 * 1852;
const GHOST_S = 3600;

/** Both ships where they will be nearest, for the ships that a viewer should know it of. */
export function ghosts(c: Context, scene: Scene): void {
  const me = ownMotion(scene.frame);
  for (const row of scene.rows) {
    const { target } = row;
    const lit = target.id === scene.selected || target.id === scene.hovered;
    const told = lit || row.alarm !== null || scene.place(target.id) !== null;
    if (!told || target.lost || target.tcpa_s <= 0 || target.tcpa_s > GHOST_S) continue;
    if (!lit && !row.alarm && target.dcpa_m > GHOST_M) continue;
    ghost(c, scene, me, row, lit);
  }
  c.globalAlpha = 1;
}

function ghost(c: Context, scene: Scene, me: Motion, row: Ranked, lit: boolean): void {
  const { view, inks, choices } = scene;
  const { target } = row;
  const ink = row.alarm ? inks.alarm : inkOf(scene, target.id);
  const cpa = closestApproach(me, target);
  const relative = choices.motion === "relative" && choices.vectors === "relative";
  const [ownThen, targetThen] = relative
    ? [
        scene.frame.own,
        {
          east_m: scene.frame.own.east_m + cpa.target.east_m - cpa.own.east_m,
          north_m: scene.frame.own.north_m + cpa.target.north_m - cpa.own.north_m,
        },
      ]
    : [cpa.own, cpa.target];
  const [a, b] = [view.toScreen(ownThen), view.toScreen(targetThen)];
  if (!inside(scene, a) && !inside(scene, b)) return;
  c.globalAlpha = lit || row.alarm ? 1 : 0.55;
  symbol.line(c, view.toScreen(target), b, ink, 0.8, [1, 4]);
  symbol.line(c, a, b, ink, lit ? 2 : 1.2);
  symbol.triangle(c, b, view.angle(target.course_rad), 6, ink, 1.1);
  c.strokeStyle = ink;
  c.lineWidth = 1.1;
  c.beginPath();
  c.arc(a.x, a.y, 4, 0, 2 * Math.PI);
  c.stroke();
}

/** Distance and time of the closest approach, beside the lit ship's place at that time. */
export function ghostWords(
  c: Context,
  scene: Scene,
  row: Ranked,
  picture: Box,
  taken: Box[],
): void {
  const { target, alarm } = row;
  const lit = target.id === scene.selected || target.id === scene.hovered;
  if (!lit || target.lost || target.tcpa_s <= 0 || target.tcpa_s > GHOST_S) return;
  const cpa = closestApproach(ownMotion(scene.frame), target);
  const at = scene.view.toScreen(cpa.target);
  if (!inside(scene, at)) return;
  c.font = `600 12px ${FONT}`;
  const words = `CPA ${miles(target.dcpa_m)} NM in ${clock(target.tcpa_s)}`;
  const box = placed(at, { w: c.measureText(words).width, h: 16 }, 16, picture, taken);
  if (!box) return;
  const ink = alarm ? scene.inks.alarm : scene.inks.ink;
  symbol.text(c, words, box.x, box.y + 8, ink, scene.inks.sea);
}
