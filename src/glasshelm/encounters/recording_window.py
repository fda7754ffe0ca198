"""Of a recording of any size the part that a scenario needs: one stretch of time, around own ship.

A file is read as a stream. A small one is kept whole; of a larger one only own ship's reports
are, and it is read again for those near her. Nothing grows with the span of time or the size.
"""

import dataclasses
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from glasshelm.ais.cleaning import STALE_S, clean
from glasshelm.ais.limits import is_position
from glasshelm.ais.reading import recordings
from glasshelm.ais.table import OWN_SENSORS, Recording, Reports
from glasshelm.core.errors import InputError
from glasshelm.encounters.globe import places
from glasshelm.encounters.own_ship_candidates import candidates

RECORDED = "recorded"
#: A file of no more reports is read once.
KEPT = 1_000_000
#: More reports are not kept.
MOST = 3_000_000
#: A time of day without any report for so many hours parts a recording in two.
SILENT_H = 6
#: Ships farther from own ship [m] are not her traffic.
AREA_M = 100_000.0

_CANDIDATES_S = 3600.0  # of a large file own ships are proposed by an hour
_HOUR_S = 3600.0
_SHOWN = 3


@dataclasses.dataclass(frozen=True)
class Stretch:
    """A time in which somebody is heard all along: whole hours [s since 1970]."""

    begin_s: float
    end_s: float
    reports: int
    ships: int

    def __str__(self) -> str:
        begin, end = (f"{datetime.fromtimestamp(t, UTC):%Y-%m-%d %H:%M}" for t in self.bounds)
        return f"of {begin}" if self.end_s - self.begin_s <= _HOUR_S else f"from {begin} to {end}"

    @property
    def bounds(self) -> tuple[float, float]:
        """When it begins and ends."""
        return self.begin_s, self.end_s

    def holds(self, time_s: np.ndarray) -> np.ndarray:
        """Which times lie in it."""
        return (time_s >= self.begin_s) & (time_s < self.end_s)


@dataclasses.dataclass(frozen=True)
class Part:
    """A recording, cleaned; whose reports in it are own ship's, and when t = 0 is (since 1970)."""

    recording: Recording
    own: int
    start_s: float


def read_recording(path: str | Path) -> Recording:
    """The whole of a recording, cleaned. InputError if it is too large, or holds no report."""
    notes: list[str] = []
    found = _kept(path, lambda reports: np.ones(len(reports), bool), notes, "cut it into hours")
    return _cleaned(path, found, notes)


def read_part(
    path: str | Path,
    own: int | str | None,
    at: str | datetime | None,
    lasts_s: float | None,
    before_s: float,
) -> Part:
    """The traffic around an own ship, from ``before_s`` before t = 0 on.

    Of several stretches of time with hours of silence between them it is the one that holds
    ``at``, or that in which most ships are heard; the notes name the others.

    Args:
        path: The recording.
        own: An MMSI, ``"recorded"`` or None: the ship whose sensors the file holds.
        at: When t = 0 is; None: her first report.
        lasts_s: How much is needed from then on [s]; None: to her last report.
        before_s: How much is needed before [s].

    Raises:
        InputError: there is no such ship (it names others), she is not heard then, or there are
            too many reports.
    """
    number = _number_of(own)
    notes: list[str] = []
    seen, whole = _Seen(), True
    parts: list[Recording] = []
    kept = 0

    def wanted(reports: Reports) -> np.ndarray:
        seen.add(reports)
        return np.ones(len(reports), bool) if whole else reports.mmsi == number

    for part in recordings(path, wanted, notes):
        parts.append(part)
        kept += len(part.reports)
        if whole and kept > KEPT:
            whole = False
            parts = [_only(part, number) for part in parts]
            kept = sum(len(part.reports) for part in parts)
        if kept > MOST:
            raise _too_many(path, "of own ship", "cut the file into parts")
    found = Recording.joined(parts)
    mine = found.reports.take(found.reports.mmsi == number)
    stretches = seen.stretches()
    here = _chosen([s for s in stretches if s.holds(mine.time_s).any()] or stretches, at)
    notes += _left_out([s for s in stretches if s != here])
    mine = mine.take(here.holds(mine.time_s))
    if not len(mine):
        raise _no_own(path, found if whole else None, own, at, here)
    mine, _ = clean(mine)
    if not whole:
        if not len(mine):
            raise InputError(f"{path}: no usable report of own ship in it")
        start = start_time(path, mine, at)
        end = float(mine.time_s[-1]) if lasts_s is None else start + lasts_s
        near = _Near(mine, start - before_s - STALE_S, end + STALE_S)
        found = _kept(path, near, [], "choose --at and --minutes", *near.bounds)
    within = here.holds(found.reports.time_s)
    recording = _cleaned(
        path, dataclasses.replace(found, reports=found.reports.take(within)), notes
    )
    mine = recording.reports.take(recording.reports.mmsi == number)
    if not len(mine):
        raise _no_own(path, recording, own, at, here)
    return Part(recording, number, start_time(path, mine, at))


