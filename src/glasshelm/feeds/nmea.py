"""From lines of NMEA 0183 to reports: tag blocks, messages in parts, own ship's sensors.

AIS is read through pyais. Everything that a line can be is counted, and no line
can do harm: its length is limited, and so are the parts that wait for others.
"""

from collections.abc import Iterator
from datetime import datetime

from pyais.messages import AISSentence, NMEASentenceFactory, TagBlock

from glasshelm.feeds.ais_said import NO_SHIP, WANTED, ais_said
from glasshelm.feeds.clock import StreamClock, from_epoch
from glasshelm.feeds.own_sentences import checksum_of, own_said
from glasshelm.feeds.types import Counts, Refusal, Report

#: The longest line [bytes]: a tag block of 80 characters and a sentence of 82, and room to spare.
LONGEST_LINE = 1024
#: Messages that may be incomplete at a time; the oldest is given up for a new one.
MOST_WAITING = 32
#: The name of own ship where no MMSI is known.
OWN = "own"

_Slot = tuple[str, str, int, str, int | None]


class _Parts:
    """A message in parts: those that came, and the time of the first."""

    def __init__(self, time: datetime | None):
        self.time = time
        self.sentences: list[AISSentence] = []


class NmeaReader:
    """Reads one stream of lines.

    ``own`` is the MMSI whose AIS reports are own ship's (she is also whoever an
    AIVDO speaks of). ``live``: lines that tell no time are dated by arrival.
    """

    def __init__(self, counts: Counts, live: bool, own: str | None = None):
        self._counts, self._own = counts, own
        self._clock = StreamClock(live)
        self._tagged = False
        self._parts: dict[_Slot, _Parts] = {}

    def read(self, lines: Iterator[bytes]) -> Iterator[Report]:
        """The reports of some lines."""
        for line in lines:
            report = self.line(line)
            if report is not None:
                yield report

    def line(self, raw: bytes) -> Report | None:
        """The report that a line makes or completes; an empty line is nothing, not even heard."""
        raw = raw.strip()
        if not raw:
            return None
        self._counts.heard += 1
        found = self._line(raw)
        if isinstance(found, Refusal):
            self._counts.refuse(found)
        return found if isinstance(found, Report) else None

    def end(self) -> None:
        """Give up the messages that will not be completed."""
        for slot in list(self._parts):
            self._give_up(slot)

    def _line(self, raw: bytes) -> Report | Refusal | None:
        """A report, a refusal of this line, or None while it waits for other parts."""
        if len(raw) > LONGEST_LINE:
            return Refusal.TOO_LONG
        time = None
        if raw.startswith(b"\\"):
            tag, closed, raw = raw[1:].partition(b"\\")
            if not closed:
                return Refusal.UNREADABLE
            time = self._time_of(tag)
            if isinstance(time, Refusal):
                return time
        if time is None:
            time = self._clock.now()
        if raw[:1] not in (b"!", b"$") or len(raw) < 6 or not raw.isascii():
            return Refusal.UNREADABLE
        if raw[3:6] in (b"VDM", b"VDO"):
            return self._ais(raw, time)
        return self._sensors(raw, time)

    def _time_of(self, tag: bytes) -> datetime | Refusal | None:
        """The time of a tag block: seconds or milliseconds since 1970."""
        block = TagBlock(tag)
        block.init()
        if not block.is_valid:
            return Refusal.CHECKSUM
        told = block.receiver_timestamp
        if told is None:
            return None
        if not (told.isascii() and told.isdigit()):
            return Refusal.UNDECODABLE
        seconds = float(told)
        time = from_epoch(seconds / 1000 if seconds > 1e11 else seconds)
        if time is None:
            return Refusal.UNDECODABLE
        self._tagged = True
        return self._clock.tell(time)

    def _ais(self, raw: bytes, time: datetime | None) -> Report | Refusal | None:
        try:
            sentence = NMEASentenceFactory.produce(raw)
        except Exception:  # of a mangled sentence pyais raises many kinds
            return Refusal.UNREADABLE
        if not isinstance(sentence, AISSentence):
            return Refusal.UNREADABLE
        if not sentence.is_valid:
            return Refusal.CHECKSUM
        if sentence.frag_cnt == 1:
            return self._decoded(sentence, 1, time)
        return self._part(sentence, time)

    def _part(self, sentence: AISSentence, time: datetime | None) -> Report | Refusal | None:
        """One part of a message. Parts come in order, as the standard has them."""
        s = sentence
        slot = (s.talker_id, s.type, s.frag_cnt, s.channel, s.seq_id)
        if s.frag_num == 1:
            self._give_up(slot)
            if len(self._parts) >= MOST_WAITING:
                self._give_up(next(iter(self._parts)))
            self._parts[slot] = _Parts(time)
        parts = self._parts.get(slot)
        if parts is None or s.frag_num != len(parts.sentences) + 1:
            return Refusal.PART_MISSING
        parts.sentences.append(s)
        if len(parts.sentences) < s.frag_cnt:
            return None
        del self._parts[slot]
        try:
            whole = AISSentence.assemble_from_iterable(parts.sentences)
        except Exception:  # as above
            self._counts.refuse(Refusal.UNDECODABLE, s.frag_cnt - 1)
            return Refusal.UNDECODABLE
        return self._decoded(whole, s.frag_cnt, parts.time)

    def _give_up(self, slot: _Slot) -> None:
        parts = self._parts.pop(slot, None)
        if parts is not None:
            self._counts.refuse(Refusal.PART_MISSING, len(parts.sentences))

    def _decoded(
        self, sentence: AISSentence, parts: int, time: datetime | None
    ) -> Report | Refusal:
        """The report of a whole message; all of its parts are counted as its last one is."""
        found = self._report_of(sentence, time)
        if isinstance(found, Refusal):
            self._counts.refuse(found, parts - 1)
        else:
            self._counts.understood += parts
        return found

    def _report_of(self, sentence: AISSentence, time: datetime | None) -> Report | Refusal:
        if sentence.ais_id in NO_SHIP:
            return Refusal.NO_SHIP
        if sentence.ais_id not in WANTED:
            return Refusal.UNUSED
        try:
            said = ais_said(sentence.decode())
        except Exception:  # as above
            return Refusal.UNDECODABLE
        if isinstance(said, Refusal):
            return said
        if time is None:
            return Refusal.NO_TIME
        own = sentence.type == "VDO" or said["id"] == self._own
        return Report(time=time, own=own, **said)

    def _sensors(self, raw: bytes, time: datetime | None) -> Report | Refusal:
        """A sentence of own ship's sensors; without a checksum it is not believed."""
        body, star, check = raw[1:].partition(b"*")
        if not star:
            return Refusal.UNREADABLE
        try:
            right = int(check[:2], 16) == checksum_of(body)
        except ValueError:
            right = False
        if not right:
            return Refusal.CHECKSUM
        name, *fields = body.decode("ascii").split(",")
        try:
            said = own_said(name[2:], fields)
        except (ValueError, IndexError, KeyError, OverflowError):
            return Refusal.UNDECODABLE
        if said is None:
            return Refusal.UNUSED
        told = said.pop("time", None)
        if told is not None and not self._tagged and not self._clock.live:
            time = self._clock.tell(told)
        if not said:
            return Refusal.NOTHING_TOLD
        if time is None:
            return Refusal.NO_TIME
        self._counts.understood += 1
        return Report(id=self._own or OWN, time=time, own=True, **said)
