/** Which ships matter: the order of the list, and which ships get a colour. */

import type { Alarm, Frame, Target } from "../protocol.gen";
import { NAUTICAL_MILE_M } from "./units";

/**
 * How much lower the critic values a ship than a distant, opening one; `null` without a critic.
 * Of a pilot that compares manoeuvres: if course and speed were kept, for the chosen one avoids it.
 */
export function criticDanger(target: Target): number | null {
  const { q, q_far, priority, course_shapley_rad } = target;
  if (q != null && priority != null && course_shapley_rad != null) return priority - q;
  return q == null || q_far == null ? null : q_far - q;
}

/** The smallest of 0.5, 1, 2, 5, 10 … that is not below `largest`: a scale that seldom changes. */
export function roundScale(largest: number, minimum = 0.5): number {
  for (let decade = 0.01; decade < 1e6; decade *= 10)
    for (const digit of [1, 2, 5]) {
      const scale = Number((digit * decade).toPrecision(1));
      if (scale >= minimum && scale >= largest) return scale;
    }
  return largest;
}

/** The largest danger to the critic in any of the frames. */
export function largestDanger(frames: readonly Frame[]): number {
  let largest = 0;
  for (const frame of frames)
    for (const target of frame.targets) largest = Math.max(largest, criticDanger(target) ?? 0);
  return largest;
}

export const largestIntention = (frame: Frame): number =>
  frame.targets.reduce((largest, t) => Math.max(largest, Math.abs(t.intention ?? 0)), 0);

/** How soon and how close a ship comes, from 0 (never) to 1 (here and now). */
export function closeness(target: Target): number {
  if (target.tcpa_s <= 0) return 0.3 * Math.exp(-target.range_m / NAUTICAL_MILE_M);
  return Math.exp(-target.dcpa_m / NAUTICAL_MILE_M - target.tcpa_s / 900);
}

/**
 * The largest absolute intention first (Eq. 24): the ship that the rudder helps or hurts most.
 * Ties are broken by attention, then danger, then closeness.
 */
export function compareByIntention(a: Target, b: Target): number {
  return (
    compareDescending(magnitude(a.intention), magnitude(b.intention), 1e-4) ||
    compareDescending(a.attention, b.attention, 0.01) ||
    compareDescending(criticDanger(a), criticDanger(b), 1e-3) ||
    compareDescending(closeness(a), closeness(b), 1e-6) ||
    a.id.localeCompare(b.id, "en", { numeric: true })
  );
}

const magnitude = (value: number | null | undefined): number | null =>
  value == null ? null : Math.abs(value);

/** Larger values first, absent ones last; values that round to the same multiple of `grain` tie. */
function compareDescending(
  a: number | null | undefined,
  b: number | null | undefined,
  grain: number,
): number {
  if (a == null || b == null) return Number(a == null) - Number(b == null);
  return Math.round(b / grain) - Math.round(a / grain) || 0;
}

/** Unacknowledged alarms first, then the smallest TCPA. */
export const compareAlarms = (a: Alarm, b: Alarm): number =>
  Number(a.state === "acknowledged") - Number(b.state === "acknowledged") ||
  a.tcpa_s - b.tcpa_s ||
  a.dcpa_m - b.dcpa_m;

export interface RankedTarget {
  target: Target;
  alarm: Alarm | null;
  /** How much attention the ship deserves on the page. */
  prominence: number;
}

/** Alarms outweigh everything else, in the order of `compareAlarms`. */
export function prominenceOf(target: Target, alarm: Alarm | null, dangerScale: number): number {
  if (alarm)
    return (
      (alarm.state === "acknowledged" ? 10 : 20) + Math.exp(-Math.max(alarm.tcpa_s, -60) / 900)
    );
  const danger = Math.max(0, criticDanger(target) ?? 0) / dangerScale;
  return (target.attention ?? 0) + danger + Math.abs(target.intention ?? 0) + closeness(target);
}

/** The order of the list: ships under alarm first, then by intention. */
export function rankTargets(
  frame: Frame,
  alarms: readonly Alarm[],
  dangerScale: number,
): RankedTarget[] {
  const byTarget = new Map(alarms.map((alarm) => [alarm.target, alarm]));
  return frame.targets
    .map((target) => {
      const alarm = byTarget.get(target.id) ?? null;
      return { target, alarm, prominence: prominenceOf(target, alarm, dangerScale) };
    })
    .sort((a, b) => {
      if (a.alarm && b.alarm)
        return compareAlarms(a.alarm, b.alarm) || compareByIntention(a.target, b.target);
      return Number(!a.alarm) - Number(!b.alarm) || compareByIntention(a.target, b.target);
    });
}

/** The alarm strip names so many ships, and they always have a colour. */
export const MAX_NAMED_ALARMS = 3;
/** A ship keeps its colour until another is more prominent by this much, so colours do not flicker. */
const COLOUR_HYSTERESIS = 0.1;

/** Ids of all ships in the order in which they get a colour: named alarms, then prominence. */
export function idsByProminence(
  rows: readonly RankedTarget[],
  hasColour: (id: string) => boolean,
): string[] {
  const named = rows.filter((row) => row.alarm).slice(0, MAX_NAMED_ALARMS);
  const score = (row: RankedTarget): number =>
    row.prominence + (hasColour(row.target.id) ? COLOUR_HYSTERESIS : 0);
  const others = rows.filter((row) => !named.includes(row)).sort((a, b) => score(b) - score(a));
  return [...named, ...others].map((row) => row.target.id);
}
