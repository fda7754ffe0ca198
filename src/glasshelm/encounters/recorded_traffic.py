"""Recorded AIS traffic as a scenario: any ship of it, or the recording ship, as own ship."""

import dataclasses
import math
from datetime import UTC, datetime
from pathlib import Path

import jax.numpy as jnp
import numpy as np

from glasshelm.ais.limits import ECHO_M, LOST_AFTER_S, UNDER_WAY_KN
from glasshelm.ais.mmsi import station_label
from glasshelm.ais.table import OWN_SENSORS, ReportTable, StaticData
from glasshelm.core.errors import InputError
from glasshelm.core.geometry import Vector
from glasshelm.encounters.projection import LocalProjection
from glasshelm.encounters.random_encounters import WIDE
from glasshelm.encounters.recording_window import (
    RECORDED,
    RecordingExcerpt,
    near_own_ship,
    read_excerpt,
)
from glasshelm.encounters.tracks import TrackColumns, single_track, stack_tracks
from glasshelm.encounters.types import Encounter, Scenario, TargetInfo, with_dimensions
from glasshelm.ship.nomoto import KNOT_M_S, NAUTICAL_MILE_M, ShipParams, ShipState

#: A ship that never gets farther than this from its start goes nowhere.
MIN_WAY_M = 500.0
#: A scenario has no more legs, counted as ships times reports of the ship that reports most.
MAX_LEGS = 20_000_000


@dataclasses.dataclass(frozen=True)
class RecordingSettings:
    """How a recording becomes a scenario. SI units."""

    lost_after_s: float = LOST_AFTER_S
    #: Own ship's waypoint is at least this far off; 0: its last position itself.
    min_waypoint_m: float = WIDE.waypoint_m[0]
    #: Own ship's length; None: the recording's, or else the preset's.
    loa_m: float | None = None
    #: How long from t = 0 on; None: as long as own ship is recorded.
    duration_s: float | None = None


def recorded_scenario(
    path: str | Path,
    ship: ShipParams,
    own: int | str | None = None,
    at: str | datetime | None = None,
    settings: RecordingSettings = RecordingSettings(),
) -> Scenario:
    """A recording as seen from one of its ships.

    Own ship's speed is its mean recorded speed under way (a pilot cannot stop it, so its stops
    do not count), its length the recording's where known. Its waypoint lies in
    the direction of its last position (or of the farthest one, if it
    came back), at least ``min_waypoint_m`` off. Every report of a target is
    a leg: it is dead-reckoned from it until the next, and lost after
    ``lost_after_s``. Own ship's echo in the AIS is left out.

    Args:
        path: The recording.
        ship: Own ship's K, T and rudder.
        own: An MMSI, or ``"recorded"`` for the ship whose sensors the file
            holds (the default where there is one).
        at: The time (UTC) of t = 0; None: own ship's first report.
        settings: How the recording becomes a scenario.

    Raises:
        InputError: There is no such ship, it goes nowhere, or it is not recorded at ``at``.
    """
    excerpt = read_excerpt(path, own, at, settings.duration_s, settings.lost_after_s)
    return scenario_from_excerpt(path, excerpt, ship, settings)