def start_time(path: str | Path, mine: Reports, at: str | datetime | None) -> float:
    """The time of t = 0 in seconds since 1970. InputError if own ship is not heard then."""
    first, last = float(mine.time_s[0]), float(mine.time_s[-1])
    if at is None:
        return first
    time = _instant(at, first)
    if not first <= time < last:
        begin, end = (datetime.fromtimestamp(t, UTC).isoformat()[:19] for t in (first, last))
        raise InputError(f"{path}: own ship is heard from {begin} to {end}, not at {at}")
    return time


def near_her(mine: Reports, others: Reports) -> np.ndarray:
    """Which of the others' reports are within :data:`AREA_M` of where own ship was then."""
    track = places(mine.latitude_deg, mine.longitude_deg)
    there = places(others.latitude_deg, others.longitude_deg)
    for axis in range(3):
        there[:, axis] -= np.interp(others.time_s, mine.time_s, track[:, axis])
    return np.linalg.norm(there, axis=-1) <= AREA_M


class _Near:
    """Which reports are own ship's, or near her, in a time; impossible ones stay to be counted."""

    def __init__(self, mine: Reports, begin_s: float, end_s: float):
        self._mine, self.bounds = mine, (begin_s, end_s)

    def __call__(self, reports: Reports) -> np.ndarray:
        begin, end = self.bounds
        kept = (reports.time_s >= begin) & (reports.time_s <= end)
        rows = np.flatnonzero(kept)
        here = reports.take(rows)
        placed = is_position(here.latitude_deg, here.longitude_deg)
        own = here.mmsi == self._mine.mmsi[0]
        kept[rows] = own | ~placed | near_her(self._mine, here)
        return kept


