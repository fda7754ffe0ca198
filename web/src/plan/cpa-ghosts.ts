/** CPA ghosts: own ship and a target at their closest point of approach. */

import { closestApproach } from "../domain/geometry";
import { type Box, placeLabel } from "../domain/label-layout";
import { ownMotion } from "../domain/own-motion";
import type { RankedTarget } from "../domain/ranking";
import { formatDuration, formatMiles, milesToMetres } from "../domain/units";
import type { Target } from "../protocol.gen";
import { type Context, FONT, isHighlighted, isVisible, type Scene, targetColour } from "./scene";
import * as symbol from "./symbols";

/** Ghosts are drawn of approaches that are closer and sooner than this. */
const MAX_CPA_M = milesToMetres(3);
const MAX_TCPA_S = 3600;

const isAhead = (target: Target): boolean =>
  !target.lost && target.tcpa_s > 0 && target.tcpa_s <= MAX_TCPA_S;

/** Ghosts of all ships that are highlighted, under alarm, or coloured and close at CPA. */
export function drawCpaGhosts(c: Context, scene: Scene): void {
  for (const row of scene.rows) {
    const { target, alarm } = row;
    if (!isAhead(target)) continue;
    const coloured = scene.colourIndex(target.id) !== null;
    if (isHighlighted(scene, target.id) || alarm || (coloured && target.dcpa_m <= MAX_CPA_M))
      drawCpaGhost(c, scene, row);
  }
  c.globalAlpha = 1;
}

function drawCpaGhost(c: Context, scene: Scene, row: RankedTarget): void {
  const { view, settings, frame } = scene;
  const { target } = row;
  const highlighted = isHighlighted(scene, target.id);
  const colour = targetColour(scene, row);
  const cpa = closestApproach(ownMotion(frame), target);
  const relative = settings.motion === "relative" && settings.vectors === "relative";
  const [ownThen, targetThen] = relative
    ? [
        frame.own,
        {
          east_m: frame.own.east_m + cpa.target.east_m - cpa.own.east_m,
          north_m: frame.own.north_m + cpa.target.north_m - cpa.own.north_m,
        },
      ]
    : [cpa.own, cpa.target];
  const [a, b] = [view.toScreen(ownThen), view.toScreen(targetThen)];
  if (!isVisible(scene, a) && !isVisible(scene, b)) return;
  c.globalAlpha = highlighted || row.alarm ? 1 : 0.55;
  symbol.line(c, view.toScreen(target), b, colour, 0.8, [1, 4]);
  symbol.line(c, a, b, colour, highlighted ? 2 : 1.2);
  symbol.triangle(c, b, view.angle(target.course_rad), 6, colour, 1.1);
  symbol.circle(c, a, 4, colour, 1.1);
}

/** CPA and TCPA of a highlighted ship, beside its ghost. */
export function drawCpaLabel(
  c: Context,
  scene: Scene,
  row: RankedTarget,
  bounds: Box,
  occupied: Box[],
): void {
  const { target, alarm } = row;
  if (!isHighlighted(scene, target.id) || !isAhead(target)) return;
  const cpa = closestApproach(ownMotion(scene.frame), target);
  const at = scene.view.toScreen(cpa.target);
  if (!isVisible(scene, at)) return;
  c.font = `600 12px ${FONT}`;
  const words = `CPA ${formatMiles(target.dcpa_m)} NM in ${formatDuration(target.tcpa_s)}`;
  const box = placeLabel(at, { w: c.measureText(words).width, h: 16 }, 16, bounds, occupied);
  if (!box) return;
  const colour = alarm ? scene.colours.alarm : scene.colours.text;
  symbol.text(c, words, box.x, box.y + 8, colour, scene.colours.sea);
}
