/** Names beside symbols without one on top of another. */

export interface Box {
  x: number;
  y: number;
  w: number;
  h: number;
}

export const overlaps = (a: Box, b: Box): boolean =>
  a.x < b.x + b.w && b.x < a.x + a.w && a.y < b.y + b.h && b.y < a.y + a.h;

/**
 * The first free place of a label around its symbol (right, left, below, above), within the
 * picture and off everything in `taken`; `null` if there is none. The place found is added
 * to `taken`.
 */
export function placeLabel(
  at: { x: number; y: number },
  size: { w: number; h: number },
  gap: number,
  frame: Box,
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
      box.x >= frame.x &&
      box.y >= frame.y &&
      box.x + w <= frame.x + frame.w &&
      box.y + h <= frame.y + frame.h;
    if (inside && !occupied.some((other) => overlaps(box, other))) {
      occupied.push(box);
      return box;
    }
  }
  return null;
}