def scenario_from_excerpt(
    path: str | Path,
    excerpt: RecordingExcerpt,
    ship: ShipParams,
    settings: RecordingSettings = RecordingSettings(),
) -> Scenario:
    """The scenario of an excerpt of a recording; as :func:`recorded_scenario`."""
    number, t0, notes = excerpt.own, excerpt.start_s, list(excerpt.recording.notes)
    reports, ships = excerpt.recording.reports, excerpt.recording.ships
    own = reports.take(reports.mmsi == number)
    if settings.duration_s is not None:
        own = own.take(own.time_s <= t0 + settings.duration_s)
    reports = reports.take((reports.mmsi == OWN_SENSORS) | near_own_ship(own, reports))
    plane, now = _plane_at(own, t0, settings)
    own_legs = _legs(own, plane, t0, settings.lost_after_s)
    echo, known = _echo(reports), ships.get(number, StaticData())
    hidden = [number]
    if echo is not None and number == OWN_SENSORS:
        hidden, known = [number, echo], ships.get(echo, StaticData())
        notes.append(f"MMSI {echo} is own ship's echo: left out of the traffic")
    elif echo is not None:
        # Received over AIS as well as by its own sensors, the recorder would be there twice.
        hidden = [number, OWN_SENSORS]
    duration = float(own.time_s[-1] - t0)
    ship = _with_recorded_motion(ship, known, own_legs, duration, settings, notes)
    waypoint = _waypoint(path, number, own_legs, settings, notes)
    others = reports.take(~np.isin(reports.mmsi, hidden))
    current = (others.time_s > t0 - settings.lost_after_s) & (others.time_s <= t0 + duration)
    others = others.take(current)
    tracks = [_legs(r, plane, t0, settings.lost_after_s) for r in _by_ship(others)]
    longest = max((len(track.start_s) for track in tracks), default=0)
    if len(tracks) * longest > MAX_LEGS:
        raise InputError(
            f"{path}: {len(tracks)} ships with up to {longest} reports each: too much to sail "
            "through: choose --at and --minutes"
        )
    heading = own.heading_deg[now] if np.isfinite(own.heading_deg[now]) else own.cog_deg[now]
    name = known.name or _label(number)
    return Scenario(
        source=str(path),
        title=f"{name} in recorded traffic: {len(tracks)} ships",
        encounter=Encounter(
            ShipState.steady(0.0, 0.0, math.radians(heading), ship.speed_m_s),
            Vector(jnp.full(1, waypoint[0], jnp.float32), jnp.full(1, waypoint[1], jnp.float32)),
            stack_tracks(tracks),
            jnp.ones(len(tracks), bool),
        ),
        targets=tuple(
            _target_info(n, ships.get(n, StaticData())) for n in np.unique(others.mmsi).tolist()
        ),
        ship=ship,
        duration_s=duration,
        own_name=name,
        own_track=single_track(own_legs),
        origin=plane.origin,
        start=datetime.fromtimestamp(t0, UTC),
        notes=tuple(notes),
    )


def _label(number: int) -> str:
    return "own ship" if number == OWN_SENSORS else f"MMSI {number}"


def _by_ship(reports: ReportTable) -> list[ReportTable]:
    """The reports of each ship, of a table sorted by ship."""
    parts = np.split(np.arange(len(reports)), np.flatnonzero(np.diff(reports.mmsi)) + 1)
    return [reports.take(rows) for rows in parts if len(rows)]


def _plane_at(
    own: ReportTable, t0: float, settings: RecordingSettings
) -> tuple[LocalProjection, int]:
    """The plane centred on own ship at t = 0, and the index of its latest report then."""
    now = int(np.searchsorted(own.time_s, t0, side="right")) - 1
    age = min(t0 - own.time_s[now], settings.lost_after_s)
    run = own.sog_kn[now] * KNOT_M_S * age
    course = math.radians(own.cog_deg[now])
    there = LocalProjection(own.latitude_deg[now], own.longitude_deg[now])
    latitude, longitude = there.to_globe(
        np.array([run * math.sin(course)]), np.array([run * math.cos(course)])
    )
    return LocalProjection(latitude[0], longitude[0]), now


def _legs(r: ReportTable, plane: LocalProjection, t0: float, lost_after_s: float) -> TrackColumns:
    """One ship's reports as legs."""
    east, north = plane.to_plane(r.latitude_deg, r.longitude_deg)
    course = plane.course(r.latitude_deg, r.longitude_deg, np.radians(r.cog_deg))
    return TrackColumns.of(r.time_s - t0, east, north, course, r.sog_kn * KNOT_M_S, lost_after_s)


