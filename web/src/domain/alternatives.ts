/** The manoeuvres that a glassbox pilot compared with the one it chose, and what speaks against each. */

import type { Alternative, BySubTask, Frame } from "../protocol.gen";

/** A sub-task, or the id of a ship. */
export type Reason = { task: "waypoint" | "helm" } | { ship: string };

export interface ComparedCourse {
  label: string;
  courseRad: number;
  /** Points that it is worth less than the chosen manoeuvre; 0 if it is that one. */
  loss: number;
  /** The part of the value that costs it most, and how much of the loss that is. */
  reason: Reason | null;
  reasonLoss: number;
}

const LABELS = new Map([
  ["best to starboard", "Starboard"],
  ["best to port", "Port"],
  ["keep", "Keep course"],
  ["to the waypoint", "To waypoint"],
]);
/** A smaller difference [points] is none. */
const NOTHING = 0.05;

export function comparedCourses(frame: Frame): ComparedCourse[] {
  const chosen = frame.value;
  if (!frame.alternatives || !chosen) return [];
  return [...LABELS].flatMap(([name, label]) => {
    const alternative = frame.alternatives!.find((a) => a.name === name);
    return alternative ? [compare(frame, chosen, alternative, label)] : [];
  });
}

function compare(
  frame: Frame,
  chosen: BySubTask,
  alternative: Alternative,
  label: string,
): ComparedCourse {
  const losses: [Reason, number][] = [
    [{ task: "waypoint" }, chosen.waypoint - alternative.value.waypoint],
    [{ task: "helm" }, (chosen.helm ?? 0) - (alternative.value.helm ?? 0)],
    ...frame.targets.map((t): [Reason, number] => [
      { ship: t.id },
      (t.q ?? 0) - (alternative.by_target[t.id] ?? 0),
    ]),
  ];
  const [reason, reasonLoss] = losses.reduce((a, b) => (b[1] > a[1] ? b : a));
  const loss = (chosen.total ?? 0) - (alternative.value.total ?? 0);
  const same = loss < NOTHING;
  return {
    label,
    courseRad: alternative.course_rad,
    loss: same ? 0 : loss,
    reason: same || reasonLoss < NOTHING ? null : reason,
    reasonLoss,
  };
}
