/** Conversion and formatting: everything outside this file is in SI units and radians. */

export const NAUTICAL_MILE_M = 1852;
const KNOT_M_S = NAUTICAL_MILE_M / 3600;
const DEGREE = Math.PI / 180;

export const metresToMiles = (m: number): number => m / NAUTICAL_MILE_M;
export const milesToMetres = (nm: number): number => nm * NAUTICAL_MILE_M;
export const knots = (m_s: number): number => m_s / KNOT_M_S;
export const degrees = (rad: number): number => rad / DEGREE;
export const radians = (deg: number): number => deg * DEGREE;

/** A course or heading in degrees true, three digits: `007°`, never `360°`. */
export function formatCourse(rad: number): string {
  const deg = Math.round(degrees(rad)) % 360;
  return `${String(deg < 0 ? deg + 360 : deg).padStart(3, "0")}°`;
}

/** A rudder angle with its side: `S 2.5°`, `P 0.3°`, `0.0°` amidships. */
export function formatRudder(rad: number, digits = 1): string {
  const deg = degrees(rad);
  const size = Math.abs(deg).toFixed(digits);
  return Number(size) === 0 ? `${size}°` : `${deg > 0 ? "S" : "P"} ${size}°`;
}

/** A smaller rudder angle [°] is called midships, as in the sentence. */
const MIDSHIPS_DEG = 0.5;

/** The rudder order in words: `Starboard` and `2.5°`, or `Midships` and `S 0.2°`. */
export function rudderOrder(rad: number): { side: string; angle: string } {
  const size = Math.abs(degrees(rad)).toFixed(1);
  if (Number(size) < MIDSHIPS_DEG) return { side: "Midships", angle: formatRudder(rad) };
  return { side: rad > 0 ? "Starboard" : "Port", angle: `${size}°` };
}

/** A rate of turn in degrees per minute, with its side. */
export function formatRateOfTurn(rad_s: number): string {
  const rate = degrees(rad_s) * 60;
  const size = Math.abs(rate).toFixed(1);
  return Number(size) === 0 ? "0.0°/min" : `${rate > 0 ? "S" : "P"} ${size}°/min`;
}

/** A distance in nautical miles: two decimals below ten, one above. */
export function formatMiles(m: number): string {
  const value = metresToMiles(m);
  return value.toFixed(Math.abs(value) < 9.995 ? 2 : 1);
}

export function formatKnots(m_s: number): string {
  return knots(m_s).toFixed(1);
}

/** A time span as `m:ss`, with hours from one hour on; negative times carry a minus sign. */
export function formatDuration(seconds: number): string {
  const sign = seconds < -0.5 ? "−" : "";
  const whole = Math.round(Math.abs(seconds));
  const s = String(whole % 60).padStart(2, "0");
  const m = Math.floor(whole / 60);
  if (m < 60) return `${sign}${String(m).padStart(2, "0")}:${s}`;
  return `${sign}${Math.floor(m / 60)}:${String(m % 60).padStart(2, "0")}:${s}`;
}

/** An age in seconds, minutes or hours: `4 s`, `3 min`, `2 h`. */
export function formatAge(seconds: number): string {
  if (seconds < 99.5) return `${Math.round(seconds)} s`;
  if (seconds < 5970) return `${Math.round(seconds / 60)} min`;
  return `${Math.round(seconds / 3600)} h`;
}

/** A relative bearing: `G 045°` (green, starboard), `R 012°` (red, port), `ahead`. */
export function formatRelativeBearing(rad: number): string {
  const deg = Math.round(degrees(rad));
  if (deg === 0) return "ahead";
  if (Math.abs(deg) >= 180) return "astern";
  return `${deg > 0 ? "G" : "R"} ${String(Math.abs(deg)).padStart(3, "0")}°`;
}

/** The time of a frame: UTC where the source has it, else the time since the start. */
export function formatTime(time_s: number, time_utc?: string | null): string {
  const utc = time_utc ? new Date(time_utc) : null;
  if (utc && !Number.isNaN(utc.getTime())) return `${utc.toISOString().slice(11, 19)} UTC`;
  return formatDuration(time_s);
}

/** A signed value of the critic, with three significant digits at most. */
export function formatValue(value: number): string {
  const size = Math.abs(value);
  const digits = size >= 10 ? 1 : size >= 0.095 ? 2 : 3;
  const text = size.toFixed(digits);
  return `${Number(text) === 0 ? "" : value < 0 ? "−" : "+"}${text}`;
}

/** A ship's name, shortened: `MMSI 230008070` becomes `230008070`. */
export function shortName(name: string, maxLength = 18): string {
  const plain = name.replace(/^MMSI /, "");
  return plain.length <= maxLength ? plain : `${plain.slice(0, maxLength - 1).trimEnd()}…`;
}
