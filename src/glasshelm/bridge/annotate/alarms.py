"""CPA alarms, from DCPA and TCPA alone: the pilot's opinion plays no part.

An alarm is raised when DCPA and TCPA of a target are both below the limits, and stays until either
is well above its limit, so a value that hovers around the limit does not ring twice. Each target
has at most one alarm. A lost target raises none, but keeps its alarm while it is shown.
"""

import dataclasses

from glasshelm.bridge.server.protocol import DEFAULT_ALARM_LIMITS, Alarm, AlarmLimits
from glasshelm.frames.phrases import cpa_words, duration, miles
from glasshelm.frames.schema import Frame, Target

#: An alarm ends when a value exceeds its limit by this factor ...
RELEASE = 1.1
#: ... or when the closest approach has been past for so long [s].
PAST_S = 15.0


@dataclasses.dataclass(frozen=True)
class _ActiveAlarm:
    id: str
    since_s: float
    acknowledged: bool = False


class AlarmList:
    """The alarms of a session; ``limits`` may be set at any time."""

    def __init__(self, limits: AlarmLimits = DEFAULT_ALARM_LIMITS):
        self.limits = limits
        self._active: dict[str, _ActiveAlarm] = {}
        self._n_raised = 0

    def update(self, frame: Frame) -> list[Alarm]:
        """Return the alarms of this frame, soonest first."""
        targets = {target.id: target for target in frame.targets}
        kept = {i: a for i, a in self._active.items() if i in targets and self._stays(targets[i])}
        for target in targets.values():
            if target.id not in kept and self._is_raised(target):
                self._n_raised += 1
                kept[target.id] = _ActiveAlarm(f"cpa-{self._n_raised}", frame.time_s)
        self._active = kept
        alarms = [self._message(targets[i], alarm) for i, alarm in kept.items()]
        return sorted(alarms, key=lambda alarm: (alarm.tcpa_s, alarm.dcpa_m))

    def acknowledge(self, id: str) -> bool:
        """Acknowledge an alarm; return whether there is such an alarm."""
        for target, alarm in self._active.items():
            if alarm.id == id:
                self._active[target] = dataclasses.replace(alarm, acknowledged=True)
                return True
        return False

    def _is_raised(self, target: Target) -> bool:
        near = target.dcpa_m < self.limits.dcpa_m
        return near and 0 <= target.tcpa_s < self.limits.tcpa_s and not target.lost

    def _stays(self, target: Target) -> bool:
        near = target.dcpa_m <= RELEASE * self.limits.dcpa_m
        return target.lost or (near and -PAST_S < target.tcpa_s <= RELEASE * self.limits.tcpa_s)

    def _message(self, target: Target, alarm: _ActiveAlarm) -> Alarm:
        limits = f"limits {miles(self.limits.dcpa_m)} and {duration(self.limits.tcpa_s)}"
        lost = "; lost, as last heard" if target.lost else ""
        return Alarm(
            alarm.id,
            target.id,
            target.name,
            target.dcpa_m,
            target.tcpa_s,
            alarm.since_s,
            "acknowledged" if alarm.acknowledged else "unacknowledged",
            f"{cpa_words(target.dcpa_m, target.tcpa_s)}; {limits}{lost}",
        )
