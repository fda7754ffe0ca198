/** The number of a ship of note in her colour; nothing to see for all others. */

import { html, type TemplateResult } from "lit";

import { numberInk, SHIP_COLOURS } from "../domain/colours";
import { store } from "../store";

/** Her colour, or `null` if she has none. */
export function colourOf(id: string): string | null {
  const place = store.book.place(id);
  return place === null ? null : SHIP_COLOURS[store.settings.all.palette][place]!;
}

export function chip(id: string): TemplateResult {
  const place = store.book.place(id);
  const colour = colourOf(id);
  if (place === null || colour === null) return html`<span class="chip"></span>`;
  const ink = numberInk(colour, store.settings.all.palette);
  return html`<span class="chip" style="--ship: ${colour}; --number: ${ink}">${place + 1}</span>`;
}
