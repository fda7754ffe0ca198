/** Which ship matters: danger with its zero and its scale, order by intention, ships of note. */

import type { Alarm, Frame, Target } from "../wire";

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
export function byIntention(a: Target, b: Target): number {
  return (
    order(size(a.intention), size(b.intention), 1e-4) ||
    order(a.attention, b.attention, 0.01) ||
    order(dangerOf(a), dangerOf(b), 1e-3) ||
    order(closeness(a), closeness(b), 1e-6) ||
    a.id.localeCompare(b.id, "en", { numeric: true })
  );
}

const size = (value: number | null | undefined): number | null =>
  value == null ? null : Math.abs(value);

/** The larger first; absent last; what differs by less than `grain` counts as equal. */
function order(a: number | null | undefined, b: number | null | undefined, grain: number): number {
  if (a == null || b == null) return Number(a == null) - Number(b == null);
  return Math.round(b / grain) - Math.round(a / grain) || 0;
}

/** A target beside what is said of her on the page. */
export interface Ranked {
  target: Target;
  alarm: Alarm | null;
  note: number;
}

/** How much a ship deserves to be looked at; alarms outweigh everything. */
export function noteOf(target: Target, alarm: Alarm | null, dangerScale: number): number {
  if (alarm) return 10 + closeness(target);
  const danger = Math.max(0, dangerOf(target) ?? 0) / dangerScale;
  return (target.attention ?? 0) + danger + Math.abs(target.intention ?? 0) + closeness(target);
}

export function ranked(frame: Frame, alarms: readonly Alarm[], dangerScale: number): Ranked[] {
  const byTarget = new Map(alarms.map((alarm) => [alarm.target, alarm]));
  return frame.targets
    .map((target) => {
      const alarm = byTarget.get(target.id) ?? null;
      return { target, alarm, note: noteOf(target, alarm, dangerScale) };
    })
    .sort((a, b) => byIntention(a.target, b.target));
}

/** The `most` ships of the greatest note, still in the order of the list. */
export function foremost(rows: readonly Ranked[], most: number): Ranked[] {
  const kept = new Set([...rows].sort((a, b) => b.note - a.note).slice(0, most));
  return rows.filter((row) => kept.has(row));
}
