/** The certified rudder band: a bracket on the rudder scale, and what it means in a line. */

import { css, html, nothing, svg } from "lit";
import { classMap } from "lit/directives/class-map.js";

import { bracketEnds } from "../domain/certified-band";
import type { DetailLevel } from "../settings";
import type { Banded } from "../protocol.gen";

/** The bracket's ends are at least so far apart [px]. */
const LEAST = 14;
/** How far it reaches above and below the bar's upper edge, and how long its hooks are [px]. */
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

/** Round the rudders that errors can bring about: `[` and `]` at its ends, on a bar at `top`. */
export function bandBracket(told: Banded | null, x: (rad: number) => number, top: number) {
  if (!told?.band) return nothing;
  const [low, high] = bracketEnds(told.band, x, LEAST);
  const [up, down] = [top - ABOVE, top + BELOW];
  return svg`
    <rect class="band-fill" x=${low} y=${top} width=${high - low} height="12" />
    <path class="bracket" d="M${low + HOOK} ${up} h-${HOOK} V${down} h${HOOK}
      M${high - HOOK} ${up} h${HOOK} V${down} h-${HOOK}">
      <title>${told.full}</title></path>`;
}

/**
 * What is certain, in one line; from the second level on between which rudders and for which
 * errors, on the third why there is no band. Until the band of a new frame comes, the line of the
 * `last` one holds its place, unseen.
 */
export function bandText(told: Banded | null, last: Banded | null, level: DetailLevel) {
  if (told && !told.band) return level > 2 ? html`<p class="band-text">${told.full}</p>` : nothing;
  const shown = told ?? last;
  if (!shown?.band) return nothing;
  const kind = {
    "band-text": true,
    uncertain: !shown.short.startsWith("certain"),
    placeholder: !told,
  };
  return html`<p class=${classMap(kind)} title=${shown.full} aria-hidden=${told ? nothing : "true"}>
    <strong>${shown.short}</strong>${level > 1 ? shown.full : nothing}
  </p>`;
}
