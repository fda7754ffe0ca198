/** Ghosts: both ships where they will be nearest, for the ships that a viewer should know it of. */

import { closestApproach, type Motion } from "../domain/geometry";
import { placeLabel, type Box } from "../domain/label-layout";
import type { RankedTarget } from "../domain/ranking";
import { formatDuration, formatMiles } from "../domain/units";
import { FONT, shipColour, isVisible, ownMotion, type Context, type Scene } from "./scene";
import * as symbol from "./symbols";

/** CPA positions are shown for approaches nearer than this [m] and sooner than this [s]. */
const MAX_GHOST_CPA_M = 3 * 1852;
const MAX_GHOST_TCPA_S = 3600;

/** Both ships where they will be nearest, for the ships that a viewer should know it of. */
export function drawCpaGhosts(c: Context, scene: Scene): void {
  const me = ownMotion(scene.frame);
  for (const row of scene.rows) {
    const { target } = row;
    const lit = target.id === scene.selected || target.id === scene.hovered;
    const told = lit || row.alarm !== null || scene.colourIndex(target.id) !== null;
    if (!told || target.lost || target.tcpa_s <= 0 || target.tcpa_s > MAX_GHOST_TCPA_S) continue;
    if (!lit && !row.alarm && target.dcpa_m > MAX_GHOST_CPA_M) continue;
    drawCpaGhost(c, scene, me, row, lit);
  }
  c.globalAlpha = 1;
}

function drawCpaGhost(c: Context, scene: Scene, me: Motion, row: RankedTarget, lit: boolean): void {
  const { view, colours, settings } = scene;
  const { target } = row;
  const ink = row.alarm ? colours.alarm : shipColour(scene, target.id);
  const cpa = closestApproach(me, target);
  const relative = settings.motion === "relative" && settings.vectors === "relative";
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
  if (!isVisible(scene, a) && !isVisible(scene, b)) return;
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
export function drawCpaLabel(
  c: Context,
  scene: Scene,
  row: RankedTarget,
  picture: Box,
  taken: Box[],
): void {
  const { target, alarm } = row;
  const lit = target.id === scene.selected || target.id === scene.hovered;
  if (!lit || target.lost || target.tcpa_s <= 0 || target.tcpa_s > MAX_GHOST_TCPA_S) return;
  const cpa = closestApproach(ownMotion(scene.frame), target);
  const at = scene.view.toScreen(cpa.target);
  if (!isVisible(scene, at)) return;
  c.font = `600 12px ${FONT}`;
  const words = `CPA ${formatMiles(target.dcpa_m)} NM in ${formatDuration(target.tcpa_s)}`;
  const box = placeLabel(at, { w: c.measureText(words).width, h: 16 }, 16, picture, taken);
  if (!box) return;
  const ink = alarm ? scene.colours.alarm : scene.colours.text;
  symbol.text(c, words, box.x, box.y + 8, ink, scene.colours.sea);
}
