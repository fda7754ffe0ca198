"""Reports between two looks: put aside as they come, and taken so that the picture is of now."""

import heapq
import time
from collections import deque

from glasshelm.ais.reports import Report
from glasshelm.live.traffic_picture import TrafficPicture

#: Reports that wait at most, own ship's and all others'; of more the oldest are left out.
MOST_OWN = 2_000
MOST_OTHERS = 20_000
#: A look takes reports for about so long [s]: no more of them than that allowed the last time, ...
TAKE_S = 0.5
#: ... but so many in any case.
LEAST_TAKEN = 500


class ReportQueue:
    """Holds what was heard since the last look.

    One thread puts, another takes. ``left_out`` counts what came faster than it could be taken.
    """

    def __init__(self) -> None:
        # Own ship's beside the others', so that no flood washes them away.
        self._own: deque[tuple[int, Report]] = deque(maxlen=MOST_OWN)
        self._others: deque[tuple[int, Report]] = deque(maxlen=MOST_OTHERS)
        self._put = self._taken = 0
        self._affordable = MOST_OTHERS
        self.left_out = 0

    def __len__(self) -> int:
        return len(self._own) + len(self._others)

    def put(self, report: Report) -> None:
        """Put a report aside."""
        (self._own if report.own else self._others).append((self._put, report))
        self._put += 1

    def take(self, picture: TrafficPicture) -> None:
        """Let a picture take what waits now, in the order in which it came.

        Of more than can be afforded: all of own ship, and half of the latest, half of the nearest
        among the last reports of each ship before.
        """
        begun = time.monotonic()
        own = [self._own.popleft() for _ in range(len(self._own))]
        others = [self._others.popleft() for _ in range(len(self._others))]
        if len(others) > self._affordable:
            late = others[-(self._affordable // 2) :]
            early = {
                (report.id, report.latitude_deg is None): (number, report)
                for number, report in others[: -len(late)]
            }
            away = ((picture.away_m(one[1]), one) for one in early.values())
            near = heapq.nsmallest(self._affordable // 2, away, key=lambda x: x[0])
            others = [one for _, one in near] + late
        taken = 0
        taken = 0
        for _, report in sorted([*own, *others], key=lambda one: one[0]):
            picture.take(report)
            taken += 1
            if time.monotonic() > begun + 2 * TAKE_S:
                break
        self._taken += taken
        self.left_out = max(self._put - self._taken - len(self), self.left_out)
        a_look = taken * TAKE_S / max(time.monotonic() - begun, 1e-6)
        self._affordable = max(min(int(a_look), MOST_OTHERS), LEAST_TAKEN)
