"""From lines of NMEA 0183 to reports: tag blocks, multipart AIS messages, own ship's sensors.

This is the one decoder, for live feeds and recorded files alike. AIS is decoded by pyais. Every
line is counted, and none can do harm: its length is limited, and so are the fragments that wait.
"""

from collections.abc import Iterable, Iterator
from datetime import datetime

from pyais.messages import AISSentence, NMEASentenceFactory

from glasshelm.ais.ais_fields import decode_fields, mmsi_of
from glasshelm.ais.multipart import (
    MAX_PENDING,
    NEAR_LINES,
    Fragment,
    FragmentAssembler,
    time_and_station,
)
from glasshelm.ais.nmea_sensors import parse_sensor_sentence
from glasshelm.ais.nmea_sentence import NmeaLine, parse_line
from glasshelm.ais.reports import Counts, RejectReason, Report
from glasshelm.ais.traffic_time import StreamClock

#: The id of own ship where no MMSI is known.
OWN = "own"
#: In a file a line with a time of its own dates the following lines, so many, before RMC does.
TIME_HOLDS_LINES = 1000


class NmeaDecoder:
    """Decodes one stream of lines.

    Args:
        counts: Counts every line.
        live: Lines without a time are dated by their arrival.
        own_mmsi: The MMSI whose AIS reports are own ship's; those of AIVDO are in any case.
        trust_times: Every line has the time it says, even one that most others contradict: of a
            recording that is read, not played.
    """

    def __init__(
        self, counts: Counts, live: bool, own_mmsi: str | None = None, trust_times: bool = False
    ):
        self._counts, self._own_mmsi, self._trust_times = counts, own_mmsi, trust_times
        self._clock = StreamClock(live, counts)
        #: The time of own ship's satellite receiver, for files whose lines have none.
        self._receiver_clock = StreamClock(live=False)
        self._last_timed_line = -TIME_HOLDS_LINES
        self._fragments = FragmentAssembler(counts)
        self._groups: dict[str, tuple[NmeaLine, int]] = {}
        self._lines = 0

    def decode(self, lines: Iterable[bytes]) -> Iterator[Report]:
        """The reports of some lines."""
        for line in lines:
            report = self.decode_line(line)
            if report is not None:
                yield report

    def decode_line(self, raw: bytes) -> Report | None:
        """The report that a line makes or completes; an empty line is not even counted."""
        raw = raw.strip()
        if not raw:
            return None
        self._lines += 1
        self._counts.received += 1
        result = self._decode(raw)
        if isinstance(result, RejectReason):
            self._counts.reject(result)
        return result if isinstance(result, Report) else None

    def close(self) -> None:
        """Give up the messages that will not be completed."""
        self._fragments.close()

    def _decode(self, raw: bytes) -> Report | RejectReason | None:
        """A report, why there is none, or None while a message is incomplete."""
        line = parse_line(raw)
        if isinstance(line, RejectReason):
            return line
        line = self._with_group(line)
        if line.sentence[3:6].upper() in (b"VDM", b"VDO"):
            return self._decode_ais(line)
        return self._decode_sensors(line)

    def _with_group(self, line: NmeaLine) -> NmeaLine:
        """A line with the time and station that the first line of its tag group has for all."""
        if line.group is None:
            return line
        first, number = self._groups.get(line.group.id, (line, self._lines))
        if line.group.number == 1 or self._lines - number > NEAR_LINES:
            self._groups.pop(line.group.id, None)
            self._groups[line.group.id] = line, self._lines
            if len(self._groups) > MAX_PENDING:
                del self._groups[next(iter(self._groups))]
            return line
        return line.with_context(first)

    def _decode_ais(self, line: NmeaLine) -> Report | RejectReason | None:
        try:
            sentence = NMEASentenceFactory.produce(line.sentence)
        except Exception:  # of a mangled sentence pyais raises many kinds
            return RejectReason.MALFORMED
        if not isinstance(sentence, AISSentence):
            return RejectReason.MALFORMED
        count, time, station = 1, line.time, line.station
        if sentence.frag_cnt > 1:
            fragments = self._fragments.add(Fragment(sentence, line, self._lines))
            if fragments is None:
                return None
            count, (time, station) = len(fragments), time_and_station(fragments)
            sentence = AISSentence.assemble_from_iterable([f.sentence for f in fragments])
        result = self._ais_report(sentence, time, station)
        # All fragments of a message share the fate of the last one, which the caller counts.
        if isinstance(result, RejectReason):
            self._counts.reject(result, count - 1)
        else:
            self._counts.accepted += count
        return result

    def _ais_report(
        self, sentence: AISSentence, line_time: datetime | None, station: str | None
    ) -> Report | RejectReason:
        fields = decode_fields(sentence)
        time = self._time(line_time, station or str(mmsi_of(sentence)))
        if isinstance(time, RejectReason):
            return time
        if isinstance(fields, RejectReason):
            return fields
        if time is None:
            return RejectReason.NO_TIME
        is_own = sentence.type.upper() == "VDO" or fields["id"] == self._own_mmsi
        return Report(time=time, is_own=is_own, **fields)

    def _decode_sensors(self, line: NmeaLine) -> Report | RejectReason:
        name, *texts = line.sentence[1:-3].decode("ascii").split(",")
        try:
            fields = parse_sensor_sentence(name[2:].upper(), texts)
        except (ValueError, IndexError, KeyError, OverflowError):
            return RejectReason.UNDECODABLE
        if fields is None:
            return RejectReason.UNUSED_KIND
        number = self._own_mmsi or OWN
        receiver_time = fields.pop("time", None)
        time = self._time(line.time, line.station or number)
        if isinstance(time, RejectReason):
            return time
        if line.time is None and receiver_time is not None and not self._has_time:
            # A receiver whose calendar is wrong still knows where the ship is now.
            time = self._receiver_clock.update(receiver_time, number) or self._receiver_clock.now()
        if not fields:
            return RejectReason.EMPTY
        if time is None:
            return RejectReason.NO_TIME
        self._counts.accepted += 1
        return Report(id=number, time=time, is_own=True, **fields)

    @property
    def _has_time(self) -> bool:
        """Whether the stream has a time without own ship's satellite receiver."""
        return self._clock.live or self._lines - self._last_timed_line < TIME_HOLDS_LINES

    def _time(self, line_time: datetime | None, source: str) -> datetime | RejectReason | None:
        """The time of a line: its own, or else the stream's."""
        if line_time is None:
            return self._clock.now() if self._has_time else self._receiver_clock.now()
        self._last_timed_line = self._lines
        believed = self._clock.update(line_time, source)
        return believed or (line_time if self._trust_times else RejectReason.TIME_JUMP)
