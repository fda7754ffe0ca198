"""AIS reports of a file of NMEA 0183, decoded as live traffic is (:mod:`glasshelm.ais.nmea`).

A report's time is that of its line: of the tag block, of what a receiver or a logger wrote
beside the sentence, or of the latest RMC. Own ship's sensors are kept under ``OWN_SENSORS``, her
AIVDO under her own MMSI.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

from glasshelm.ais.files import TextFile
from glasshelm.ais.mmsi import is_number
from glasshelm.ais.nmea import NmeaDecoder
from glasshelm.ais.reports import Counts, RejectReason, Report
from glasshelm.ais.table import OWN_SENSORS, Recording, ReportTable, StaticData
from glasshelm.core.errors import InputError
from glasshelm.ship.nomoto import KNOT_M_S

#: Reports of one batch.
BATCH = 65_536
#: What a sound recording holds beside what is of use: not told.
_USUAL = frozenset((RejectReason.UNUSED_KIND, RejectReason.NO_SHIP, RejectReason.EMPTY))

Ships = dict[int, StaticData]


def read_nmea(path: Path) -> Recording:
    """The recording of an NMEA file; what could not be used is counted in its notes.

    InputError if there is no sentence in it, or none that tells where a ship is and when.
    """
    notes: list[str] = []
    parts = list(nmea_recordings(path, lambda reports: np.ones(len(reports), bool), notes))
    return Recording.concat(parts, notes)


def nmea_recordings(
    path: str | Path, wanted: Callable[[ReportTable], np.ndarray], notes: list[str]
) -> Iterator[Recording]:
    """An NMEA file part by part; of each part the reports that are ``wanted``.

    The last part tells who the ships are; what could not be used is in ``notes`` at the end.
    InputError as :func:`read_nmea`.
    """
    counts, ships, found = Counts(), Ships(), False
    with TextFile(path) as file:
        for reports in nmea_batches(file.lines(), counts, ships):
            found = True
            yield Recording(reports.take(wanted(reports)), {})
        notes.extend(file.notes)
    if not found:
        raise InputError(f"{path}: {_why_nothing(counts)}")
    notes.extend(_notes(counts))
    yield Recording(ReportTable.concat([]), ships)


def nmea_batches(lines: Iterable[bytes], counts: Counts, ships: Ships) -> Iterator[ReportTable]:
    """The positions of some lines, ``BATCH`` at a time; who the ships are is added to ``ships``."""
    reader = NmeaDecoder(counts, live=False, trust_times=True)
    rows: list[tuple[float, ...]] = []
    for report in reader.decode(lines):
        number = int(report.id) if is_number(report.id) else OWN_SENSORS
        said = StaticData(report.name, report.length_m, report.beam_m, report.ship_type)
        ships[number] = ships.get(number, StaticData()).updated_by(said)
        if report.latitude_deg is not None and report.longitude_deg is not None:
            rows.append(_row(number, report))
        if len(rows) == BATCH:
            yield _table(rows)
            rows = []
    reader.close()
    if rows:
        yield _table(rows)


def _row(number: int, r: Report) -> tuple[float, ...]:
    """A report in the order of :class:`Reports`; what it does not tell is NaN."""
    speed = math.nan if r.speed_m_s is None else r.speed_m_s / KNOT_M_S
    course, heading = (
        math.nan if angle is None else math.degrees(angle)
        for angle in (r.course_rad, r.heading_rad)
    )
    position = r.latitude_deg or 0.0, r.longitude_deg or 0.0
    return r.time.timestamp(), float(number), *position, speed, course, heading


def _table(rows: list[tuple[float, ...]]) -> ReportTable:
    columns = np.array(rows, dtype=np.float64).T
    return ReportTable(columns[0], columns[1].astype(np.int64), *columns[2:])


def _notes(counts: Counts) -> tuple[str, ...]:
    """What was refused that a sound recording does not hold, by reason."""
    return tuple(
        f"{n} {counts.unit[:-1] if n == 1 else counts.unit} {why}"
        for why, n in counts.rejected.items()
        if n and why not in _USUAL
    )


def _why_nothing(counts: Counts) -> str:
    """Why a file gives no position, by the reason that holds for most of its lines."""
    said = {why: n for why, n in counts.rejected.items() if n}
    if not counts.received:
        return "there is nothing in it"
    if said.get(RejectReason.MALFORMED, 0) == counts.received:
        return "no NMEA 0183 sentence (such as !AIVDM,…*hh) in any of its lines"
    most = max(said, key=lambda why: said[why], default=None)
    if most is None:
        return f"none of its {counts.received} sentences tells a position"
    return f"no position can be used: of {counts.received} sentences, {said[most]} are {most}"