def _echo(reports: ReportTable) -> int | None:
    """The MMSI under which the recorder receives itself, if it does."""
    is_own = reports.mmsi == OWN_SENSORS
    if not is_own.any():
        return None
    own, others = reports.take(is_own), reports.take(~is_own)
    plane = LocalProjection(own.latitude_deg[0], own.longitude_deg[0])
    east, north = plane.to_plane(own.latitude_deg, own.longitude_deg)
    other_east, other_north = plane.to_plane(others.latitude_deg, others.longitude_deg)
    distance = np.hypot(
        other_east - np.interp(others.time_s, own.time_s, east),
        other_north - np.interp(others.time_s, own.time_s, north),
    )
    within = (others.time_s >= own.time_s[0]) & (others.time_s <= own.time_s[-1])
    if not within.any():
        return None
    numbers, first = np.unique(others.mmsi, return_index=True)
    farthest = np.maximum.reduceat(np.where(within, distance, 0.0), first)
    count = np.add.reduceat(within.astype(int), first)
    echoes = numbers[(count >= 3) & (farthest < ECHO_M)]
    return int(echoes[0]) if len(echoes) else None


def _with_recorded_motion(
    ship: ShipParams,
    known: StaticData,
    own_legs: TrackColumns,
    duration_s: float,
    settings: RecordingSettings,
    notes: list[str],
) -> ShipParams:
    """The ship with the recorded one's mean speed under way and, where known, length and beam.

    Under way is ``UNDER_WAY_KN`` or, for a slow ship, half of its highest speed.
    """
    loa = settings.loa_m or known.length_m
    if loa is None:
        notes.append(f"own ship's length is not recorded: {float(ship.loa_m):.0f} m assumed")
    legs_s = np.diff(np.clip(own_legs.start_s, 0.0, None), append=duration_s)
    fastest = own_legs.speed_m_s[legs_s > 0].max(initial=0.0)
    under_way = own_legs.speed_m_s >= min(UNDER_WAY_KN * KNOT_M_S, 0.5 * fastest)
    under_way_s = np.where(under_way, legs_s, 0.0)
    speed = float(np.sum(own_legs.speed_m_s * under_way_s) / max(np.sum(under_way_s), 1e-9))
    stopped_min = (duration_s - np.sum(under_way_s)) / 60
    if stopped_min >= 1:
        notes.append(
            f"own ship stops or drifts for {stopped_min:.0f} of {duration_s / 60:.0f} min: "
            f"her speed is the mean of the rest, {speed / KNOT_M_S:.1f} kn"
        )
    return with_dimensions(ship, loa, known.beam_m, speed)


def _waypoint(
    path: str | Path,
    number: int,
    own_legs: TrackColumns,
    settings: RecordingSettings,
    notes: list[str],
) -> tuple[float, float]:
    """Own ship's waypoint; InputError if it goes nowhere."""
    ahead = own_legs.start_s >= 0
    east, north = own_legs.east_m[ahead], own_legs.north_m[ahead]
    distance = np.hypot(east, north)
    farthest = int(np.argmax(distance))
    if distance[farthest] < MIN_WAY_M:
        raise InputError(
            f"{path}: {_label(number)} stays within {distance[farthest]:.0f} m of her start: "
            f"choose an own ship that makes way for {MIN_WAY_M:.0f} m or an earlier time"
        )
    end = len(distance) - 1
    if distance[end] < 0.5 * distance[farthest]:
        notes.append("own ship comes back: her waypoint is the farthest point of her track")
        end = farthest
    stretch = max(settings.min_waypoint_m / distance[end], 1.0)
    if stretch > 1.0:
        notes.append(
            f"own ship's track ends {distance[end] / NAUTICAL_MILE_M:.1f} NM off: her waypoint "
            f"lies {settings.min_waypoint_m / NAUTICAL_MILE_M:.1f} NM off in that direction"
        )
    return float(east[end] * stretch), float(north[end] * stretch)


def _target_info(number: int, known: StaticData) -> TargetInfo:
    size, ship_type = known.length_m, known.ship_type
    if number == OWN_SENSORS:
        return TargetInfo(RECORDED, "recording ship", size, ship_type)
    return TargetInfo(str(number), known.name or station_label(number), size, ship_type)
