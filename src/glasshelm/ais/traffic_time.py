"""The time of the traffic: the one that most witnesses agree on, and that can heal.

A witness is a ship or a station; how often it speaks counts for nothing. Late is honest
(a report may come by a slow way), early is a clock that is wrong: so the time is the
latest that the majority has come to.
"""

import math
import time
from collections import deque

from glasshelm.ais.cleaning import AGREEING
from glasshelm.ais.mmsi import is_number

#: A time so far from that of the traffic [s], ahead or behind, is not believed.
BELIEVED_S = 600.0
#: A claim so far ahead [s] moves the time only with a majority: a wrong clock ages all ships ...
AHEAD_S = 60.0
#: ... and so far behind [s] it is no late report any more, but speaks for another time.
BEHIND_S = 240.0
#: A witness so far behind its own claim before [s] went back.
BACK_S = 60.0
#: A witness is silent if others' time went on for so long [s] since it spoke.
SILENT_S = 180.0
#: Newcomers alone change the time when they have told theirs for so long [s], or for as
#: long as the believed one was told.
LASTING_S = 60.0
#: Witnesses heard within so long [s] have a voice.
RECENT_S = 600.0
#: Times that are told beside each other, and witnesses of one, at most.
MOST_LINES = 16
MOST_WITNESSES = 300
#: Witnesses with wrong clocks that are remembered to be named, and named, at most.
MOST_WRONG = 64
MOST_NAMED = 3
_MARK_S = 10.0


class _Line:
    """Witnesses that agree on a time: who they are, and how far they have come."""

    def __init__(self, time_s: float):
        self.latest_s = -math.inf
        self.begun_s = time_s
        self.instants = 0
        self.order = 0
        #: The latest claim of each witness [s] and its place in the order of all claims.
        self.witnesses: dict[str, tuple[float, int]] = {}
        self._at_s = 0.0
        self._marks: deque[tuple[float, int]] = deque([(time_s, 0)])

    def join(self, witness: str, time_s: float, order: int) -> None:
        self.witnesses.pop(witness, None)
        self.witnesses[witness] = (time_s, order)
        if not self.order:
            self._marks[0] = (time_s, order)
        self.order = order
        if time_s <= self.latest_s:
            return
        self.instants += 1
        self.latest_s, self._at_s = time_s, time.monotonic()
        if time_s >= self._marks[-1][0] + _MARK_S:
            self._marks.append((time_s, order))
        while len(self._marks) > 1 and self._marks[1][0] <= time_s - SILENT_S:
            self._marks.popleft()

    @property
    def now_s(self) -> float:
        """The latest claim, and what has passed since."""
        return self.latest_s + time.monotonic() - self._at_s

    @property
    def lasted_s(self) -> float:
        """For how long this time has been told."""
        return self.latest_s - self.begun_s

    def takes(self, witness: str, time_s: float) -> bool:
        """Whether a claim is of this time; a witness that goes on in its own time always is."""
        if self.latest_s - BEHIND_S <= time_s <= self.now_s + AHEAD_S:
            return True
        before = self.witnesses.get(witness)
        return before is not None and before[0] <= time_s <= before[0] + BELIEVED_S

    def silent_before(self) -> int:
        """Who spoke before this place in the order is silent: this time went on without it."""
        marked_s, order = self._marks[0]
        return order if marked_s <= self.latest_s - SILENT_S else 0

    def voices(self, since: int, most: int) -> int:
        """How many witnesses were heard lately, and not before ``since``; counted to ``most``."""
        found = 0
        for told_s, order in reversed(self.witnesses.values()):
            if order < since or found > most:
                break
            found += told_s >= self.latest_s - RECENT_S
        return found

    def wall(self) -> bool:
        """Whether this machine's own clock is one more witness for this time."""
        return abs(time.time() - self.latest_s) <= BELIEVED_S


