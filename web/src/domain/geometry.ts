/** Plane geometry in east/north metres and radians clockwise from north. */

/** East and north of the origin [m]. */
export interface Position {
  east_m: number;
  north_m: number;
}

export interface Motion extends Position {
  course_rad: number;
  speed_m_s: number;
}

const TAU = 2 * Math.PI;

/** An angle in [−π, π). */
export function wrapAngle(rad: number): number {
  return rad - TAU * Math.floor((rad + Math.PI) / TAU);
}

export function distance(a: Position, b: Position): number {
  return Math.hypot(b.east_m - a.east_m, b.north_m - a.north_m);
}

/** True bearing from one position to another, in [0, 2π). */
export function bearing(from: Position, to: Position): number {
  const rad = Math.atan2(to.east_m - from.east_m, to.north_m - from.north_m);
  return rad < 0 ? rad + TAU : rad;
}

/** East and north speed [m/s]. */
export function velocity(course_rad: number, speed_m_s: number): Position {
  return { east_m: speed_m_s * Math.sin(course_rad), north_m: speed_m_s * Math.cos(course_rad) };
}

/** The position after `seconds` on a steady course and speed. */
export function positionAfter(m: Motion, seconds: number): Position {
  const v = velocity(m.course_rad, m.speed_m_s);
  return { east_m: m.east_m + v.east_m * seconds, north_m: m.north_m + v.north_m * seconds };
}

export interface ClosestApproach {
  dcpa_m: number;
  tcpa_s: number;
  /** Both ships at that instant. */
  own: Position;
  target: Position;
}

/** The closest point of approach of two ships on steady courses and speeds. */
export function closestApproach(own: Motion, target: Motion): ClosestApproach {
  const a = velocity(own.course_rad, own.speed_m_s);
  const b = velocity(target.course_rad, target.speed_m_s);
  const ve = b.east_m - a.east_m;
  const vn = b.north_m - a.north_m;
  const v2 = ve * ve + vn * vn;
  const re = target.east_m - own.east_m;
  const rn = target.north_m - own.north_m;
  const tcpa_s = v2 > 1e-9 ? -(re * ve + rn * vn) / v2 : 0;
  const there = { own: positionAfter(own, tcpa_s), target: positionAfter(target, tcpa_s) };
  return { dcpa_m: distance(there.own, there.target), tcpa_s, ...there };
}

/** Half axes of the ship domain, in ship lengths (Eq. 14-15). */
export const DOMAIN_HALF_AXES_LOA = { starboard: 3.2, port: 1.6, ahead: 6.4, astern: 1.6 } as const;

/** The outline of the domain in the body frame: `x` starboard, `y` ahead [m]. */
export function domainOutline(loa_m: number, steps = 72): { x: number; y: number }[] {
  return Array.from({ length: steps }, (_, k) => {
    const angle = (k * TAU) / steps;
    const [x, y] = [Math.sin(angle), Math.cos(angle)];
    return {
      x: x * loa_m * (x >= 0 ? DOMAIN_HALF_AXES_LOA.starboard : DOMAIN_HALF_AXES_LOA.port),
      y: y * loa_m * (y >= 0 ? DOMAIN_HALF_AXES_LOA.ahead : DOMAIN_HALF_AXES_LOA.astern),
    };
  });
}

/** A point of a ship's body frame, in east and north. */
export function fromBody(
  ship: Position,
  heading_rad: number,
  body: { x: number; y: number },
): Position {
  const [s, c] = [Math.sin(heading_rad), Math.cos(heading_rad)];
  return {
    east_m: ship.east_m + body.x * c + body.y * s,
    north_m: ship.north_m - body.x * s + body.y * c,
  };
}
