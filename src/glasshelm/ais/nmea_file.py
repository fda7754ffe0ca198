"""AIS reports of a file of NMEA 0183 (decoder: :mod:`glasshelm.ais.nmea_decoder`).

A report's time is that of its line: of the tag block, of what a receiver or a logger wrote
beside the sentence, or of the latest RMC. Own ship's sensors are kept under ``OWN_SENSORS``, its
AIVDO under its own MMSI.
"""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from glasshelm.ais.files import TextFile
from glasshelm.ais.mmsi import is_number
from glasshelm.ais.nmea_decoder import NmeaDecoder
from glasshelm.ais.reports import Counts, RejectReason, Report
from glasshelm.ais.table import OWN_SENSORS, Recording, ReportTable, StaticData, Wanted
from glasshelm.core.errors import InputError
from glasshelm.ship.nomoto import KNOT_M_S

#: Reports of one batch.
BATCH = 65_536
#: What a sound recording holds beside what is of use; it is not reported.
_USUAL = frozenset((RejectReason.UNUSED_KIND, RejectReason.NO_SHIP, RejectReason.EMPTY))


def iter_nmea(path: str | Path, wanted: Wanted, notes: list[str]) -> Iterator[Recording]:
    """The parts of an NMEA file; see :func:`glasshelm.ais.reading.iter_recording`.

    The last part has the static data of all ships.

    Raises:
        InputError: No line is a sentence, or none gives a position and its time.
    """
    counts, ships, found = Counts(), dict[int, StaticData](), False
    decoder = NmeaDecoder(counts, live=False, trust_times=True)
    rows: list[tuple[float, ...]] = []
    with TextFile(path) as file:
        for report in decoder.decode(file.lines()):
            number = int(report.id) if is_number(report.id) else OWN_SENSORS
            ships[number] = ships.get(number, StaticData()).updated_by(StaticData.of(report))
            if report.latitude_deg is not None and report.longitude_deg is not None:
                found = True
                rows.append(_row(number, report))
            if len(rows) == BATCH:
                yield Recording(_table(rows), {}).select(wanted)
                rows = []
        notes.extend(file.notes)
    decoder.close()
    if not found:
        raise InputError(f"{path}: {_why_nothing(counts)}")
    notes.extend(
        f"{n} {counts.unit[:-1] if n == 1 else counts.unit} {reason}"
        for reason, n in counts.reasons.items()
        if reason not in _USUAL
    )
    yield Recording(_table(rows), ships).select(wanted)


def _row(number: int, r: Report) -> tuple[float, ...]:
    """A report in the order of :class:`ReportTable`; what it does not give is NaN."""
    speed = math.nan if r.speed_m_s is None else r.speed_m_s / KNOT_M_S
    course, heading = (
        math.nan if angle is None else math.degrees(angle)
        for angle in (r.course_rad, r.heading_rad)
    )
    position = r.latitude_deg or 0.0, r.longitude_deg or 0.0
    return r.time.timestamp(), float(number), *position, speed, course, heading


def _table(rows: list[tuple[float, ...]]) -> ReportTable:
    columns = np.array(rows, dtype=np.float64).reshape(-1, 7).T
    return ReportTable(columns[0], columns[1].astype(np.int64), *columns[2:])


def _why_nothing(counts: Counts) -> str:
    """Why a file gives no position, by the reason that holds for most of its lines."""
    reasons = counts.reasons
    if reasons.get(RejectReason.MALFORMED, 0) == counts.received:
        return "no NMEA 0183 sentence (such as !AIVDM,…*hh) in any of its lines"
    main = max(reasons, key=lambda reason: reasons[reason], default=None)
    if main is None:
        return f"none of its {counts.received} sentences tells a position"
    return f"no position can be used: of {counts.received} sentences, {reasons[main]} are {main}"
