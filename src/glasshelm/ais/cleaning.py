"""What is wrong with recorded AIS, dropped or repaired; each fault counted in words.

Order of the work: impossible positions, stations that are no ships, "not
available" codes, duplicates and out-of-order times, jumps, then speeds and
courses that a report does not give, from the positions around it.
"""

import dataclasses

import numpy as np

from glasshelm.ais.limits import (
    MAX_SPEED_KN,
    is_angle_deg,
    is_position,
    is_speed_kn,
    is_vessel_mmsi,
)
from glasshelm.ais.table import OWN_SENSORS, ReportTable, count_note
from glasshelm.ship.nomoto import KNOT_M_S

#: A ship goes no farther than her highest speed takes her, beyond the error of two positions [m].
POSITION_ERROR_M = 100.0
#: So many reports that agree outweigh the track before them.
N_AGREEING = 3
#: A report with the contents of the one before it within this time is a repeat [s].
REPEAT_S = 2.0
#: Motion is derived from the latest report at least this much older [s] ...
BASELINE_S = 10.0
#: ... and no older than this.
STALE_S = 600.0
#: Over a shorter way [m] positions give no course.
SHORT_WAY_M = 25.0

_EARTH_M = 6_371_000.0


def clean(reports: ReportTable) -> tuple[ReportTable, tuple[str, ...]]:
    """The usable reports, ordered by ship and time, complete in speed and course; what was done.

    A speed above 60 kn (102.3 by the book), a course of 360° or more (409.5), a heading of
    360° or more (511) mean "not available"; a negative course is an overflow
    of 12 bits, mended by + 409.6.
    """
    notes: list[str] = []

    def drop(bad: np.ndarray, what: str) -> None:
        nonlocal reports
        if bad.any():
            notes.extend(count_note(int(bad.sum()), f"dropped: {what}"))
            reports = reports.take(~bad)

    drop(_impossible(reports), "impossible position")
    ships = is_vessel_mmsi(reports.mmsi) | (reports.mmsi == OWN_SENSORS)
    drop(~ships, "from a coast station, an aid to navigation or an aircraft, not a ship")
    reports = _coded(reports, notes)
    late = _late(reports)
    order = np.lexsort((reports.time_s, reports.mmsi))
    reports = reports.take(order)
    notes.extend(count_note(late, "out of order in time: sorted"))
    drop(_repeated(reports), "duplicate")
    drop(_jumped(reports), f"jump (faster than {MAX_SPEED_KN:g} kn)")
    reports, alone = _completed(reports, notes)
    drop(alone, "neither a speed nor a second position to tell it from")
    return reports, tuple(notes)


def _impossible(r: ReportTable) -> np.ndarray:
    return ~is_position(r.latitude_deg, r.longitude_deg)


def _coded(r: ReportTable, notes: list[str]) -> ReportTable:
    """The codes for "not available" as NaN, overflown courses mended."""
    overflow = (r.cog_deg < 0) & (r.cog_deg > -409.6)
    notes.extend(count_note(int(overflow.sum()), "with a negative course: 409.6° added"))
    cog = np.where(overflow, r.cog_deg + 409.6, r.cog_deg)
    return dataclasses.replace(
        r,
        sog_kn=np.where(is_speed_kn(r.sog_kn), r.sog_kn, np.nan),
        cog_deg=np.where(is_angle_deg(cog), cog, np.nan),
        heading_deg=np.where(is_angle_deg(r.heading_deg), r.heading_deg, np.nan),
    )


def _late(r: ReportTable) -> int:
    """How many reports stand in the file after a later one of the same ship."""
    order = np.argsort(r.mmsi, kind="stable")
    same = np.diff(r.mmsi[order]) == 0
    return int(np.sum(same & (np.diff(r.time_s[order]) < 0)))


def _repeated(r: ReportTable) -> np.ndarray:
    """Rows of a sorted table with the ship and time of the row before, or its contents at once."""
    same = np.zeros(len(r), bool)
    if len(r) < 2:
        return same
    ship, gap = np.diff(r.mmsi) == 0, np.diff(r.time_s)
    content = np.stack([r.latitude_deg, r.longitude_deg, np.nan_to_num(r.sog_kn, nan=-1)])
    unchanged = np.all(np.diff(content, axis=1) == 0, axis=0)
    same[1:] = ship & ((gap == 0) | ((gap < REPEAT_S) & unchanged))
    return same