class _Seen:
    """Who is heard in which hour."""

    def __init__(self) -> None:
        self._counts: dict[int, int] = {}
        self._pairs: list[np.ndarray] = []
        self._size = 0

    def add(self, reports: Reports) -> None:
        hours = (reports.time_s // _HOUR_S).astype(np.int64)
        for hour, count in zip(*np.unique(hours, return_counts=True), strict=True):
            self._counts[int(hour)] = self._counts.get(int(hour), 0) + int(count)
        self._pairs.append(np.unique((hours << 31) + reports.mmsi + 1))
        self._size += len(self._pairs[-1])
        if self._size > 2 * KEPT:
            self._pairs = [np.unique(np.concatenate(self._pairs))]
            self._size = len(self._pairs[0]) // 2  # so that it is not done again at once

    def stretches(self) -> list[Stretch]:
        """The stretches of time, in order."""
        hours = np.array(sorted(self._counts), np.int64)
        pairs = np.unique(np.concatenate(self._pairs))
        found = []
        for part in np.split(hours, np.flatnonzero(np.diff(hours) > SILENT_H) + 1):
            first, last = int(part[0]), int(part[-1])
            low, high = np.searchsorted(pairs, [first << 31, (last + 1) << 31]).tolist()
            ships = len(np.unique(pairs[low:high] & ((1 << 31) - 1)))
            count = sum(self._counts[hour] for hour in part.tolist())
            found.append(Stretch(first * _HOUR_S, (last + 1) * _HOUR_S, count, ships))
        return found


def _number_of(own: int | str | None) -> int:
    """The number of the reports of the own ship that was asked for."""
    text = RECORDED if own is None else str(own).strip().lower()
    if text == RECORDED:
        return OWN_SENSORS
    if not (text.isascii() and text.isdigit() and len(text) < 10 and int(text) > 0):
        raise InputError(f"own ship {own!r}: must be an MMSI or {RECORDED!r}")
    return int(text)


def _chosen(stretches: Sequence[Stretch], at: str | datetime | None) -> Stretch:
    """The stretch that holds a time, or that of most ships; a time of day is of any."""
    if at is not None and not (isinstance(at, str) and "-" not in at):
        time = np.array([_instant(at, 0.0)])
        holding = [s for s in stretches if s.holds(time).all()]
        if holding:
            return holding[0]
    return max(stretches, key=lambda s: (s.ships, s.reports))


def _left_out(others: Sequence[Stretch]) -> list[str]:
    """What is said of the stretches that are not used."""
    why = f"left out: {SILENT_H} hours or more of silence part them from the rest"
    if len(others) > _SHOWN:
        count = sum(s.reports for s in others)
        return [f"{count} reports in {len(others)} stretches, the first {others[0]}, {why}"]
    return [f"{s.reports} {'report' if s.reports == 1 else 'reports'} {s} {why}" for s in others]


def _instant(at: str | datetime, first_s: float) -> float:
    """Seconds since 1970 of a time, or of a time of the day of ``first_s``."""
    if isinstance(at, str):
        day = datetime.fromtimestamp(first_s, UTC).date().isoformat()
        try:
            at = datetime.fromisoformat(at if "-" in at else f"{day}T{at}")
        except ValueError:
            raise InputError(f"time {at!r}: must be ISO 8601, or a time of day") from None
    return (at if at.tzinfo else at.replace(tzinfo=UTC)).timestamp()


def _only(part: Recording, number: int) -> Recording:
    """A part of a file with the reports of one ship alone."""
    ships = {mmsi: said for mmsi, said in part.ships.items() if mmsi == number}
    return Recording(part.reports.take(part.reports.mmsi == number), ships)


def _kept(
    path: str | Path,
    wanted: Callable[[Reports], np.ndarray],
    notes: list[str],
    instead: str,
    *bounds: float,
) -> Recording:
    """The reports of a file that are wanted; InputError if they are too many."""
    parts, count = [], 0
    for part in recordings(path, wanted, notes, *bounds):
        parts.append(part)
        count += len(part.reports)
        if count > MOST:
            raise _too_many(path, "in that time and area", instead)
    return Recording.joined(parts)


def _too_many(path: str | Path, which: str, instead: str) -> InputError:
    return InputError(f"{path}: more than {MOST:,} reports {which}: {instead}")


def _cleaned(path: str | Path, found: Recording, notes: Sequence[str]) -> Recording:
    reports, said = clean(found.reports)
    if len(reports) == 0:
        raise InputError(f"{path}: no usable report ({'; '.join(said)})")
    return Recording(reports, found.ships, (*notes, *said))


def _no_own(
    path: str | Path,
    found: Recording | None,
    own: int | str | None,
    at: str | datetime | None,
    here: Stretch,
) -> InputError:
    """What to choose instead of an own ship that is not there; of a large file, of an hour."""
    if found is None:
        begin = here.begin_s if at is None else _instant(at, here.begin_s)
        hour = (begin, begin + _CANDIDATES_S)
        found = _kept(path, _Thinned(*hour), [], "choose another --at", *hour)
    within = here.holds(found.reports.time_s)
    reports, _ = clean(found.reports.take(within))
    if own is None:
        problem = "no own ship in it"
    elif str(own).strip().lower() == RECORDED:
        problem = "no recorded own ship in it"
    else:
        problem = f"no usable report of MMSI {own} in it"
    best = candidates(reports, found.ships) if len(reports) else ()
    listed = "; ".join(map(str, best)) or "none is under way"
    return InputError(f"{path}: {problem}; choose --own MMSI, for instance {listed}")


class _Thinned:
    """Of each ship about a report a minute, in a time."""

    def __init__(self, begin_s: float, end_s: float):
        self._bounds = begin_s, end_s

    def __call__(self, reports: Reports) -> np.ndarray:
        begin, end = self._bounds
        rows = np.flatnonzero((reports.time_s >= begin) & (reports.time_s < end))
        minutes = (reports.time_s[rows] // 60).astype(np.int64)
        _, first = np.unique((minutes << 31) + reports.mmsi[rows] + 1, return_index=True)
        kept = np.zeros(len(reports), bool)
        kept[rows[first]] = True
        return kept
