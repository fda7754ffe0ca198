/** Which ship matters: danger with its zero and its scale, alarms first, then intention; ships of note. */

import type { Alarm, Frame, Target } from "../protocol.gen";

/** How far the critic puts a ship below one that is far off and opening; `null` without critic. */
export function dangerOf(target: Target): number | null {
  const { q, q_far } = target;
  return q == null || q_far == null ? null : q_far - q;
}

/** A round number at or above every value, so that a scale does not jump: 0.5, 1, 2, 5, 10 … */
export function roundScale(largest: number, least = 0.5): number {
  for (let decade = 0.01; decade < 1e6; decade *= 10)
    for (const digit of [1, 2, 5]) {
      const scale = Number((digit * decade).toPrecision(1));
      if (scale >= least && scale >= largest) return scale;
    }
  return largest;
}

/** The largest danger among ships that are shown to the pilot. */
export function largestDanger(frames: readonly Frame[]): number {
  let most = 0;
  for (const frame of frames)
    for (const target of frame.targets) most = Math.max(most, dangerOf(target) ?? 0);
  return most;
}

export const largestIntention = (frame: Frame): number =>
  frame.targets.reduce((most, t) => Math.max(most, Math.abs(t.intention ?? 0)), 0);

/** How soon and how near a ship comes, between 0 (no matter) and 1 (here, now). */
export function closeness(target: Target): number {
  if (target.tcpa_s <= 0) return 0.3 * Math.exp(-target.range_m / 1852);
  return Math.exp(-target.dcpa_m / 1852 - target.tcpa_s / 900);
}

/**
 * The largest intention first (Eq. 24), whichever its sign: the ship that the rudder serves or
 * costs most. Where there is none, attention, then danger, then closeness.
 */
export function compareByIntention(a: Target, b: Target): number {
  return (
    compareDescending(magnitude(a.intention), magnitude(b.intention), 1e-4) ||
    compareDescending(a.attention, b.attention, 0.01) ||
    compareDescending(dangerOf(a), dangerOf(b), 1e-3) ||
    compareDescending(closeness(a), closeness(b), 1e-6) ||
    a.id.localeCompare(b.id, "en", { numeric: true })
  );
}

const magnitude = (value: number | null | undefined): number | null =>
  value == null ? null : Math.abs(value);

/** The larger first; absent last; what differs by less than `grain` counts as equal. */
function compareDescending(
  a: number | null | undefined,
  b: number | null | undefined,
  grain: number,
): number {
  if (a == null || b == null) return Number(a == null) - Number(b == null);
  return Math.round(b / grain) - Math.round(a / grain) || 0;
}

/** Alarms in the order in which they are told: those not acknowledged first, then the soonest. */
export const compareAlarms = (a: Alarm, b: Alarm): number =>
  Number(a.state === "acknowledged") - Number(b.state === "acknowledged") ||
  a.tcpa_s - b.tcpa_s ||
  a.dcpa_m - b.dcpa_m;

/** A target beside what is said of her on the page. */
export interface RankedTarget {
  target: Target;
  alarm: Alarm | null;
  prominence: number;
}

/** How much a ship deserves to be looked at; alarms outweigh everything, in the order of `byUrgency`. */
export function prominenceOf(target: Target, alarm: Alarm | null, dangerScale: number): number {
  if (alarm)
    return (
      (alarm.state === "acknowledged" ? 10 : 20) + Math.exp(-Math.max(alarm.tcpa_s, -60) / 900)
    );
  const danger = Math.max(0, dangerOf(target) ?? 0) / dangerScale;
  return (target.attention ?? 0) + danger + Math.abs(target.intention ?? 0) + closeness(target);
}

/** The order of the list: ships under alarm first, by `byUrgency`; the others by intention. */
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

/** So many alarms are told one by one, and their ships always have a colour. */
export const MAX_NAMED_ALARMS = 3;
/** Who has a colour keeps it until another is of more note by this: no two take turns. */
const COLOUR_HYSTERESIS = 0.1;

/** Ids of all ships, those first that are to have a colour: whom the alarms name, then by note. */
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
