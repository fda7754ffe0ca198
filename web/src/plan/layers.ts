/** The layers of the plan display, from the bottom up. */

import { drawCpaGhosts } from "./cpa-ghosts";
import { drawLabels } from "./labels";
import { drawRangeRings, drawRoute } from "./range-rings";
import { type Context, FONT, type Scene } from "./scene";
import { drawDomain, drawOwnShip, drawTargets } from "./ships";
import { drawComparedTrack, drawPredictedTrack, drawTrails, drawWhatIfTrack } from "./tracks";

export function drawPlan(c: Context, scene: Scene): void {
  c.fillStyle = scene.colours.sea;
  c.fillRect(0, 0, scene.width, scene.height);
  c.font = `12px ${FONT}`;
  drawRangeRings(c, scene);
  drawRoute(c, scene);
  drawTrails(c, scene);
  drawDomain(c, scene);
  drawPredictedTrack(c, scene);
  drawWhatIfTrack(c, scene);
  drawComparedTrack(c, scene);
  drawCpaGhosts(c, scene);
  drawTargets(c, scene);
  drawOwnShip(c, scene);
  drawLabels(c, scene);
}
