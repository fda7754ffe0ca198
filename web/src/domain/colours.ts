/**
 * Colours and numbers of the most prominent ships.
 *
 * The colours can be told apart with any colour vision, and none is close to the red of alarms
 * (test/colours.test.ts measures both). Each comes with a number, so that nothing is coded by
 * colour alone.
 */

export type Palette = "day" | "dusk" | "night";
export const PALETTES: readonly Palette[] = ["day", "dusk", "night"];

export const SHIP_COLOURS: Record<Palette, readonly string[]> = {
  day: ["#0060c0", "#a18812", "#009c6b", "#7a12dc", "#5e2800", "#df52c2"],
  dusk: ["#8fbcff", "#e6dc20", "#38e0a4", "#a468f5", "#c08038", "#ff5cc0"],
  night: ["#2a7fd0", "#6d6030", "#0b6a53", "#7038ea", "#b87818", "#b02898"],
};

/** The text colour that reads better on `colour`: a dark or a light one. */
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

/** Assigns the colours 0-5 to ships, so that each keeps its own while it is prominent. */
export class ColourRegistry {
  private readonly indices = new Map<string, number>();

  /** Assign colours to the first of `ids`; other ships keep theirs until it is needed. */
  update(ids: readonly string[], present: ReadonlySet<string>): void {
    for (const id of this.indices.keys()) if (!present.has(id)) this.indices.delete(id);
    const wanted = ids.slice(0, N_SHIP_COLOURS);
    for (const id of wanted) {
      if (this.indices.has(id)) continue;
      const index = this.freeIndex(id) ?? this.takeFromOthers(new Set(wanted));
      if (index !== null) this.indices.set(id, index);
    }
  }

  indexOf(id: string): number | null {
    return this.indices.get(id) ?? null;
  }

  clear(): void {
    this.indices.clear();
  }

  /** A free colour; for ship 3 the third, if it is free. */
  private freeIndex(id: string): number | null {
    const used = new Set(this.indices.values());
    const own = Number(id) - 1;
    if (Number.isInteger(own) && own >= 0 && own < N_SHIP_COLOURS && !used.has(own)) return own;
    for (let k = 0; k < N_SHIP_COLOURS; k++) if (!used.has(k)) return k;
    return null;
  }

  /** The colour of a ship that is not among the wanted ones, taken from it. */
  private takeFromOthers(wanted: ReadonlySet<string>): number | null {
    for (const [id, index] of this.indices)
      if (!wanted.has(id)) {
        this.indices.delete(id);
        return index;
      }
    return null;
  }
}
