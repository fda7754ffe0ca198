/** The number of a ship of note in her colour; nothing to see for all others. */

import { html, type TemplateResult } from "lit";

import { textColourOn, SHIP_COLOURS } from "../domain/colours";
import { store } from "../store";

/** Her colour, or `null` if she has none. */
export function badgeColour(id: string): string | null {
  const place = store.colours.indexOf(id);
  return place === null ? null : SHIP_COLOURS[store.settings.values.palette][place]!;
}

export function shipBadge(id: string): TemplateResult {
  const place = store.colours.indexOf(id);
  const colour = badgeColour(id);
  if (place === null || colour === null) return html`<span class="badge"></span>`;
  const ink = textColourOn(colour, store.settings.values.palette);
  return html`<span class="badge" style="--ship: ${colour}; --number: ${ink}">${place + 1}</span>`;
}
