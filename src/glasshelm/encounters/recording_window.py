"""The excerpt of a recording that a scenario needs: one segment of time, around own ship.

A file of any size is read as a stream. A small one is kept whole; of a larger one only own ship's
reports are, and it is read again for those near it. Memory does not grow with the file.
"""

import dataclasses
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from glasshelm.ais.cleaning import MAX_BASELINE_S, clean
from glasshelm.ais.limits import is_mmsi, is_position
from glasshelm.ais.mmsi import is_number
from glasshelm.ais.reading import all_reports, iter_recording
from glasshelm.ais.table import OWN_SENSORS, Recording, ReportTable, Wanted
from glasshelm.ais.timestamps import as_utc
from glasshelm.core.errors import InputError
from glasshelm.encounters.own_ship_candidates import own_ship_candidates
from glasshelm.encounters.snapshots import ecef

RECORDED = "recorded"
#: A file of no more reports is read once.
MAX_SINGLE_PASS = 1_000_000
#: More reports are not kept.
MAX_REPORTS = 3_000_000
#: So many hours without any report separate two segments of a recording.
SILENT_H = 6
#: Ships farther from own ship [m] are not its traffic.
AREA_M = 100_000.0

_HOUR_S = 3600.0
_MAX_NOTES = 3


@dataclasses.dataclass(frozen=True)
class Segment:
    """A time with reports all along: whole hours [s since 1970]."""

    begin_s: float
    end_s: float
    n_reports: int
    n_ships: int

    def __str__(self) -> str:
        begin, end = (
            f"{datetime.fromtimestamp(t, UTC):%Y-%m-%d %H:%M}" for t in (self.begin_s, self.end_s)
        )
        return f"of {begin}" if self.end_s - self.begin_s <= _HOUR_S else f"from {begin} to {end}"

    def contains(self, reports: ReportTable) -> np.ndarray:
        """Which reports are of this time."""
        return _between(reports, self.begin_s, self.end_s)


@dataclasses.dataclass(frozen=True)
class RecordingExcerpt:
    """A cleaned recording; whose reports in it are own ship's, and when t = 0 is (since 1970)."""

    recording: Recording
    own: int
    start_s: float


def read_recording(path: str | Path) -> Recording:
    """The whole of a recording, cleaned. InputError if it is too large, or holds no report."""
    notes: list[str] = []
    return _cleaned(path, _read(path, all_reports, notes, "cut it into hours"), notes)


def read_excerpt(
    path: str | Path,
    own: int | str | None,
    at: str | datetime | None,
    duration_s: float | None,
    before_s: float,
) -> RecordingExcerpt:
    """The traffic around an own ship, from ``before_s`` before t = 0 on.

    Of several segments with hours of silence between them it is the one that holds
    ``at``, or that with most ships; the notes name the others.

    Args:
        path: The recording.
        own: An MMSI, ``"recorded"`` or None: the ship whose sensors the file holds.
        at: When t = 0 is; None: own ship's first report.
        duration_s: How much is needed from then on [s]; None: to own ship's last report.
        before_s: How much is needed before [s].

    Raises:
        InputError: There is no such ship (the message names others), it is not recorded then,
            or there are too many reports.
    """
    number = _number_of(own)
    notes: list[str] = []
    hours, parts = _HourlyTraffic(), list[Recording]()
    n_kept, whole = 0, True

    def own_reports(reports: ReportTable) -> np.ndarray:
        return reports.mmsi == number

    def wanted(reports: ReportTable) -> np.ndarray:
        hours.add(reports)
        return all_reports(reports) if whole else own_reports(reports)

    for part in iter_recording(path, notes, wanted):
        parts.append(part)
        n_kept += len(part.reports)
        if whole and n_kept > MAX_SINGLE_PASS:
            whole = False
            parts = [_only(part, number) for part in parts]
            n_kept = sum(len(part.reports) for part in parts)
        if n_kept > MAX_REPORTS:
            raise _too_many(path, "of own ship", "cut the file into parts")
    recording = Recording.concat(parts)
    track = recording.reports.take(own_reports(recording.reports))
    segments = hours.segments()
    with_own = [segment for segment in segments if segment.contains(track).any()]
    segment = _choose(with_own or segments, at)
    notes += _notes_on_others([other for other in segments if other != segment])
    track = track.take(segment.contains(track))
    if not len(track):
        raise _no_own_ship(path, recording if whole else None, own, at, segment)
    if not whole:
        track, _ = clean(track)
        if not len(track):
            raise InputError(f"{path}: no usable report of own ship in it")
        start_s = start_time(path, track, at)
        end_s = float(track.time_s[-1]) if duration_s is None else start_s + duration_s
        bounds = start_s - before_s - MAX_BASELINE_S, end_s + MAX_BASELINE_S
        near = _near_track(track, *bounds)
        recording = _read(path, near, [], "choose --at and --minutes", *bounds)
    recording = _cleaned(path, recording.select(segment.contains), notes)
    track = recording.reports.take(own_reports(recording.reports))
    if not len(track):
        raise _no_own_ship(path, recording, own, at, segment)
    return RecordingExcerpt(recording, number, start_time(path, track, at))


