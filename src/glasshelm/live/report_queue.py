"""Reports between two frames: queued as they come, and drained into the traffic picture."""

import heapq
import time
from collections import deque

from glasshelm.ais.reports import Report
from glasshelm.live.traffic_picture import TrafficPicture

#: Reports that wait at most, own ship's and all others'; of more the oldest are dropped.
MAX_OWN = 2_000
MAX_OTHERS = 20_000
#: Draining takes about so long [s]: no more reports than that allowed the last time, ...
DRAIN_S = 0.5
#: ... but so many in any case.
MIN_DRAINED = 500


class ReportQueue:
    """Holds what was received since it was last drained.

    One thread puts, another drains. ``n_dropped`` counts what came faster than it was taken.
    """

    def __init__(self) -> None:
        # Own ship's reports apart, so that no flood washes them away.
        self._own: deque[tuple[int, Report]] = deque(maxlen=MAX_OWN)
        self._others: deque[tuple[int, Report]] = deque(maxlen=MAX_OTHERS)
        self._n_put = self._n_taken = 0
        self._affordable = MAX_OTHERS
        self.n_dropped = 0

    def __len__(self) -> int:
        return len(self._own) + len(self._others)

    def put(self, report: Report) -> None:
        """Queue a report."""
        (self._own if report.is_own else self._others).append((self._n_put, report))
        self._n_put += 1

    def drain_into(self, picture: TrafficPicture) -> None:
        """Let a picture take what is queued, in the order in which it came.

        Of more than can be afforded: all of own ship, and half of the latest, half of the nearest
        among the last reports of each ship before.
        """
        begin = time.monotonic()
        own = [self._own.popleft() for _ in range(len(self._own))]
        others = [self._others.popleft() for _ in range(len(self._others))]
        if len(others) > self._affordable:
            late = others[-(self._affordable // 2) :]
            early = {
                (report.id, report.latitude_deg is None): (number, report)
                for number, report in others[: -len(late)]
            }
            distances = ((picture.distance_m(one[1]), one) for one in early.values())
            near = heapq.nsmallest(self._affordable // 2, distances, key=lambda x: x[0])
            others = [one for _, one in near] + late
        n_taken = 0
        for _, report in sorted([*own, *others], key=lambda one: one[0]):
            picture.update(report)
            n_taken += 1
            if time.monotonic() > begin + 2 * DRAIN_S:
                break
        self._n_taken += n_taken
        self.n_dropped = max(self._n_put - self._n_taken - len(self), self.n_dropped)
        affordable = n_taken * DRAIN_S / max(time.monotonic() - begin, 1e-6)
        self._affordable = max(min(int(affordable), MAX_OTHERS), MIN_DRAINED)
