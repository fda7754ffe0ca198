"""Messages that come in parts: put together, in whatever order the parts come."""

from datetime import datetime
from typing import NamedTuple

from pyais.messages import AISSentence

from glasshelm.ais.nmea_sentence import Framed
from glasshelm.ais.reports import Counts, RejectReason

#: Messages that may be incomplete at a time; the oldest is given up for a new one.
MOST_WAITING = 32
#: A part that comes before one it should follow belongs to it within so many lines. Farther
#: apart the numbers of messages (0 to 9) have come round, and it is another message's.
NEAR_LINES = 8

_Slot = tuple[object, ...]


class Part(NamedTuple):
    """One part, and what its line says about it."""

    sentence: AISSentence
    framed: Framed
    line: int


class Parts:
    """The parts of messages not yet complete. What is given up is counted as refused."""

    def __init__(self, counts: Counts):
        self._counts = counts
        self._waiting: dict[_Slot, list[Part]] = {}

    def add(self, part: Part) -> list[Part] | None:
        """All parts of the message that this one completes, in order; None while others miss."""
        slot = _slot(part)
        waiting = self._waiting.get(slot)
        if waiting is not None and not _belongs(part, waiting):
            self._give_up(slot)
            waiting = None
        if waiting is None:
            if len(self._waiting) >= MOST_WAITING:
                self._give_up(next(iter(self._waiting)))
            waiting = self._waiting[slot] = []
        waiting.append(part)
        if len(waiting) < part.sentence.frag_cnt:
            return None
        del self._waiting[slot]
        return sorted(waiting, key=lambda p: p.sentence.frag_num)

    def end(self) -> None:
        """Give up the messages that will not be completed."""
        for slot in list(self._waiting):
            self._give_up(slot)

    def _give_up(self, slot: _Slot) -> None:
        self._counts.refuse(RejectReason.PART_MISSING, len(self._waiting.pop(slot)))


def told_of(parts: list[Part]) -> tuple[datetime | None, str | None]:
    """The time and the station of a message: those of the first of its parts that tells one."""
    times = (p.framed.time for p in parts)
    stations = (p.framed.station for p in parts)
    return next(filter(None, times), None), next(filter(None, stations), None)


def _slot(part: Part) -> _Slot:
    s, group = part.sentence, part.framed.group
    if group is not None:
        return "g", group.id, group.total, s.frag_cnt
    return s.talker_id, s.type, s.frag_cnt, s.channel, s.seq_id


def _belongs(part: Part, waiting: list[Part]) -> bool:
    """Whether a part can be of the message whose parts wait."""
    number, there = part.sentence.frag_num, [p.sentence.frag_num for p in waiting]
    in_order = there == list(range(1, number))
    return number not in there and (in_order or part.line - waiting[-1].line <= NEAR_LINES)
