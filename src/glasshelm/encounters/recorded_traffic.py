"""Recorded AIS traffic as a scenario: any ship of it, or the recorder herself, as own ship."""

import dataclasses
import math
from datetime import UTC, datetime
from pathlib import Path

import jax.numpy as jnp
import numpy as np

from glasshelm.ais.mmsi import station_label
from glasshelm.ais.table import OWN_SENSORS, ReportTable, StaticData
from glasshelm.core.errors import InputError
from glasshelm.core.geometry import Vector
from glasshelm.encounters.globe import LOST_AFTER_S
from glasshelm.encounters.own_ship_candidates import UNDER_WAY_KN
from glasshelm.encounters.projection import LocalProjection
from glasshelm.encounters.random_encounters import WIDE
from glasshelm.encounters.recording_window import (
    RECORDED,
    RecordingExcerpt,
    near_own_ship,
    read_excerpt,
)
from glasshelm.encounters.tracks import TrackColumns, single_track, stack_tracks
from glasshelm.encounters.types import Encounter, Scenario, TargetInfo
from glasshelm.ship.nomoto import KNOT_M_S, NAUTICAL_MILE_M, ShipParams, ShipState

#: A ship that never gets farther than this from her start goes nowhere.
GOES_NOWHERE_M = 500.0
#: AIS reports that stay this near to the recorder's own sensors are her own.
ECHO_M = 150.0
#: A scenario has no more legs, counted as ships times reports of the ship that reports most.
MAX_LEGS = 20_000_000


@dataclasses.dataclass(frozen=True)
class RecordingSettings:
    """How a recording becomes a scenario. SI units."""

    lost_after_s: float = LOST_AFTER_S
    #: Own ship's waypoint is pushed out to at least this distance; 0: her last position itself.
    min_waypoint_m: float = WIDE.waypoint_m[0]
    #: Own ship's length; None: the recording's, or else the preset's.
    loa_m: float | None = None
    #: How long from t = 0 on; None: as long as own ship is heard.
    duration_s: float | None = None


def recorded_scenario(
    path: str | Path,
    ship: ShipParams,
    own: int | str | None = None,
    at: str | datetime | None = None,
    settings: RecordingSettings = RecordingSettings(),
) -> Scenario:
    """A recording as seen from one of its ships.

    ``own`` is an MMSI, or ``"recorded"`` for the ship whose sensors the file
    holds (the default where there is one); ``at`` the time (UTC) of t = 0, by
    default her first report. She keeps K, T and rudder of ``ship``; her speed
    is her mean recorded speed under way (a pilot cannot stop her, so her stops
    do not count), her length the recording's where known. Her waypoint lies in
    the direction of her last known position (or of the farthest one, if she
    came back), at least ``nearest_waypoint_m`` off. Every report of a target is
    a leg: she is dead-reckoned from it until the next, and lost after
    ``lost_after_s``. Own ship's echo in the AIS is left out.
    InputError if there is no such ship, she goes nowhere, or ``at`` is not a
    time at which she is heard.
    """
    part = read_excerpt(path, own, at, settings.duration_s, settings.lost_after_s)
    return scenario_from_excerpt(path, part, ship, settings)