class TrafficTime:
    """The time of a stream, from what its witnesses claim.

    Claims that agree form a line; each witness stands in the one that it spoke for last.
    One line is believed. Another takes its place when it has more witnesses
    than the believed one has left, those that fell silent not counted; this machine's own clock
    is one more witness beside others for a time within ten minutes of it, and never needed.
    Witnesses that were never heard of the believed time must speak for a while. So a
    burst of a few moves nothing while others are known, a real gap or a recording that begins
    anew is followed as soon as most ships have, and no verdict is for ever.
    """

    def __init__(self) -> None:
        self._believed: _Line | None = None
        self._lines: list[_Line] = []
        self._of: dict[str, _Line] = {}
        self._last: dict[str, float] = {}
        self._order = 0
        #: Wrong clocks: how far ahead [s], first and last told [s], and when (in the true time).
        self._wrong: dict[str, tuple[float, float, float, float]] = {}

    @property
    def latest_s(self) -> float | None:
        """The latest time that is believed [s since 1970]; None before there is any."""
        return None if self._believed is None else self._believed.latest_s

    @property
    def now_s(self) -> float | None:
        """The same, plus the seconds since it arrived."""
        return None if self._believed is None else self._believed.now_s

    def tell(self, time_s: float, witness: str) -> bool:
        """Hear a claim [s since 1970]; whether it is believed now."""
        self._order += 1
        line = self._line_of(time_s, witness)
        before = self._of.pop(witness, None)
        if before is not None and before is not line:
            del before.witnesses[witness]
            if not before.witnesses and before is not self._believed:
                self._lines.remove(before)
        if witness not in line.witnesses and len(line.witnesses) >= MOST_WITNESSES:
            idle = next(iter(line.witnesses))
            del line.witnesses[idle], self._of[idle]
        line.join(witness, time_s, self._order)
        self._of[witness] = line
        if self._believed is None or (line is not self._believed and self._wins(line)):
            if self._believed is not None and not self._believed.witnesses:
                self._lines.remove(self._believed)
            self._believed, self._last = line, {}
        if line is self._believed:
            self._note_last(witness, time_s)
        latest_s, now_s = self._believed.latest_s, self._believed.now_s
        believed = latest_s - BELIEVED_S <= time_s <= now_s + BELIEVED_S
        if believed:
            self._wrong.pop(witness, None)
        else:
            self._note_wrong(witness, time_s, now_s)
        return believed

    def wrong(self) -> str | None:
        """One line for people about the clocks not believed of late; None if there are none.

        One told only once that lies behind may be an old report, and is not named.
        """
        now_s = self.latest_s
        if now_s is None:
            return None
        found = [
            f"{_called(witness)} ({_off(ahead_s)})"
            for witness, (ahead_s, first_s, last_s, at_s) in reversed(list(self._wrong.items()))
            if abs(now_s - at_s) <= RECENT_S and (ahead_s > 0 or first_s != last_s)
        ]
        if not found:
            return None
        more = len(found) - MOST_NAMED
        named = ", ".join(found[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
        return f"a clock that most others contradict is not believed: {named}"

    def _line_of(self, time_s: float, witness: str) -> _Line:
        """The line that a claim belongs to, or a new one."""
        believed = self._believed
        if believed is not None:
            back = time_s < self._last.get(witness, -math.inf) - BACK_S
            ahead = time_s > believed.now_s + AHEAD_S
            if not back and not ahead and believed.takes(witness, time_s):
                return believed
            for idle in [
                x for x in self._lines if x is not believed and x.order < believed.silent_before()
            ]:
                self._drop(idle)
        others = [
            x
            for x in self._lines
            if x is not believed and time_s >= x.latest_s - BACK_S and x.takes(witness, time_s)
        ]
        if others:
            return min(others, key=lambda x: abs(x.latest_s - time_s))
        if len(self._lines) >= MOST_LINES:
            self._drop(min((x for x in self._lines if x is not believed), key=lambda x: x.order))
        line = _Line(time_s)
        self._lines.append(line)
        return line

    def _drop(self, line: _Line) -> None:
        """Forget a line that nobody spoke for in a long time."""
        self._lines.remove(line)
        for witness in line.witnesses:
            del self._of[witness]

    def _wins(self, line: _Line) -> bool:
        """Whether another line has more voices than the believed one has left."""
        believed = self._believed
        assert believed is not None
        enough = len(line.witnesses) >= AGREEING or line.instants >= AGREEING
        if not enough and not 0 < line.latest_s - believed.latest_s <= BELIEVED_S:
            return False
        votes = line.voices(0, MOST_WITNESSES) + line.wall()
        left = believed.voices(line.silent_before(), votes)
        left += believed.wall() if left else 0
        if votes <= left:
            return False
        over = sum(1 for witness in line.witnesses if witness in self._last)
        return over > left or line.lasted_s >= min(believed.lasted_s, LASTING_S)

    def _note_last(self, witness: str, time_s: float) -> None:
        """Remember the latest claim of a witness of the believed time, also if it goes over."""
        self._last[witness] = max(time_s, self._last.pop(witness, time_s))
        if len(self._last) > 2 * MOST_WITNESSES:
            del self._last[next(iter(self._last))]

    def _note_wrong(self, witness: str, time_s: float, now_s: float) -> None:
        _, first_s, _, _ = self._wrong.pop(witness, (0.0, time_s, 0.0, 0.0))
        if len(self._wrong) >= MOST_WRONG:
            del self._wrong[next(iter(self._wrong))]
        self._wrong[witness] = (time_s - now_s, first_s, time_s, now_s)


def _called(witness: str) -> str:
    """How people call a witness."""
    if witness.startswith("station:"):
        return witness.replace(":", " ", 1)
    return f"MMSI {witness}" if is_number(witness) else witness


def _off(ahead_s: float) -> str:
    return f"{span(ahead_s)} {'ahead' if ahead_s > 0 else 'behind'}"


def span(seconds: float) -> str:
    """A time for people: ``"12 h"``, ``"25 min"``, ``"3 days"``."""
    seconds = abs(seconds)
    for unit_s, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= (2 * unit_s if unit == "days" else unit_s):
            many = seconds / unit_s
            return f"{many:,.0f} {unit}" if many >= 100 else f"{round(many, 1):g} {unit}"
    return f"{seconds:.0f} s"
