"""One line of a stream: its sentence, and what the receiver wrote around it.

A sentence may stand behind a tag block (NMEA 4.10), behind a time that a logger wrote, and before
a time and a station that a receiver appended. Its checksum is the two digits after ``*``.
"""

import functools
import math
import operator
import re
from datetime import UTC, datetime
from typing import NamedTuple

from pyais.messages import TagBlock

from glasshelm.ais.limits import epoch_seconds
from glasshelm.ais.reports import RejectReason
from glasshelm.ais.stream_clock import from_epoch

#: The longest line [bytes]: a tag block of 80 characters and a sentence of 82, and room to spare.
LONGEST_LINE = 1024

_BOM = b"\xef\xbb\xbf"
_SENTENCE = re.compile(rb"[!$][A-Z]{4,5},", re.IGNORECASE)
_CHECKSUM = re.compile(rb"\*([0-9A-Fa-f]{2})(?![0-9A-Fa-f])")
_NUMBER = re.compile(r"\d{1,20}(?:\.\d{1,9})?")
#: A time since 1970 that is written beside a sentence; a number of nine digits is an MMSI there.
_WRITTEN = re.compile(r"\d{10,20}(?:\.\d{1,9})?|\d.*[-:T].*")
_STATION = re.compile(r"[rb]\w{1,20}")
#: What separates the fields that loggers and receivers add.
_BETWEEN = re.compile(r"[,;|\t\"\[\]]+|\s(?=\D|\d{9,})")


class Group(NamedTuple):
    """The tag block's ``g``: this line is ``number`` of ``total`` that belong together."""

    number: int
    total: int
    id: str


class Framed(NamedTuple):
    """A sentence with a right checksum; when and by which station it was heard, if known.

    A station is named ``station:NAME``: it is a witness of the time, as ships are by their numbers.
    """

    sentence: bytes
    time: datetime | None = None
    station: str | None = None
    group: Group | None = None


def framed(line: bytes) -> Framed | RejectReason:
    """What a line holds, or why it is of no use."""
    if len(line) > LONGEST_LINE:
        return RejectReason.TOO_LONG
    line = line.removeprefix(_BOM).strip()
    start = _SENTENCE.search(line)
    tag = line.find(b"\\")
    if start is None:
        return RejectReason.UNREADABLE
    around = Framed(b"")
    begins = start.start()
    if 0 <= tag < begins:
        begins = tag
        read = _tag_blocks(line[tag:])
        if isinstance(read, RejectReason):
            return read
        around, line = read, line[:tag] + read.sentence
    sentence = line[begins:]
    mark = _CHECKSUM.search(sentence)
    if mark is None:
        return RejectReason.CHECKSUM if b"*" in sentence else RejectReason.UNREADABLE
    body, more = sentence[1 : mark.start()], sentence[mark.end() :]
    if checksum_of(body) != int(mark[1], 16):
        return RejectReason.CHECKSUM
    if not body.isascii():
        return RejectReason.UNREADABLE
    time, station, group = around.time, around.station, around.group
    for beside in (line[:begins], more):
        if beside:
            written_time, written_station = _written(beside)
            time, station = time or written_time, station or written_station
    return Framed(sentence[: mark.end()], time, station, group)


def checksum_of(body: bytes) -> int:
    """The exclusive or of the characters between ``$`` or ``!`` and ``*``."""
    return functools.reduce(operator.xor, body, 0)


def _tag_blocks(line: bytes) -> Framed | RejectReason:
    """What the tag blocks at the beginning of a line tell; the sentence is what follows them."""
    around = Framed(b"")
    while line.startswith(b"\\"):
        tag, closed, line = line[1:].partition(b"\\")
        if not closed:
            return RejectReason.UNREADABLE
        block = _tag_block(tag)
        if isinstance(block, RejectReason):
            return block
        around = Framed(
            b"",
            block.time or around.time,
            block.station or around.station,
            block.group or around.group,
        )
    return around._replace(sentence=line)


@functools.lru_cache(4096)  # in a second many lines have the same
def _tag_block(tag: bytes) -> Framed | RejectReason:
    """What one tag block tells."""
    block = TagBlock(tag)
    block.init()
    if not block.is_valid:
        return RejectReason.CHECKSUM
    time, told = None, block.receiver_timestamp
    if told is not None:
        time = _time_of(told)
        if time is None:
            return RejectReason.IMPOSSIBLE_TIME
    station = f"station:{block.source_station}" if block.source_station else None
    g = block.group
    group = None if g is None else Group(g.sentence_num, g.sentence_tot, str(g.group_id))
    return Framed(b"", time, station, group)


def _written(text: bytes) -> tuple[datetime | None, str | None]:
    """The time and the station in what was written before or after a sentence."""
    time, station = None, None
    for part in _BETWEEN.split(text.decode("latin-1")):
        word = part.strip()
        time = time or (_time_of(word) if _WRITTEN.fullmatch(word) else None)
        station = station or (f"station:{word}" if _STATION.fullmatch(word) else None)
    return time, station


def _time_of(text: str) -> datetime | None:
    """The time that a text tells: a count since 1970, or ISO 8601 (UTC)."""
    if _NUMBER.fullmatch(text):
        seconds = epoch_seconds(float(text))
        return None if math.isnan(seconds) else from_epoch(seconds)
    if len(text) < len("2024-06-01T12:00"):
        return None
    try:
        time = datetime.fromisoformat(text)
    except ValueError:
        return None
    time = time.replace(tzinfo=UTC) if time.tzinfo is None else time.astimezone(UTC)
    return None if math.isnan(epoch_seconds(time.timestamp())) else time
