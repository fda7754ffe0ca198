/**
 * One colour and one number a ship, kept for as long as she is of note.
 *
 * The colours are told apart by readers with any colour vision and none is near the red of
 * alarms (test/colours.test.ts measures both); the number goes with each, so that colour
 * is never alone.
 */

export type Palette = "day" | "dusk" | "night";
export const PALETTES: readonly Palette[] = ["day", "dusk", "night"];

export const SHIP_COLOURS: Record<Palette, readonly string[]> = {
  day: ["#0060c0", "#a18812", "#009c6b", "#7a12dc", "#5e2800", "#df52c2"],
  dusk: ["#8fbcff", "#e6dc20", "#38e0a4", "#a468f5", "#c08038", "#ff5cc0"],
  night: ["#2a7fd0", "#6d6030", "#0b6a53", "#7038ea", "#b87818", "#b02898"],
};

/** The ink of a number on a ship's colour: the better readable of a dark and a light one. */
export function textColourOn(colour: string, palette: Palette): string {
  const light = palette === "night" ? "#f6ecd6" : "#ffffff";
  return contrast(colour, "#000000") >= contrast(colour, light) ? "#000000" : light;
}

/** Contrast of two colours (WCAG 2.2). */
export function contrast(a: string, b: string): number {
  const [x, y] = [luminance(a) + 0.05, luminance(b) + 0.05];
  return Math.max(x, y) / Math.min(x, y);
}

/** Relative luminance of `#rrggbb`. */
export function luminance(hex: string): number {
  const [r, g, b] = linearRgb(hex);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

export function linearRgb(hex: string): [number, number, number] {
  return [1, 3, 5].map((k) => {
    const c = parseInt(hex.slice(k, k + 2), 16) / 255;
    return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
  }) as [number, number, number];
}

export const N_SHIP_COLOURS = SHIP_COLOURS.day.length;

/** Hands out the places 0-5 and takes them back, so that a ship keeps hers. */
export class ColourRegistry {
  private readonly indices = new Map<string, number>();

  /** The ships of note now, the most notable first; others keep their place while one is free. */
  update(noted: readonly string[], present: ReadonlySet<string>): void {
    for (const id of this.indices.keys()) if (!present.has(id)) this.indices.delete(id);
    const wanted = noted.slice(0, N_SHIP_COLOURS);
    for (const id of wanted) {
      if (this.indices.has(id)) continue;
      const place = this.freeIndex(id) ?? this.takeFromOthers(new Set(wanted));
      if (place !== null) this.indices.set(id, place);
    }
  }

  indexOf(id: string): number | null {
    return this.indices.get(id) ?? null;
  }

  clear(): void {
    this.indices.clear();
  }

  /** A free place, for ship 3 the third if it is free. */
  private freeIndex(id: string): number | null {
    const used = new Set(this.indices.values());
    const own = Number(id) - 1;
    if (Number.isInteger(own) && own >= 0 && own < N_SHIP_COLOURS && !used.has(own)) return own;
    for (let k = 0; k < N_SHIP_COLOURS; k++) if (!used.has(k)) return k;
    return null;
  }

  /** The place of a ship that is no longer among the wanted, taken from her. */
  private takeFromOthers(wanted: ReadonlySet<string>): number | null {
    for (const [id, place] of this.indices)
      if (!wanted.has(id)) {
        this.indices.delete(id);
        return place;
      }
    return null;
  }
}