def scenario_from_excerpt(
    path: str | Path,
    part: RecordingExcerpt,
    ship: ShipParams,
    settings: RecordingSettings = RecordingSettings(),
) -> Scenario:
    """The scenario of a part of a recording; as :func:`recorded_scenario`."""
    number, t0, notes = part.own, part.start_s, list(part.recording.notes)
    reports, ships = part.recording.reports, part.recording.ships
    mine = reports.take(reports.mmsi == number)
    if settings.duration_s is not None:
        mine = mine.take(mine.time_s <= t0 + settings.duration_s)
    reports = reports.take((reports.mmsi == OWN_SENSORS) | near_own_ship(mine, reports))
    plane, now = _plane_at(mine, t0, settings)
    own_row = _row(mine, plane, t0, settings.lost_after_s)
    echo = _echo(reports)
    if number == OWN_SENSORS:
        hidden = [OWN_SENSORS] if echo is None else [OWN_SENSORS, echo]
        known = ships.get(echo if echo is not None else OWN_SENSORS, StaticData())
    else:
        # Heard over AIS as well as by her own sensors, the recorder would be there twice.
        hidden = [number] if echo is None else [number, OWN_SENSORS]
        known = ships.get(number, StaticData())
    if number == OWN_SENSORS and echo is not None:
        notes.append(f"MMSI {echo} is own ship's echo: left out of the traffic")
    duration = float(mine.time_s[-1] - t0)
    ship = _fitted(ship, known, own_row, duration, settings, notes)
    waypoint = _waypoint(path, number, own_row, settings, notes)
    others = reports.take(~np.isin(reports.mmsi, hidden))
    heard = (others.time_s > t0 - settings.lost_after_s) & (others.time_s <= t0 + duration)
    others = others.take(heard)
    rows = [_row(r, plane, t0, settings.lost_after_s) for r in _by_ship(others)]
    longest = max((len(row.start_s) for row in rows), default=0)
    if len(rows) * longest > MAX_LEGS:
        raise InputError(
            f"{path}: {len(rows)} ships with up to {longest} reports each: too much to sail "
            "through: choose --at and --minutes"
        )
    numbers = np.unique(others.mmsi).tolist()
    heading = mine.heading_deg[now] if np.isfinite(mine.heading_deg[now]) else mine.cog_deg[now]
    name = known.name or ("own ship" if number == OWN_SENSORS else f"MMSI {number}")
    return Scenario(
        source=str(path),
        title=f"{name} in recorded traffic: {len(rows)} ships",
        encounter=Encounter(
            ShipState.steady(0.0, 0.0, math.radians(heading), ship.speed_m_s),
            Vector(jnp.full(1, waypoint[0], jnp.float32), jnp.full(1, waypoint[1], jnp.float32)),
            stack_tracks(rows),
            jnp.ones(len(rows), bool),
        ),
        targets=tuple(_info(n, ships.get(n, StaticData())) for n in numbers),
        ship=ship,
        duration_s=duration,
        own_name=name,
        own_track=single_track(own_row),
        origin=plane.origin,
        start=datetime.fromtimestamp(t0, UTC),
        notes=tuple(notes),
    )


def _by_ship(reports: ReportTable) -> list[ReportTable]:
    """The reports of each ship, of a table sorted by ship."""
    parts = np.split(np.arange(len(reports)), np.flatnonzero(np.diff(reports.mmsi)) + 1)
    return [reports.take(rows) for rows in parts if len(rows)]


def _plane_at(
    mine: ReportTable, t0: float, settings: RecordingSettings
) -> tuple[LocalProjection, int]:
    """The plane centred on own ship at t = 0, and the index of her latest report then."""
    now = int(np.searchsorted(mine.time_s, t0, side="right")) - 1
    age = min(t0 - mine.time_s[now], settings.lost_after_s)
    run = mine.sog_kn[now] * KNOT_M_S * age
    course = math.radians(mine.cog_deg[now])
    there = LocalProjection(mine.latitude_deg[now], mine.longitude_deg[now])
    latitude, longitude = there.to_globe(
        np.array([run * math.sin(course)]), np.array([run * math.cos(course)])
    )
    return LocalProjection(latitude[0], longitude[0]), now


def _row(r: ReportTable, plane: LocalProjection, t0: float, lost_after_s: float) -> TrackColumns:
    """One ship's reports as legs."""
    east, north = plane.to_plane(r.latitude_deg, r.longitude_deg)
    course = plane.course(r.latitude_deg, r.longitude_deg, np.radians(r.cog_deg))
    return TrackColumns.of(r.time_s - t0, east, north, course, r.sog_kn * KNOT_M_S, lost_after_s)


