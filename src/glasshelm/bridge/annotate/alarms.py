"""Alarms, from the closest point of approach alone: the pilot's opinion plays no part.

An alarm is raised where DCPA and TCPA of a target are both below the limits,
and stays until either is well above: a value that trembles about its limit
does not ring twice. One alarm a target; a lost target raises none, but keeps
hers as long as she is shown.
"""

import dataclasses

from glasshelm.bridge.server.protocol import Alarm, SetLimits
from glasshelm.frames.phrases import approach, lasting, miles
from glasshelm.frames.schema import Frame, Target

#: An alarm goes where a value is above its limit by this factor ...
RELEASE = 1.1
#: ... or the closest approach has been past for so long [s].
PAST_S = 15.0


@dataclasses.dataclass(frozen=True)
class _ActiveAlarm:
    id: str
    since_s: float
    acknowledged: bool = False


class AlarmList:
    """The alarms of a session; ``limits`` may be set at any time."""

    def __init__(self, limits: SetLimits = SetLimits()):
        self.limits = limits
        self._raised: dict[str, _ActiveAlarm] = {}
        self._number = 0

    def update(self, frame: Frame) -> list[Alarm]:
        """The alarms of this instant, the soonest first."""
        here = {target.id: target for target in frame.targets}
        raised = {i: a for i, a in self._raised.items() if i in here and self._stays(here[i])}
        for target in here.values():
            if target.id not in raised and self._begins(target):
                self._number += 1
                raised[target.id] = _ActiveAlarm(f"cpa-{self._number}", frame.time_s)
        self._raised = raised
        told = [self._told(here[i], alarm) for i, alarm in raised.items()]
        return sorted(told, key=lambda alarm: (alarm.tcpa_s, alarm.dcpa_m))

    def acknowledge(self, id: str) -> bool:
        """Whether there is such an alarm; acknowledged from now on."""
        for target, alarm in self._raised.items():
            if alarm.id == id:
                self._raised[target] = dataclasses.replace(alarm, acknowledged=True)
                return True
        return False

    def _begins(self, target: Target) -> bool:
        near = target.dcpa_m < self.limits.dcpa_m
        return near and 0 <= target.tcpa_s < self.limits.tcpa_s and not target.lost

    def _stays(self, target: Target) -> bool:
        near = target.dcpa_m <= RELEASE * self.limits.dcpa_m
        return target.lost or (near and -PAST_S < target.tcpa_s <= RELEASE * self.limits.tcpa_s)

    def _told(self, target: Target, alarm: _ActiveAlarm) -> Alarm:
        limit = f"limits {miles(self.limits.dcpa_m)} and {lasting(self.limits.tcpa_s)}"
        lost = "; lost, as last heard" if target.lost else ""
        return Alarm(
            alarm.id,
            target.id,
            target.name,
            target.dcpa_m,
            target.tcpa_s,
            alarm.since_s,
            "acknowledged" if alarm.acknowledged else "unacknowledged",
            f"{approach(target.dcpa_m, target.tcpa_s)}; {limit}{lost}",
        )
