/** The certified rudder band: a bracket on the rudder scale and a line of text. */

import { css, html, nothing, svg } from "lit";
import { classMap } from "lit/directives/class-map.js";

import { bracketEnds } from "../domain/certified-band";
import type { BandMessage } from "../protocol.gen";
import type { DetailLevel } from "../settings";

/** The smallest width of the bracket [px]. */
const MIN_WIDTH = 14;
/** Extent above and below the bar's upper edge, and length of the hooks [px]. */
const [ABOVE, BELOW, HOOK] = [4, 16, 4];

export const bandStyle = css`
  .bracket {
    fill: none;
    stroke: var(--gh-text);
    stroke-width: 2;
  }
  .band-fill {
    fill: var(--gh-path);
    opacity: 0.55;
  }
  .band-text {
    margin: 2px 0 0;
    font-size: 12px;
    line-height: 1.35;
    text-wrap: pretty;
  }
  .band-text strong::first-letter {
    text-transform: uppercase;
  }
  .band-text strong {
    display: block;
    font-weight: 600;
  }
  .band-text.placeholder {
    visibility: hidden;
  }
  .band-text,
  .band-text.uncertain strong {
    color: var(--gh-muted);
  }
  .band-text strong {
    color: var(--gh-text);
  }
`;

/** The bracket around all rudder angles that sensor errors can cause, on a bar at `top`. */
export function bandBracket(band: BandMessage | null, x: (rad: number) => number, top: number) {
  if (!band?.band) return nothing;
  const [low, high] = bracketEnds(band.band, x, MIN_WIDTH);
  const [up, down] = [top - ABOVE, top + BELOW];
  return svg`
    <rect class="band-fill" x=${low} y=${top} width=${high - low} height="12" />
    <path class="bracket" d="M${low + HOOK} ${up} h-${HOOK} V${down} h${HOOK}
      M${high - HOOK} ${up} h${HOOK} V${down} h-${HOOK}">
      <title>${band.full}</title></path>`;
}

/**
 * What is certain; from level 2 the band and the errors that it allows, on level 3 why there is
 * none. Until a frame's band arrives, the text of the `last` one keeps its place, invisible.
 */
export function bandText(band: BandMessage | null, last: BandMessage | null, level: DetailLevel) {
  if (band && !band.band) return level > 2 ? html`<p class="band-text">${band.full}</p>` : nothing;
  const shown = band ?? last;
  if (!shown?.band) return nothing;
  const kind = {
    "band-text": true,
    uncertain: !shown.short.startsWith("certain"),
    placeholder: !band,
  };
  return html`<p class=${classMap(kind)} title=${shown.full} aria-hidden=${band ? nothing : "true"}>
    <strong>${shown.short}</strong>${level > 1 ? shown.full : nothing}
  </p>`;
}
