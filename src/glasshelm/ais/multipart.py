"""Multipart AIS messages: fragments put together, in whatever order they come."""

from datetime import datetime
from typing import NamedTuple

from pyais.messages import AISSentence

from glasshelm.ais.nmea_sentence import NmeaLine
from glasshelm.ais.reports import Counts, RejectReason

#: Incomplete messages at a time; the oldest is given up for a new one.
MAX_PENDING = 32
#: A fragment that arrives before one it should follow is of the same message within so many
#: lines. Farther apart the sequence numbers (0 to 9) have come round: it is another message's.
NEAR_LINES = 8

_Key = tuple[object, ...]


class Fragment(NamedTuple):
    """One fragment, its line, and the number of that line."""

    sentence: AISSentence
    line: NmeaLine
    number: int


class FragmentAssembler:
    """The fragments of messages not yet complete. Those given up are counted as rejected."""

    def __init__(self, counts: Counts):
        self._counts = counts
        self._pending: dict[_Key, list[Fragment]] = {}

    def add(self, fragment: Fragment) -> list[Fragment] | None:
        """All fragments of the message that this one completes, in order; None before that."""
        key = _key(fragment)
        pending = self._pending.get(key)
        if pending is not None and not _belongs(fragment, pending):
            self._give_up(key)
            pending = None
        if pending is None:
            if len(self._pending) >= MAX_PENDING:
                self._give_up(next(iter(self._pending)))
            pending = self._pending[key] = []
        pending.append(fragment)
        if len(pending) < fragment.sentence.frag_cnt:
            return None
        del self._pending[key]
        return sorted(pending, key=lambda f: f.sentence.frag_num)

    def close(self) -> None:
        """Give up the messages that will not be completed."""
        for key in list(self._pending):
            self._give_up(key)

    def _give_up(self, key: _Key) -> None:
        self._counts.reject(RejectReason.INCOMPLETE, len(self._pending.pop(key)))


def time_and_station(fragments: list[Fragment]) -> tuple[datetime | None, str | None]:
    """The time and the station of a message: those of its first fragment that has one."""
    times = (fragment.line.time for fragment in fragments)
    stations = (fragment.line.station for fragment in fragments)
    return next(filter(None, times), None), next(filter(None, stations), None)


def _key(fragment: Fragment) -> _Key:
    s, group = fragment.sentence, fragment.line.group
    if group is not None:
        return "g", group.id, group.total, s.frag_cnt
    return s.talker_id, s.type, s.frag_cnt, s.channel, s.seq_id


def _belongs(fragment: Fragment, pending: list[Fragment]) -> bool:
    """Whether a fragment can be of the message whose fragments are pending."""
    number, present = fragment.sentence.frag_num, [f.sentence.frag_num for f in pending]
    in_order = present == list(range(1, number))
    return number not in present and (
        in_order or fragment.number - pending[-1].number <= NEAR_LINES
    )
