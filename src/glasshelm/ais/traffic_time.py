"""The time of the traffic: the one that most sources agree on, and that can be corrected.

A source is a ship or a station; how often it reports counts for nothing. A report may come
late by a slow path, but an early one is from a wrong clock: so the time is the
latest that the majority has reached.
"""

import math
import time
from collections import deque
from datetime import UTC, datetime

from glasshelm.ais.cleaning import N_AGREEING
from glasshelm.ais.mmsi import is_number, station_label
from glasshelm.ais.reports import Counts
from glasshelm.ais.timestamps import format_duration, from_epoch

#: A time so far from that of the traffic [s], ahead or behind, is not believed.
TOLERANCE_S = 600.0
#: A time so far ahead [s] is taken over only with a majority: a wrong clock ages all ships ...
AHEAD_S = 60.0
#: ... and one so far behind [s] is no late report any more, but of another timeline.
BEHIND_S = 240.0
#: A source so far behind its own report before [s] went back in time.
BACKWARD_S = 60.0
#: A source is silent if others' time went on for so long [s] since its last report.
SILENT_S = 180.0
#: New sources alone change the time when they have reported theirs for so long [s], or for as
#: long as the believed one was reported.
LASTING_S = 60.0
#: Sources received within so long [s] are counted.
RECENT_S = 600.0
#: Timelines at a time, and sources of one, at most.
MAX_TIMELINES = 16
MAX_SOURCES = 300
#: Wrong clocks that are remembered, and named.
MAX_REJECTED = 64
MAX_NAMED = 3
_MARK_S = 10.0


class _Timeline:
    """Sources that agree on a time: who they are, and how far they have come."""

    def __init__(self, time_s: float):
        self.latest_s = -math.inf
        self.begin_s = time_s
        self.n_instants = 0
        self.order = 0
        #: The latest time of each source [s], and its place in the order of all updates.
        self.sources: dict[str, tuple[float, int]] = {}
        self._updated_at_s = 0.0
        self._marks: deque[tuple[float, int]] = deque([(time_s, 0)])

    def add(self, source: str, time_s: float, order: int) -> None:
        self.sources.pop(source, None)
        self.sources[source] = (time_s, order)
        if not self.order:
            self._marks[0] = (time_s, order)
        self.order = order
        if time_s <= self.latest_s:
            return
        self.n_instants += 1
        self.latest_s, self._updated_at_s = time_s, time.monotonic()
        if time_s >= self._marks[-1][0] + _MARK_S:
            self._marks.append((time_s, order))
        while len(self._marks) > 1 and self._marks[1][0] <= time_s - SILENT_S:
            self._marks.popleft()

    @property
    def now_s(self) -> float:
        """The latest time, and what has passed since."""
        return self.latest_s + time.monotonic() - self._updated_at_s

    @property
    def duration_s(self) -> float:
        """For how long this time has been reported."""
        return self.latest_s - self.begin_s

    def accepts(self, source: str, time_s: float) -> bool:
        """Whether a time is of this timeline; a source that goes on in its own time always is."""
        if self.latest_s - BEHIND_S <= time_s <= self.now_s + AHEAD_S:
            return True
        before = self.sources.get(source)
        return before is not None and before[0] <= time_s <= before[0] + TOLERANCE_S

    def silent_before(self) -> int:
        """Sources last updated before this place in the order are silent."""
        marked_s, order = self._marks[0]
        return order if marked_s <= self.latest_s - SILENT_S else 0

    def n_active(self, since: int, limit: int) -> int:
        """How many sources reported lately, and not before ``since``; counted to ``limit``."""
        count = 0
        for time_s, order in reversed(self.sources.values()):
            if order < since or count > limit:
                break
            count += time_s >= self.latest_s - RECENT_S
        return count

    def agrees_with_system(self) -> bool:
        """Whether this machine's own clock is one more source of this time."""
        return abs(time.time() - self.latest_s) <= TOLERANCE_S


