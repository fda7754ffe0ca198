"""From lines of NMEA 0183 to reports: tag blocks, messages in parts, own ship's sensors.

This is the one decoder: live feeds and recorded files are read by it alike. AIS is read through
pyais. Everything that a line can be is counted, and no line can do harm: its length is limited,
and so are the parts that wait for others.
"""

from collections.abc import Iterable, Iterator
from datetime import datetime

from pyais.messages import AISSentence, NMEASentenceFactory

from glasshelm.ais.ais_fields import ais_said, mmsi_of
from glasshelm.ais.multipart import MAX_PENDING, NEAR_LINES, Fragment, FragmentAssembler, told_of
from glasshelm.ais.nmea_sensors import parse_sensor_sentence
from glasshelm.ais.nmea_sentence import NmeaLine, parse_line
from glasshelm.ais.reports import Counts, RejectReason, Report
from glasshelm.ais.stream_clock import StreamClock

#: The name of own ship where no MMSI is known.
OWN = "own"
#: In a file, lines that tell their time date the others for so many lines, whatever RMC tells.
HOLDS_LINES = 1000


class NmeaDecoder:
    """Reads one stream of lines.

    ``own`` is the MMSI whose AIS reports are own ship's (she is also whoever an
    AIVDO speaks of). ``live``: lines that tell no time are dated by arrival.
    ``as_told``: of a recording that is read, not played, every line has the time it tells.
    """

    def __init__(
        self, counts: Counts, live: bool, own_mmsi: str | None = None, trust_times: bool = False
    ):
        self._counts, self._own, self._as_told = counts, own_mmsi, trust_times
        self._clock = StreamClock(live, counts)
        #: Of a file: what own ship's satellite receiver tells, where no line has a time of its own.
        self._satellites = StreamClock(live=False)
        self._timed_at = -HOLDS_LINES
        self._parts = FragmentAssembler(counts)
        self._groups: dict[str, tuple[NmeaLine, int]] = {}
        self._lines = 0

    def decode(self, lines: Iterable[bytes]) -> Iterator[Report]:
        """The reports of some lines."""
        for line in lines:
            report = self.decode_line(line)
            if report is not None:
                yield report

    def decode_line(self, raw: bytes) -> Report | None:
        """The report that a line makes or completes; an empty line is nothing, not even heard."""
        raw = raw.strip()
        if not raw:
            return None
        self._lines += 1
        self._counts.received += 1
        found = self._line(raw)
        if isinstance(found, RejectReason):
            self._counts.reject(found)
        return found if isinstance(found, Report) else None

    def close(self) -> None:
        """Give up the messages that will not be completed."""
        self._parts.end()

    def _line(self, raw: bytes) -> Report | RejectReason | None:
        """A report, a refusal of this line, or None while it waits for other parts."""
        line = parse_line(raw)
        if isinstance(line, RejectReason):
            return line
        line = self._grouped(line)
        if line.sentence[3:6].upper() in (b"VDM", b"VDO"):
            return self._ais(line)
        return self._sensors(line)

    def _grouped(self, line: NmeaLine) -> NmeaLine:
        """A line with what the first one of its group tells for all."""
        if line.group is None:
            return line
        first, number = self._groups.get(line.group.id, (line, self._lines))
        if line.group.number == 1 or self._lines - number > NEAR_LINES:
            self._groups.pop(line.group.id, None)
            self._groups[line.group.id] = line, self._lines
            if len(self._groups) > MAX_PENDING:
                del self._groups[next(iter(self._groups))]
            return line
        return line._replace(time=line.time or first.time, station=line.station or first.station)

    def _ais(self, line: NmeaLine) -> Report | RejectReason | None:
        try:
            sentence = NMEASentenceFactory.produce(line.sentence)
        except Exception:  # of a mangled sentence pyais raises many kinds
            return RejectReason.MALFORMED
        if not isinstance(sentence, AISSentence):
            return RejectReason.MALFORMED
        if sentence.frag_cnt == 1:
            return self._decoded(sentence, 1, line.time, line.station)
        parts = self._parts.add(Fragment(sentence, line, self._lines))
        if parts is None:
            return None
        whole = AISSentence.assemble_from_iterable([part.sentence for part in parts])
        return self._decoded(whole, len(parts), *told_of(parts))

    def _decoded(
        self, sentence: AISSentence, parts: int, told: datetime | None, station: str | None
    ) -> Report | RejectReason:
        """The report of a whole message; all of its parts are counted as its last one is."""
        found = self._report_of(sentence, told, station)
        if isinstance(found, RejectReason):
            self._counts.reject(found, parts - 1)
        else:
            self._counts.accepted += parts
        return found

    def _report_of(
        self, sentence: AISSentence, told: datetime | None, station: str | None
    ) -> Report | RejectReason:
        said = ais_said(sentence)
        time = self._time(told, station or str(mmsi_of(sentence)))
        if isinstance(time, RejectReason):
            return time
        if isinstance(said, RejectReason):
            return said
        if time is None:
            return RejectReason.NO_TIME
        own = sentence.type.upper() == "VDO" or said["id"] == self._own
        return Report(time=time, is_own=own, **said)

    def _sensors(self, line: NmeaLine) -> Report | RejectReason:
        """A sentence of own ship's sensors."""
        name, *fields = line.sentence[1:-3].decode("ascii").split(",")
        try:
            said = parse_sensor_sentence(name[2:].upper(), fields)
        except (ValueError, IndexError, KeyError, OverflowError):
            return RejectReason.UNDECODABLE
        if said is None:
            return RejectReason.UNUSED_KIND
        number = self._own or OWN
        satellites = said.pop("time", None)
        time = self._time(line.time, line.station or number)
        if isinstance(time, RejectReason):
            return time
        if line.time is None and satellites is not None and not self._timed:
            # A receiver whose calendar is wrong still knows where she is now.
            time = self._satellites.update(satellites, number) or self._satellites.now()
        if not said:
            return RejectReason.EMPTY
        if time is None:
            return RejectReason.NO_TIME
        self._counts.accepted += 1
        return Report(id=number, time=time, is_own=True, **said)

    @property
    def _timed(self) -> bool:
        """Whether the stream has a time without own ship's satellites."""
        return self._clock.live or self._lines - self._timed_at < HOLDS_LINES

    def _time(self, told: datetime | None, witness: str) -> datetime | RejectReason | None:
        """The time of a line: the one it tells, or else the stream's.

        Of what is played it must be believed. In a recording each line has its own: it may be
        of several receivers, one after the other, or of reports that came late.
        """
        if told is None:
            return self._clock.now() if self._timed else self._satellites.now()
        self._timed_at = self._lines
        believed = self._clock.update(told, witness)
        return believed or (told if self._as_told else RejectReason.TIME_JUMP)