def _echo(reports: ReportTable) -> int | None:
    """The MMSI under which the recorder hears herself, if she does."""
    own = reports.mmsi == OWN_SENSORS
    if not own.any():
        return None
    mine, others = reports.take(own), reports.take(~own)
    plane = LocalProjection(mine.latitude_deg[0], mine.longitude_deg[0])
    east, north = plane.to_plane(mine.latitude_deg, mine.longitude_deg)
    their_east, their_north = plane.to_plane(others.latitude_deg, others.longitude_deg)
    apart = np.hypot(
        their_east - np.interp(others.time_s, mine.time_s, east),
        their_north - np.interp(others.time_s, mine.time_s, north),
    )
    within = (others.time_s >= mine.time_s[0]) & (others.time_s <= mine.time_s[-1])
    if not within.any():
        return None
    numbers, first = np.unique(others.mmsi, return_index=True)
    farthest = np.maximum.reduceat(np.where(within, apart, 0.0), first)
    heard = np.add.reduceat(within.astype(int), first)
    echoes = numbers[(heard >= 3) & (farthest < ECHO_M)]
    return int(echoes[0]) if len(echoes) else None


def _fitted(
    ship: ShipParams,
    known: StaticData,
    own_row: TrackColumns,
    duration_s: float,
    settings: RecordingSettings,
    notes: list[str],
) -> ShipParams:
    """The ship with the recorded one's mean speed under way and, where known, length and beam.

    Under way is ``UNDER_WAY_KN`` or, for a slow ship, half of her highest speed.
    """
    loa = settings.loa_m or known.length_m
    if loa is None:
        notes.append(f"own ship's length is not recorded: {float(ship.loa_m):.0f} m assumed")
        loa = float(ship.loa_m)
    beam = known.beam_m or float(ship.beam_m) * loa / float(ship.loa_m)
    lasts = np.diff(np.clip(own_row.start_s, 0.0, None), append=duration_s)
    fastest = own_row.speed_m_s[lasts > 0].max(initial=0.0)
    under_way = own_row.speed_m_s >= min(UNDER_WAY_KN * KNOT_M_S, 0.5 * fastest)
    sailed = np.where(under_way, lasts, 0.0)
    speed = float(np.sum(own_row.speed_m_s * sailed) / max(np.sum(sailed), 1e-9))
    stopped_min = (duration_s - np.sum(sailed)) / 60
    if stopped_min >= 1:
        notes.append(
            f"own ship stops or drifts for {stopped_min:.0f} of {duration_s / 60:.0f} min: "
            f"her speed is the mean of the rest, {speed / KNOT_M_S:.1f} kn"
        )
    return dataclasses.replace(ship, loa_m=loa, beam_m=beam, speed_m_s=speed)


def _waypoint(
    path: str | Path,
    number: int,
    own_row: TrackColumns,
    settings: RecordingSettings,
    notes: list[str],
) -> tuple[float, float]:
    """Own ship's waypoint; InputError if she goes nowhere."""
    ahead = own_row.start_s >= 0
    east, north = own_row.east_m[ahead], own_row.north_m[ahead]
    away = np.hypot(east, north)
    farthest = int(np.argmax(away))
    if away[farthest] < GOES_NOWHERE_M:
        who = "own ship" if number == OWN_SENSORS else f"MMSI {number}"
        raise InputError(
            f"{path}: {who} stays within {away[farthest]:.0f} m of her start: "
            f"choose an own ship that makes way for {GOES_NOWHERE_M:.0f} m or an earlier time"
        )
    end = len(away) - 1
    if away[end] < 0.5 * away[farthest]:
        notes.append("own ship comes back: her waypoint is the farthest point of her track")
        end = farthest
    stretch = max(settings.min_waypoint_m / away[end], 1.0)
    if stretch > 1.0:
        notes.append(
            f"own ship's track ends {away[end] / NAUTICAL_MILE_M:.1f} NM off: her waypoint lies "
            f"{settings.min_waypoint_m / NAUTICAL_MILE_M:.1f} NM off in that direction"
        )
    return float(east[end] * stretch), float(north[end] * stretch)


def _info(number: int, known: StaticData) -> TargetInfo:
    if number == OWN_SENSORS:
        return TargetInfo(RECORDED, "recording ship", known.length_m, known.ship_type)
    return TargetInfo(
        str(number), known.name or station_label(number), known.length_m, known.ship_type
    )
