"""AIS reports from NMEA 0183 (AIVDM) lines with the times of their tag blocks.

A line is ``\\c:TIME,...*HH\\!AIVDM,...``: ``c`` is seconds (or milliseconds) since
1970. The second part of a message of two takes the time of the first. Own
ship's AIVDO lines are read like the others, under her own MMSI.
"""

import re
from pathlib import Path

import numpy as np
import pyais
from pyais.exceptions import AISBaseException

from glasshelm.ais.csv_file import read_text
from glasshelm.ais.table import Particulars, Recording, Reports, counted
from glasshelm.errors import InputError

_LINE = re.compile(r"^(?:\\(?P<tag>[^\\]*)\\)?(?P<sentence>[!$][A-Z]{2}VD[MO],.*)$")
_TIME = re.compile(r"(?:^|,)c:(\d+)")
# First character of the payload: message types 1-3, 18, 19 (positions), 5, 24 (particulars).
_WANTED = frozenset("123BC5H")
_POSITION = {1, 2, 3, 18, 19}


def read_nmea(path: Path) -> Recording:
    """The recording of an NMEA file, plain or gzipped.

    Sentences that cannot be decoded, or have no time, are counted in the
    notes. InputError if there is no AIS sentence, or none with a time.
    """
    waiting: dict[tuple[str, str], tuple[float | None, dict[int, str]]] = {}
    rows: list[tuple[float, ...]] = []
    ships: dict[int, Particulars] = {}
    told: set[str] = set()
    sentences = undecodable = untimed = 0
    for line in read_text(path).splitlines():
        match = _LINE.match(line.strip())
        if match is None:
            continue
        sentences += 1
        sentence = match["sentence"]
        time_s = _time_of(match["tag"])
        fields = sentence.split(",")
        if len(fields) < 7 or not (fields[1].isdigit() and fields[2].isdigit()):
            undecodable += 1
            continue
        parts = [sentence]
        if fields[1] != "1":
            key = (fields[3], fields[4])
            first = fields[2] == "1"
            begun, collected = (time_s, {}) if first else waiting.get(key, (time_s, {}))
            collected[int(fields[2])] = sentence
            waiting[key] = (begun, collected)
            if len(collected) < int(fields[1]):
                continue
            del waiting[key]
            parts = [collected[i] for i in sorted(collected)]
            fields, time_s = parts[0].split(","), begun
        payload = "".join(part.split(",")[5] for part in parts)
        if payload[:1] not in _WANTED or payload in told:
            continue
        try:
            message = pyais.decode(*parts)
        except (AISBaseException, ValueError):
            undecodable += 1
            continue
        if message.msg_type in _POSITION:
            if time_s is None:
                untimed += 1
                continue
            rows.append(_row(time_s, message))
        else:
            told.add(payload)  # repeated every six minutes, mostly unchanged
        if message.msg_type not in (1, 2, 3, 18):
            _note_particulars(ships, message)
    if sentences == 0:
        raise InputError(f"{path}: no AIS sentence (!AIVDM or !AIVDO) in it")
    if not rows:
        why = "none has a tag-block time (c:)" if untimed else "none can be decoded"
        raise InputError(f"{path}: no position report can be used: {why}")
    table = np.array(rows, dtype=np.float64).T
    reports = Reports(table[0], table[1].astype(np.int64), *table[2:])
    notes = counted(undecodable, "undecodable") + counted(untimed, "without a tag-block time")
    return Recording(reports, ships, notes)


def _time_of(tag: str | None) -> float | None:
    found = None if tag is None else _TIME.search(tag.split("*")[0])
    if found is None:
        return None
    time = float(found[1])
    return time / 1000.0 if time > 1e11 else time


def _row(time_s: float, message) -> tuple[float, ...]:
    """A report in the order of :class:`Reports`; "not available" is left to the cleaning."""
    fields = (message.mmsi, message.lat, message.lon, message.speed, message.course)
    return (time_s, *map(float, fields), float(message.heading))


def _note_particulars(ships: dict[int, Particulars], message) -> None:
    """Add what a static report (types 5, 19, 24) says; later reports overrule."""
    mmsi = int(message.mmsi)
    known = ships.get(mmsi, Particulars())
    name = (getattr(message, "shipname", None) or "").strip() or None
    length = getattr(message, "to_bow", 0) + getattr(message, "to_stern", 0)
    beam = getattr(message, "to_port", 0) + getattr(message, "to_starboard", 0)
    kind = getattr(message, "ship_type", None)
    ships[mmsi] = Particulars(
        name or known.name,
        float(length) or known.length_m,
        float(beam) or known.beam_m,
        str(int(kind)) if kind else known.kind,
    )