def start_time(path: str | Path, track: ReportTable, at: str | datetime | None) -> float:
    """The time of t = 0 in seconds since 1970. InputError if own ship is not recorded then."""
    first, last = float(track.time_s[0]), float(track.time_s[-1])
    if at is None:
        return first
    time = _seconds_of(at, first)
    if not first <= time < last:
        begin, end = (datetime.fromtimestamp(t, UTC).isoformat()[:19] for t in (first, last))
        raise InputError(f"{path}: own ship is heard from {begin} to {end}, not at {at}")
    return time


def near_own_ship(track: ReportTable, others: ReportTable) -> np.ndarray:
    """Which of the others' reports are within :data:`AREA_M` of where own ship was then."""
    own = ecef(track.latitude_deg, track.longitude_deg)
    offset = ecef(others.latitude_deg, others.longitude_deg)
    for axis in range(3):
        offset[:, axis] -= np.interp(others.time_s, track.time_s, own[:, axis])
    return np.linalg.norm(offset, axis=-1) <= AREA_M


def _near_track(track: ReportTable, begin_s: float, end_s: float) -> Wanted:
    """Own ship's reports, and those near it in a time; impossible ones stay to be counted."""

    def wanted(reports: ReportTable) -> np.ndarray:
        kept = (reports.time_s >= begin_s) & (reports.time_s <= end_s)
        rows = np.flatnonzero(kept)
        candidates = reports.take(rows)
        possible = is_position(candidates.latitude_deg, candidates.longitude_deg)
        own = candidates.mmsi == track.mmsi[0]
        kept[rows] = own | ~possible | near_own_ship(track, candidates)
        return kept

    return wanted