class TrafficTime:
    """The time of a stream, from the times that its sources report.

    Times that agree form a timeline; each source is in the one that it reported last.
    One timeline is believed. Another takes its place when it has more active sources
    than the believed one; this machine's own clock is one more source for a time within ten
    minutes of it, beside others and never needed. Sources that were never of the believed time
    must report for a while. So a burst of a few moves nothing while others are known, a real
    gap or a recording that starts over is followed as soon as most ships have, and no
    verdict is for ever.
    """

    def __init__(self) -> None:
        self._believed: _Timeline | None = None
        self._timelines: list[_Timeline] = []
        self._timeline_of: dict[str, _Timeline] = {}
        #: The latest time of each source that was ever of the believed timeline.
        self._believed_times: dict[str, float] = {}
        self._order = 0
        #: Wrong clocks: how far ahead [s], first and last time [s], and when (in the true time).
        self._rejected: dict[str, tuple[float, float, float, float]] = {}

    @property
    def latest_s(self) -> float | None:
        """The latest time that is believed [s since 1970]; None before the first."""
        return None if self._believed is None else self._believed.latest_s

    @property
    def now_s(self) -> float | None:
        """The same, and the seconds that passed since it was received."""
        return None if self._believed is None else self._believed.now_s

    def update(self, time_s: float, source: str) -> bool:
        """Take a time [s since 1970] that a source reports; whether it is believed now."""
        self._order += 1
        timeline = self._find(time_s, source)
        before = self._timeline_of.pop(source, None)
        if before is not None and before is not timeline:
            del before.sources[source]
            if not before.sources and before is not self._believed:
                self._timelines.remove(before)
        if source not in timeline.sources and len(timeline.sources) >= MAX_SOURCES:
            idle = next(iter(timeline.sources))
            del timeline.sources[idle], self._timeline_of[idle]
        timeline.add(source, time_s, self._order)
        self._timeline_of[source] = timeline
        if self._believed is None or (timeline is not self._believed and self._wins(timeline)):
            if self._believed is not None and not self._believed.sources:
                self._timelines.remove(self._believed)
            self._believed, self._believed_times = timeline, {}
        if timeline is self._believed:
            self._note_believed(source, time_s)
        latest_s, now_s = self._believed.latest_s, self._believed.now_s
        believed = latest_s - TOLERANCE_S <= time_s <= now_s + TOLERANCE_S
        if believed:
            self._rejected.pop(source, None)
        else:
            self._note_rejected(source, time_s, now_s)
        return believed

    def rejected_clocks(self) -> str | None:
        """One line for people about the clocks not believed lately; None if there are none.

        One that reported only once and lies behind may be an old report, and is not named.
        """
        now_s = self.latest_s
        if now_s is None:
            return None
        found = [
            f"{_source_label(source)} ({format_duration(ahead_s)} "
            f"{'ahead' if ahead_s > 0 else 'behind'})"
            for source, (ahead_s, first_s, last_s, at_s) in reversed(list(self._rejected.items()))
            if abs(now_s - at_s) <= RECENT_S and (ahead_s > 0 or first_s != last_s)
        ]
        if not found:
            return None
        more = len(found) - MAX_NAMED
        named = ", ".join(found[:MAX_NAMED]) + (f" and {more} more" if more > 0 else "")
        return f"a clock that most others contradict is not believed: {named}"

    def _find(self, time_s: float, source: str) -> _Timeline:
        """The timeline that a time belongs to, or a new one."""
        believed = self._believed
        if believed is not None:
            back = time_s < self._believed_times.get(source, -math.inf) - BACKWARD_S
            ahead = time_s > believed.now_s + AHEAD_S
            if not back and not ahead and believed.accepts(source, time_s):
                return believed
            for idle in [x for x in self._others() if x.order < believed.silent_before()]:
                self._drop(idle)
        fitting = [
            x
            for x in self._others()
            if time_s >= x.latest_s - BACKWARD_S and x.accepts(source, time_s)
        ]
        if fitting:
            return min(fitting, key=lambda x: abs(x.latest_s - time_s))
        if len(self._timelines) >= MAX_TIMELINES:
            self._drop(min(self._others(), key=lambda x: x.order))
        timeline = _Timeline(time_s)
        self._timelines.append(timeline)
        return timeline

    def _others(self) -> list[_Timeline]:
        return [x for x in self._timelines if x is not self._believed]

    def _drop(self, timeline: _Timeline) -> None:
        """Forget a timeline that no source reported in a long time."""
        self._timelines.remove(timeline)
        for source in timeline.sources:
            del self._timeline_of[source]

    def _wins(self, timeline: _Timeline) -> bool:
        """Whether another timeline has more active sources than the believed one has left."""
        believed = self._believed
        assert believed is not None
        enough = len(timeline.sources) >= N_AGREEING or timeline.n_instants >= N_AGREEING
        if not enough and not 0 < timeline.latest_s - believed.latest_s <= TOLERANCE_S:
            return False
        votes = timeline.n_active(0, MAX_SOURCES) + timeline.agrees_with_system()
        left = believed.n_active(timeline.silent_before(), votes)
        left += believed.agrees_with_system() if left else 0
        if votes <= left:
            return False
        changed_over = sum(1 for source in timeline.sources if source in self._believed_times)
        return changed_over > left or timeline.duration_s >= min(believed.duration_s, LASTING_S)

    def _note_believed(self, source: str, time_s: float) -> None:
        """Remember the latest time of a source of the believed time, also if it changes over."""
        self._believed_times[source] = max(time_s, self._believed_times.pop(source, time_s))
        if len(self._believed_times) > 2 * MAX_SOURCES:
            del self._believed_times[next(iter(self._believed_times))]

    def _note_rejected(self, source: str, time_s: float, now_s: float) -> None:
        _, first_s, _, _ = self._rejected.pop(source, (0.0, time_s, 0.0, 0.0))
        if len(self._rejected) >= MAX_REJECTED:
            del self._rejected[next(iter(self._rejected))]
        self._rejected[source] = (time_s - now_s, first_s, time_s, now_s)


class StreamClock:
    """Gives every message a time, also those without one.

    A stream whose messages have times (tag blocks) may be a recording played again years
    later. Its other messages then get the latest time that is believed, and of a live
    stream also the seconds passed since. A live stream without any time is dated by
    arrival; a file without has no time.

    Args:
        live: Whether the stream is live.
        counts: Their summary names the clocks that are not believed.
    """

    def __init__(self, live: bool, counts: Counts | None = None):
        self.live = live
        self._time = TrafficTime()
        if counts is not None:
            counts.remark = self._time.rejected_clocks

    def update(self, time: datetime, source: str) -> datetime | None:
        """Take the time of a message of a ship or ``station:NAME``; None: not believed now."""
        return time if self._time.update(time.timestamp(), source) else None

    def now(self) -> datetime | None:
        """The time of a message without one."""
        time_s = self._time.now_s if self.live else self._time.latest_s
        if time_s is None:
            return datetime.now(UTC) if self.live else None
        return from_epoch(time_s)


def _source_label(source: str) -> str:
    """The name of a source for people."""
    if source.startswith("station:"):
        return source.replace(":", " ", 1)
    return station_label(source) if is_number(source) else source
