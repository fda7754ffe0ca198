/** Everything one picture of the plan display is made of. */

import type { Ranked } from "../domain/ranking";
import type { View } from "../domain/view";
import type { Choices } from "../settings";
import type { Encounter, Frame, Place } from "../wire";
import type { Inks } from "./inks";

export interface Scene {
  frame: Frame;
  /** Past frames, the last of them `frame`. */
  frames: readonly Frame[];
  compare: readonly Frame[];
  path: readonly Place[];
  /** Own ship's track under the condition that was asked about; empty when nothing was. */
  whatIf: readonly Place[];
  rows: readonly Ranked[];
  encounters: Record<string, Encounter>;
  selected: string | null;
  hovered: string | null;
  /** Place of a ship of note in the palette, `null` for all others. */
  place: (id: string) => number | null;
  choices: Readonly<Choices>;
  inks: Inks;
  view: View;
  width: number;
  height: number;
  /** Radius of the outer ring [px]. */
  radius: number;
  /** Whether flashing symbols are in their bright half. */
  bright: boolean;
  /** The picture is not of now: it is drawn in grey. */
  stale: boolean;
}

export function inkOf(scene: Scene, id: string): string {
  const place = scene.place(id);
  return place === null ? scene.inks.other : (scene.inks.ships[place] ?? scene.inks.other);
}
