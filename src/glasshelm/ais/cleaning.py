"""Recorded AIS cleaned: faulty reports dropped or repaired, and counted in words.

In this order: impossible positions, stations that are no ships, "not available" codes,
duplicates and reports out of order, jumps; then speeds and courses that a report does not give
are derived from the positions around it.
"""

import dataclasses

import numpy as np

from glasshelm.ais.geodesy import offset_m
from glasshelm.ais.limits import (
    MAX_SPEED_KN,
    is_angle_deg,
    is_position,
    is_speed_kn,
    is_vessel_mmsi,
)
from glasshelm.ais.table import OWN_SENSORS, ReportTable, count_note
from glasshelm.ship.nomoto import KNOT_M_S

#: A ship goes no farther than its highest speed takes it, beyond the error of two positions [m].
POSITION_ERROR_M = 100.0
#: So many reports that agree outweigh the track before them.
N_AGREEING = 3
#: A report with the contents of the one before it within this time is a duplicate [s].
DUPLICATE_S = 2.0
#: Motion is derived from the latest report at least this much older [s] ...
MIN_BASELINE_S = 10.0
#: ... and no older than this.
MAX_BASELINE_S = 600.0
#: Over a shorter distance [m] positions give no course.
MIN_DISTANCE_M = 25.0


def clean(reports: ReportTable) -> tuple[ReportTable, tuple[str, ...]]:
    """The usable reports, sorted by ship and time, complete in speed and course; and notes.

    A speed above 60 kn (102.3 by the standard), a course of 360° or more (409.5), a heading of
    360° or more (511) mean "not available"; a negative course is an overflow
    of 12 bits, repaired by + 409.6.
    """
    notes: list[str] = []

    def drop(bad: np.ndarray, what: str) -> None:
        nonlocal reports
        if bad.any():
            notes.extend(count_note(int(bad.sum()), f"dropped: {what}"))
            reports = reports.take(~bad)

    drop(~is_position(reports.latitude_deg, reports.longitude_deg), "impossible position")
    ships = is_vessel_mmsi(reports.mmsi) | (reports.mmsi == OWN_SENSORS)
    drop(~ships, "from a coast station, an aid to navigation or an aircraft, not a ship")
    reports = _without_codes(reports, notes)
    late = _count_late(reports)
    reports = reports.take(np.lexsort((reports.time_s, reports.mmsi)))
    notes.extend(count_note(late, "out of order in time: sorted"))
    drop(_duplicates(reports), "duplicate")
    drop(_jumps(reports), f"jump (faster than {MAX_SPEED_KN:g} kn)")
    reports = _with_motion(reports, notes)
    drop(np.isnan(reports.sog_kn), "neither a speed nor a second position to tell it from")
    return reports, tuple(notes)


def _without_codes(r: ReportTable, notes: list[str]) -> ReportTable:
    """The codes for "not available" as NaN, overflowed courses repaired."""
    overflow = (r.cog_deg < 0) & (r.cog_deg > -409.6)
    notes.extend(count_note(int(overflow.sum()), "with a negative course: 409.6° added"))
    cog = np.where(overflow, r.cog_deg + 409.6, r.cog_deg)
    return dataclasses.replace(
        r,
        sog_kn=np.where(is_speed_kn(r.sog_kn), r.sog_kn, np.nan),
        cog_deg=np.where(is_angle_deg(cog), cog, np.nan),
        heading_deg=np.where(is_angle_deg(r.heading_deg), r.heading_deg, np.nan),
    )


def _count_late(r: ReportTable) -> int:
    """How many reports stand in the file after a later one of the same ship."""
    order = np.argsort(r.mmsi, kind="stable")
    same = np.diff(r.mmsi[order]) == 0
    return int(np.sum(same & (np.diff(r.time_s[order]) < 0)))


def _duplicates(r: ReportTable) -> np.ndarray:
    """Rows of a sorted table with the ship and time of the row before, or soon its contents."""
    ship, gap = np.diff(r.mmsi) == 0, np.diff(r.time_s)
    content = np.stack([r.latitude_deg, r.longitude_deg, np.nan_to_num(r.sog_kn, nan=-1)])
    unchanged = np.all(np.diff(content, axis=1) == 0, axis=0)
    duplicate = np.zeros(len(r), bool)
    duplicate[1:] = ship & ((gap == 0) | ((gap < DUPLICATE_S) & unchanged))
    return duplicate


