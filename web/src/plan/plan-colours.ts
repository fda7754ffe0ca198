/** The colours of the canvas, read from the current palette's style sheet. */

import { type Palette, SHIP_COLOURS } from "../domain/colours";

export interface PlanColours {
  sea: string;
  ring: string;
  ringText: string;
  own: string;
  other: string;
  domain: string;
  path: string;
  compare: string;
  whatIf: string;
  alarm: string;
  text: string;
  muted: string;
  line: string;
  ships: readonly string[];
}

export function planColours(palette: Palette): PlanColours {
  const style = getComputedStyle(document.documentElement);
  const of = (name: string): string => style.getPropertyValue(`--gh-${name}`).trim() || "#888";
  return {
    sea: of("sea"),
    ring: of("ring"),
    ringText: of("ring-text"),
    own: of("own"),
    other: of("other"),
    domain: of("domain"),
    path: of("path"),
    compare: of("compare"),
    whatIf: of("what-if"),
    alarm: of("alarm"),
    text: of("text"),
    muted: of("muted"),
    line: of("line"),
    ships: SHIP_COLOURS[palette],
  };
}
