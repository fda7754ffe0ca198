"""NMEA 0183 lines: cut from a byte stream, and what each holds beside its sentence.

A sentence may stand behind a tag block (NMEA 4.10), behind a time that a logger wrote, and before
a time and a station that a receiver appended. Its checksum is the two digits after ``*``.
"""

import functools
import operator
import re
from collections.abc import Iterator
from datetime import datetime
from typing import NamedTuple

from pyais.messages import TagBlock

from glasshelm.ais.reports import RejectReason
from glasshelm.ais.timestamps import parse_time

#: The longest line: a tag block of 80 characters and a sentence of 82, and room to spare.
MAX_SENTENCE_BYTES = 1024

_BOM = b"\xef\xbb\xbf"
SENTENCE = re.compile(rb"[!$][A-Z]{4,5},", re.IGNORECASE)
_CHECKSUM = re.compile(rb"\*([0-9A-Fa-f]{2})(?![0-9A-Fa-f])")
#: A time beside a sentence: since 1970 (a number of nine digits is an MMSI there) or ISO 8601.
_TIME = re.compile(r"\d{10,20}(?:\.\d{1,9})?|\d.*[-:T].*")
_STATION = re.compile(r"[rb]\w{1,20}")
#: What separates the fields that loggers and receivers add.
_SEPARATOR = re.compile(r"[,;|\t\"\[\]]+|\s(?=\D|\d{9,})")


class LineSplitter:
    """Cuts a byte stream into lines, with bounded memory.

    The beginning of a line that is too long comes out at once, long enough to be
    rejected as too long; the rest of it is dropped.
    """

    def __init__(self) -> None:
        self._rest = b""
        self._skip = False

    def feed(self, piece: bytes) -> Iterator[bytes]:
        """The lines that a piece completes."""
        *whole, rest = (self._rest + piece).replace(b"\r", b"\n").split(b"\n")
        self._rest = b""
        for line in whole:
            if self._skip:
                self._skip = False
            else:
                yield line
        if self._skip:
            return
        self._rest = rest
        if len(rest) > MAX_SENTENCE_BYTES:
            self._rest, self._skip = b"", True
            yield rest[: MAX_SENTENCE_BYTES + 1]

    def close(self) -> Iterator[bytes]:
        """What was left without a line end."""
        rest, self._rest, self._skip = self._rest, b"", False
        if rest:
            yield rest


class TagGroup(NamedTuple):
    """The tag block's ``g``: this line is ``number`` of ``total`` that belong together."""

    number: int
    total: int
    id: str


class NmeaLine(NamedTuple):
    """A sentence with a correct checksum; when and by which station it was received, if known.

    A station is named ``station:NAME``, as a source of the time beside ships' numbers.
    """

    sentence: bytes
    time: datetime | None = None
    station: str | None = None
    group: TagGroup | None = None

    def with_context(self, other: "NmeaLine") -> "NmeaLine":
        """The line with what another one knows, where it does not know it itself."""
        return self._replace(
            time=self.time or other.time,
            station=self.station or other.station,
            group=self.group or other.group,
        )


def parse_line(line: bytes) -> NmeaLine | RejectReason:
    """What a line holds, or why it is of no use."""
    if len(line) > MAX_SENTENCE_BYTES:
        return RejectReason.TOO_LONG
    line = line.removeprefix(_BOM).strip()
    start = SENTENCE.search(line)
    if start is None:
        return RejectReason.MALFORMED
    context, begin = NmeaLine(b""), start.start()
    tag = line.find(b"\\")
    if 0 <= tag < begin:
        begin = tag
        tagged = _parse_tag_blocks(line[tag:])
        if isinstance(tagged, RejectReason):
            return tagged
        context, line = tagged, line[:tag] + tagged.sentence
    sentence = line[begin:]
    mark = _CHECKSUM.search(sentence)
    if mark is None:
        return RejectReason.CHECKSUM if b"*" in sentence else RejectReason.MALFORMED
    body = sentence[1 : mark.start()]
    if nmea_checksum(body) != int(mark[1], 16):
        return RejectReason.CHECKSUM
    if not body.isascii():
        return RejectReason.MALFORMED
    for around in (line[:begin], sentence[mark.end() :]):
        if around:
            context = context.with_context(_parse_surroundings(around))
    return context._replace(sentence=sentence[: mark.end()])


def nmea_checksum(body: bytes) -> int:
    """The exclusive or of the characters between ``$`` or ``!`` and ``*``."""
    return functools.reduce(operator.xor, body, 0)


def _parse_tag_blocks(line: bytes) -> NmeaLine | RejectReason:
    """The contents of the tag blocks at the beginning of a line; the sentence is what follows."""
    context = NmeaLine(b"")
    while line.startswith(b"\\"):
        tag, closed, line = line[1:].partition(b"\\")
        if not closed:
            return RejectReason.MALFORMED
        block = _parse_tag_block(tag)
        if isinstance(block, RejectReason):
            return block
        context = block.with_context(context)
    return context._replace(sentence=line)


@functools.lru_cache(4096)  # within a second many lines have the same
def _parse_tag_block(tag: bytes) -> NmeaLine | RejectReason:
    block = TagBlock(tag)
    block.init()
    if not block.is_valid:
        return RejectReason.CHECKSUM
    time, stamp = None, block.receiver_timestamp
    if stamp is not None:
        time = parse_time(stamp)
        if time is None:
            return RejectReason.INVALID_TIME
    station = f"station:{block.source_station}" if block.source_station else None
    g = block.group
    group = None if g is None else TagGroup(g.sentence_num, g.sentence_tot, str(g.group_id))
    return NmeaLine(b"", time, station, group)


def _parse_surroundings(text: bytes) -> NmeaLine:
    """The time and the station in what was written before or after a sentence."""
    words = [part.strip() for part in _SEPARATOR.split(text.decode("latin-1"))]
    times = (parse_time(word) for word in words if _TIME.fullmatch(word))
    stations = (f"station:{word}" for word in words if _STATION.fullmatch(word))
    return NmeaLine(b"", next(filter(None, times), None), next(stations, None))