def _offset_m(r: ReportTable, a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """East and north [m] from rows ``a`` to rows ``b``."""
    return offset_m(r.latitude_deg[a], r.longitude_deg[a], r.latitude_deg[b], r.longitude_deg[b])


def _reachable(r: ReportTable, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    distance = np.hypot(*_offset_m(r, a, b))
    gap = np.abs(r.time_s[b] - r.time_s[a])
    return distance <= MAX_SPEED_KN * KNOT_M_S * gap + POSITION_ERROR_M


def _jumps(r: ReportTable) -> np.ndarray:
    """Reports of a sorted table that cannot be reached from the good one before them."""
    jumps = np.zeros(len(r), bool)
    rows = np.arange(len(r))
    suspect = (np.diff(r.mmsi) == 0) & ~_reachable(r, rows[:-1], rows[1:])
    for ship in np.unique(r.mmsi[1:][suspect]):
        first, last = np.searchsorted(r.mmsi, [ship, ship + 1]).tolist()
        jumps[_jumps_of_ship(r, first, last)] = True
    return jumps


def _jumps_of_ship(r: ReportTable, first: int, last: int) -> list[int]:
    """The rows of one ship, sorted by time, that are jumps.

    A report off the track waits; when ``N_AGREEING`` of them agree, the track
    goes on from there, and what came before is kept only if it agreed as well.
    """
    jumps: list[int] = []
    track, waiting = [first], []

    def near(a: int, b: int) -> bool:
        return bool(_reachable(r, np.array([a]), np.array([b]))[0])

    for row in range(first + 1, last):
        if near(track[-1], row):
            track.append(row)
            jumps += waiting
            waiting = []
            continue
        if waiting and not near(waiting[-1], row):
            jumps += waiting
            waiting = []
        waiting.append(row)
        if len(waiting) == N_AGREEING:
            if len(track) < N_AGREEING:
                jumps += track
            track, waiting = waiting, []
    return jumps + waiting


def _with_motion(r: ReportTable, notes: list[str]) -> ReportTable:
    """Speeds and courses derived from positions where missing; NaN speeds where there are none.

    Motion is taken from an earlier report (for the first ones of a ship: from a
    later one). A course that the positions do not give is the heading, or 0 for a
    ship that lies still.
    """
    if not len(r):
        return r
    rows = np.arange(len(r))
    first = np.searchsorted(r.mmsi, r.mmsi, side="left")
    last = np.searchsorted(r.mmsi, r.mmsi, side="right") - 1
    # Sorted by ship, then time: one increasing key finds "MIN_BASELINE_S before" for all at once.
    start_s = r.time_s.min()
    span = r.time_s.max() - start_s + MAX_BASELINE_S + MIN_BASELINE_S
    ship_index = np.cumsum(np.diff(r.mmsi, prepend=r.mmsi[0]) != 0)
    key = ship_index * span + r.time_s - start_s
    older = np.searchsorted(key, key - MIN_BASELINE_S, side="right") - 1
    newer = np.minimum(np.searchsorted(key, key + MIN_BASELINE_S, side="left"), last)
    other = np.where(older >= first, older, newer)
    gap = r.time_s - r.time_s[other]
    east, north = _offset_m(r, other, rows)
    known = (gap != 0) & (np.abs(gap) <= MAX_BASELINE_S)
    distance, gap = np.hypot(east, north), np.where(known, gap, 1.0)
    no_sog, no_cog = np.isnan(r.sog_kn), np.isnan(r.cog_deg)
    sog = np.where(no_sog & known, distance / np.abs(gap) / KNOT_M_S, r.sog_kn)
    track = np.degrees(np.arctan2(east * np.sign(gap), north * np.sign(gap))) % 360.0
    course = np.where(known & (distance >= MIN_DISTANCE_M), track, np.nan_to_num(r.heading_deg))
    kept = ~np.isnan(sog)
    notes.extend(count_note(int(np.sum(no_sog & kept)), "without speed: taken from positions"))
    notes.extend(
        count_note(int(np.sum(no_cog & kept)), "without course: taken from positions or heading")
    )
    return dataclasses.replace(r, sog_kn=sog, cog_deg=np.where(no_cog, course, r.cog_deg))