def _way_m(r: ReportTable, a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """East and north [m] from rows ``a`` to rows ``b``, near enough together to be a plane."""
    latitude = np.radians(r.latitude_deg)
    turn = np.mod(r.longitude_deg[b] - r.longitude_deg[a] + 180.0, 360.0) - 180.0
    east = np.radians(turn) * np.cos(0.5 * (latitude[a] + latitude[b])) * _EARTH_M
    return east, (latitude[b] - latitude[a]) * _EARTH_M


def _reachable(r: ReportTable, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    way = np.hypot(*_way_m(r, a, b))
    return way <= MAX_SPEED_KN * KNOT_M_S * np.abs(r.time_s[b] - r.time_s[a]) + POSITION_ERROR_M


def _jumped(r: ReportTable) -> np.ndarray:
    """Reports that cannot be reached from the good one before them, of a sorted table."""
    jumped = np.zeros(len(r), bool)
    if len(r) < 2:
        return jumped
    rows = np.arange(len(r))
    suspect = (np.diff(r.mmsi) == 0) & ~_reachable(r, rows[:-1], rows[1:])
    for ship in np.unique(r.mmsi[1:][suspect]):
        first, last = np.searchsorted(r.mmsi, [ship, ship + 1]).tolist()
        jumped[first:last] = _jumps_of_ship(r, first, last)
    return jumped


def _jumps_of_ship(r: ReportTable, first: int, last: int) -> np.ndarray:
    """One ship's reports in time: which to drop.

    A report off the track waits; when ``AGREEING`` of them agree, the track
    goes on from there, and what came before is kept only if it agreed as well.
    """
    jumped = np.zeros(last - first, bool)
    track, waiting = [first], []

    def near(a: int, b: int) -> bool:
        return bool(_reachable(r, np.array([a]), np.array([b]))[0])

    for row in range(first + 1, last):
        if near(track[-1], row):
            track.append(row)
            jumped[[w - first for w in waiting]] = True
            waiting = []
            continue
        if waiting and not near(waiting[-1], row):
            jumped[[w - first for w in waiting]] = True
            waiting = []
        waiting.append(row)
        if len(waiting) == N_AGREEING:
            if len(track) < N_AGREEING:
                jumped[[t - first for t in track]] = True
            track, waiting = waiting, []
    jumped[[w - first for w in waiting]] = True
    return jumped


def _completed(r: ReportTable, notes: list[str]) -> tuple[ReportTable, np.ndarray]:
    """Speeds and courses filled in; and the rows whose speed nothing tells.

    Motion is taken from an earlier report (the first ones of a ship: from a
    later one). A course that the positions do not give is the heading, or 0 for a
    ship that lies still.
    """
    rows = np.arange(len(r))
    first = np.searchsorted(r.mmsi, r.mmsi, side="left")
    last = np.searchsorted(r.mmsi, r.mmsi, side="right") - 1
    # Sorted by ship, then time: one increasing key finds "BASELINE_S before" for all at once.
    span = (r.time_s.max() - r.time_s.min() if len(r) else 0.0) + STALE_S + BASELINE_S
    block = np.cumsum(np.concatenate([[0], np.diff(r.mmsi) != 0])) if len(r) else rows
    key = block * span + r.time_s - (r.time_s.min() if len(r) else 0.0)
    older = np.searchsorted(key, key - BASELINE_S, side="right") - 1
    newer = np.minimum(np.searchsorted(key, key + BASELINE_S, side="left"), last)
    other = np.where(older >= first, older, newer)
    gap = r.time_s - r.time_s[other]
    east, north = _way_m(r, other, rows)
    known = (gap != 0) & (np.abs(gap) <= STALE_S)
    way, gap = np.hypot(east, north), np.where(known, gap, 1.0)
    no_sog, no_cog = np.isnan(r.sog_kn), np.isnan(r.cog_deg)
    sog = np.where(no_sog & known, way / np.abs(gap) / KNOT_M_S, r.sog_kn)
    track = np.degrees(np.arctan2(east * np.sign(gap), north * np.sign(gap))) % 360.0
    beside = np.where(np.isnan(r.heading_deg), 0.0, r.heading_deg)
    cog = np.where(no_cog, np.where(known & (way >= SHORT_WAY_M), track, beside), r.cog_deg)
    alone = np.isnan(sog)
    notes.extend(count_note(int(np.sum(no_sog & ~alone)), "without speed: taken from positions"))
    notes.extend(
        count_note(int(np.sum(no_cog & ~alone)), "without course: taken from positions or heading")
    )
    return dataclasses.replace(r, sog_kn=sog, cog_deg=cog), alone
