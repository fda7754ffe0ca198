/** A ship's number on its colour; an empty badge for ships without one. */

import { html, type TemplateResult } from "lit";

import { SHIP_COLOURS, textColourOn } from "../domain/colours";
import { store } from "../store";

export function badgeColour(id: string): string | null {
  const index = store.colours.indexOf(id);
  return index === null ? null : SHIP_COLOURS[store.settings.values.palette][index]!;
}

export function shipBadge(id: string): TemplateResult {
  const index = store.colours.indexOf(id);
  const colour = badgeColour(id);
  if (index === null || colour === null) return html`<span class="badge"></span>`;
  const textColour = textColourOn(colour, store.settings.values.palette);
  return html`<span class="badge" style="--ship: ${colour}; --number: ${textColour}"
    >${index + 1}</span
  >`;
}
