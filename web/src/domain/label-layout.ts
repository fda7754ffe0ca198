/** Layout of labels beside their symbols, without overlaps. */

export interface Box {
  x: number;
  y: number;
  w: number;
  h: number;
}

export const overlaps = (a: Box, b: Box): boolean =>
  a.x < b.x + b.w && b.x < a.x + a.w && a.y < b.y + b.h && b.y < a.y + a.h;

/**
 * The first free box for a label around its symbol at `at`, within `bounds` and clear of
 * everything in `occupied`, to which it is added; `null` if there is none.
 */
export function placeLabel(
  at: { x: number; y: number },
  size: { w: number; h: number },
  gap: number,
  bounds: Box,
  occupied: Box[],
): Box | null {
  const { w, h } = size;
  const candidates: Box[] = [
    { x: at.x + gap, y: at.y - h / 2, w, h },
    { x: at.x - gap - w, y: at.y - h / 2, w, h },
    { x: at.x + gap * 0.6, y: at.y + gap * 0.7, w, h },
    { x: at.x + gap * 0.6, y: at.y - gap * 0.7 - h, w, h },
    { x: at.x - gap * 0.6 - w, y: at.y + gap * 0.7, w, h },
    { x: at.x - gap * 0.6 - w, y: at.y - gap * 0.7 - h, w, h },
    { x: at.x - w / 2, y: at.y + gap, w, h },
    { x: at.x - w / 2, y: at.y - gap - h, w, h },
  ];
  for (const box of candidates) {
    const inside =
      box.x >= bounds.x &&
      box.y >= bounds.y &&
      box.x + w <= bounds.x + bounds.w &&
      box.y + h <= bounds.y + bounds.h;
    if (inside && !occupied.some((other) => overlaps(box, other))) {
      occupied.push(box);
      return box;
    }
  }
  return null;
}
