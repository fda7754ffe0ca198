/** The picture in words, for screen readers. */

import { degrees, formatMiles } from "../domain/units";
import { formatRingDistance } from "../domain/view";
import type { Scene } from "./scene";

export function describePlan({ settings, rows, frame }: Scene): string {
  const { orientation, motion, range_nm } = settings;
  const prominent = [...rows].sort((a, b) => b.prominence - a.prominence).slice(0, 3);
  const ships = prominent.map(({ target }) => {
    const deg = Math.round(degrees(target.bearing_rad));
    const side = deg === 0 ? "ahead" : `${Math.abs(deg)}° to ${deg > 0 ? "starboard" : "port"}`;
    return `${target.name}, ${formatMiles(target.range_m)} miles, ${side}`;
  });
  return (
    `Plan display, ${orientation}, ${motion} motion, range ${range_nm} miles, ` +
    `rings every ${formatRingDistance(range_nm)} NM; ${frame.targets.length} ships. ${ships.join("; ")}`
  );
}