def _one_a_minute(begin_s: float, end_s: float) -> Wanted:
    """About one report a minute of each ship, in a time."""

    def wanted(reports: ReportTable) -> np.ndarray:
        rows = np.flatnonzero(_between(reports, begin_s, end_s))
        minutes = (reports.time_s[rows] // 60).astype(np.int64)
        _, first = np.unique(_pair(minutes, reports.mmsi[rows]), return_index=True)
        kept = np.zeros(len(reports), bool)
        kept[rows[first]] = True
        return kept

    return wanted


def _between(reports: ReportTable, begin_s: float, end_s: float) -> np.ndarray:
    return (reports.time_s >= begin_s) & (reports.time_s < end_s)


def _pair(period: np.ndarray, mmsi: np.ndarray) -> np.ndarray:
    """One number for a period of time and a ship."""
    return (period << 31) + mmsi + 1


class _HourlyTraffic:
    """Which ships are recorded in which hour."""

    def __init__(self) -> None:
        self._counts: dict[int, int] = {}
        self._pairs: list[np.ndarray] = []
        self._size = 0

    def add(self, reports: ReportTable) -> None:
        hours = (reports.time_s // _HOUR_S).astype(np.int64)
        for hour, count in zip(*np.unique(hours, return_counts=True), strict=True):
            self._counts[int(hour)] = self._counts.get(int(hour), 0) + int(count)
        self._pairs.append(np.unique(_pair(hours, reports.mmsi)))
        self._size += len(self._pairs[-1])
        if self._size > 2 * MAX_SINGLE_PASS:
            self._pairs = [np.unique(np.concatenate(self._pairs))]
            self._size = len(self._pairs[0]) // 2  # so that it is not done again at once

    def segments(self) -> list[Segment]:
        """The segments of the recording, in order."""
        hours = np.array(sorted(self._counts), np.int64)
        pairs = np.unique(np.concatenate(self._pairs))
        segments = []
        for part in np.split(hours, np.flatnonzero(np.diff(hours) > SILENT_H) + 1):
            first, last = int(part[0]), int(part[-1])
            low, high = np.searchsorted(pairs, [first << 31, (last + 1) << 31]).tolist()
            n_ships = len(np.unique(pairs[low:high] & ((1 << 31) - 1)))
            n_reports = sum(self._counts[hour] for hour in part.tolist())
            segments.append(Segment(first * _HOUR_S, (last + 1) * _HOUR_S, n_reports, n_ships))
        return segments


def _number_of(own: int | str | None) -> int:
    """The number of the reports of the own ship that was chosen."""
    text = RECORDED if own is None else str(own).strip().lower()
    if text == RECORDED:
        return OWN_SENSORS
    if not (is_number(text) and len(text) < 10 and is_mmsi(int(text))):
        raise InputError(f"own ship {own!r}: must be an MMSI or {RECORDED!r}")
    return int(text)


def _choose(segments: Sequence[Segment], at: str | datetime | None) -> Segment:
    """The segment that holds a time, or that of most ships; a time of day is of any."""
    if at is not None and not (isinstance(at, str) and "-" not in at):
        time_s = _seconds_of(at, 0.0)
        for segment in segments:
            if segment.begin_s <= time_s < segment.end_s:
                return segment
    return max(segments, key=lambda segment: (segment.n_ships, segment.n_reports))


def _notes_on_others(others: Sequence[Segment]) -> list[str]:
    """Notes on the segments that are not used."""
    why = f"left out: {SILENT_H} hours or more of silence part them from the rest"
    if len(others) > _MAX_NOTES:
        count = sum(segment.n_reports for segment in others)
        return [f"{count} reports in {len(others)} stretches, the first {others[0]}, {why}"]
    return [
        f"{s.n_reports} {'report' if s.n_reports == 1 else 'reports'} {s} {why}" for s in others
    ]


def _seconds_of(at: str | datetime, first_s: float) -> float:
    """Seconds since 1970 of a time, or of a time of the day of ``first_s``."""
    if isinstance(at, str):
        day = datetime.fromtimestamp(first_s, UTC).date().isoformat()
        try:
            at = datetime.fromisoformat(at if "-" in at else f"{day}T{at}")
        except ValueError:
            raise InputError(f"time {at!r}: must be ISO 8601, or a time of day") from None
    return as_utc(at).timestamp()


def _only(part: Recording, number: int) -> Recording:
    """A part of a file with the reports of one ship alone."""
    ships = {mmsi: static for mmsi, static in part.ships.items() if mmsi == number}
    return Recording(part.reports.take(part.reports.mmsi == number), ships)


def _read(
    path: str | Path, wanted: Wanted, notes: list[str], instead: str, *bounds: float
) -> Recording:
    """The reports of a file that are wanted; InputError if they are too many."""
    parts, count = [], 0
    for part in iter_recording(path, notes, wanted, *bounds):
        parts.append(part)
        count += len(part.reports)
        if count > MAX_REPORTS:
            raise _too_many(path, "in that time and area", instead)
    return Recording.concat(parts)


def _too_many(path: str | Path, which: str, instead: str) -> InputError:
    return InputError(f"{path}: more than {MAX_REPORTS:,} reports {which}: {instead}")


def _cleaned(path: str | Path, recording: Recording, notes: Sequence[str]) -> Recording:
    reports, cleaning_notes = clean(recording.reports)
    if len(reports) == 0:
        raise InputError(f"{path}: no usable report ({'; '.join(cleaning_notes)})")
    return Recording(reports, recording.ships, (*notes, *cleaning_notes))


def _no_own_ship(
    path: str | Path,
    recording: Recording | None,
    own: int | str | None,
    at: str | datetime | None,
    segment: Segment,
) -> InputError:
    """What to choose instead of an own ship that is not there; of a large file, of an hour."""
    if recording is None:
        begin = segment.begin_s if at is None else _seconds_of(at, segment.begin_s)
        hour = (begin, begin + _HOUR_S)
        recording = _read(path, _one_a_minute(*hour), [], "choose another --at", *hour)
    reports, _ = clean(recording.select(segment.contains).reports)
    if own is None:
        problem = "no own ship in it"
    elif str(own).strip().lower() == RECORDED:
        problem = "no recorded own ship in it"
    else:
        problem = f"no usable report of MMSI {own} in it"
    best = own_ship_candidates(reports, recording.ships) if len(reports) else ()
    listed = "; ".join(map(str, best)) or "none is under way"
    return InputError(f"{path}: {problem}; choose --own MMSI, for instance {listed}")
