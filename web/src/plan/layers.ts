/** The layers of the plan display, from the sea up. */

import { rings, route } from "./range-rings";
import { ghosts } from "./cpa-ghosts";
import { names } from "./labels";
import { FONT, type Context, type Scene } from "./scene";
import { domain, own, targets } from "./ships";
import { compared, predicted, trails, whatIf } from "./tracks";

export function draw(c: Context, scene: Scene): void {
  c.fillStyle = scene.inks.sea;
  c.fillRect(0, 0, scene.width, scene.height);
  c.font = `12px ${FONT}`;
  rings(c, scene);
  route(c, scene);
  trails(c, scene);
  domain(c, scene);
  predicted(c, scene);
  whatIf(c, scene);
  compared(c, scene);
  ghosts(c, scene);
  targets(c, scene);
  own(c, scene);
  names(c, scene);
}
