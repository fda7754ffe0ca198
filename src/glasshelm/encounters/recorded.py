"""Recorded AIS traffic as a scenario: any ship of it, or the recorder herself, as own ship."""

import dataclasses
import math
from datetime import UTC, datetime
from pathlib import Path

import jax.numpy as jnp
import numpy as np

from glasshelm.ais.cleaning import clean
from glasshelm.ais.csv_file import read_csv
from glasshelm.ais.mmsi import called
from glasshelm.ais.nmea_file import read_nmea
from glasshelm.ais.table import OWN_SENSORS, Particulars, Recording, Reports
from glasshelm.encounters.candidates import UNDER_WAY_KN, candidates
from glasshelm.encounters.projection import Plane
from glasshelm.encounters.random import WIDE
from glasshelm.encounters.tracks import Row, single_track, stack_rows
from glasshelm.encounters.types import Encounter, Scenario, TargetInfo
from glasshelm.errors import InputError
from glasshelm.geometry import Vector
from glasshelm.ships import KNOT_M_S, NAUTICAL_MILE_M, ShipParams, ShipState

RECORDED = "recorded"
#: A ship not heard for so long is lost: two missed reports of a class A ship at anchor (3 min).
LOST_AFTER_S = 360.0
#: A ship that never gets farther than this from her start goes nowhere.
GOES_NOWHERE_M = 500.0
#: AIS reports that stay this near to the recorder's own sensors are her own.
ECHO_M = 150.0


@dataclasses.dataclass(frozen=True)
class RecordingSettings:
    """How a recording becomes a scenario. SI units."""

    lost_after_s: float = LOST_AFTER_S
    #: Own ship's waypoint is pushed out to at least this distance; 0: her last position itself.
    nearest_waypoint_m: float = WIDE.waypoint_m[0]
    #: Own ship's length; None: the recording's, or else the preset's.
    loa_m: float | None = None


def read_recording(path: Path) -> Recording:
    """The cleaned recording of a CSV or NMEA file (by its name, or its first line)."""
    kinds = [suffix.lower() for suffix in path.suffixes if suffix.lower() != ".gz"]
    is_csv = bool(kinds) and kinds[-1] == ".csv"
    raw = read_csv(path) if is_csv else read_nmea(path)
    reports, notes = clean(raw.reports)
    if len(reports) == 0:
        raise InputError(f"{path}: no usable report ({'; '.join(notes)})")
    return Recording(reports, raw.ships, raw.notes + notes)


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
    path = Path(path)
    recording = read_recording(path)
    reports, notes = recording.reports, list(recording.notes)
    number = _own_number(path, recording, own)
    mine = reports.take(reports.mmsi == number)
    t0 = _start_time(path, mine, at)
    plane, now = _plane_at(mine, t0, settings)
    own_row = _row(mine, plane, t0, settings.lost_after_s)
    echo = _echo(reports)
    if number == OWN_SENSORS:
        hidden = [OWN_SENSORS] if echo is None else [OWN_SENSORS, echo]
        known = recording.ships.get(echo if echo is not None else OWN_SENSORS, Particulars())
    else:
        # Heard over AIS as well as by her own sensors, the recorder would be there twice.
        hidden = [number] if echo is None else [number, OWN_SENSORS]
        known = recording.ships.get(number, Particulars())
    if number == OWN_SENSORS and echo is not None:
        notes.append(f"MMSI {echo} is own ship's echo: left out of the traffic")
    duration = float(mine.time_s[-1] - t0)
    ship = _fitted(ship, known, own_row, duration, settings, notes)
    waypoint = _waypoint(path, number, own_row, settings, notes)
    others = reports.take(~np.isin(reports.mmsi, hidden))
    heard = (others.time_s > t0 - settings.lost_after_s) & (others.time_s <= t0 + duration)
    others = others.take(heard)
    numbers = np.unique(others.mmsi).tolist()
    rows = [_row(others.take(others.mmsi == n), plane, t0, settings.lost_after_s) for n in numbers]
    heading = mine.heading_deg[now] if np.isfinite(mine.heading_deg[now]) else mine.cog_deg[now]
    name = known.name or ("own ship" if number == OWN_SENSORS else f"MMSI {number}")
    return Scenario(
        source=str(path),
        title=f"{name} in recorded traffic: {len(rows)} ships",
        encounter=Encounter(
            ShipState.steady(0.0, 0.0, math.radians(heading), ship.speed_m_s),
            Vector(jnp.full(1, waypoint[0], jnp.float32), jnp.full(1, waypoint[1], jnp.float32)),
            stack_rows(rows),
            jnp.ones(len(rows), bool),
        ),
        targets=tuple(_info(n, recording.ships.get(n, Particulars())) for n in numbers),
        ship=ship,
        duration_s=duration,
        own_name=name,
        own_track=single_track(own_row),
        origin=plane.origin,
        start=datetime.fromtimestamp(t0, UTC),
        notes=tuple(notes),
    )


def _own_number(path: Path, recording: Recording, own: int | str | None) -> int:
    """The number of own ship's reports; InputError with the best candidates if it is not there."""
    numbers = set(np.unique(recording.reports.mmsi).tolist())
    if own is None and OWN_SENSORS in numbers:
        return OWN_SENSORS
    if own is not None and str(own).strip().lower() == RECORDED:
        if OWN_SENSORS in numbers:
            return OWN_SENSORS
        problem = "no recorded own ship in it"
    elif own is None:
        problem = "no own ship in it"
    elif str(own).strip().isdigit():
        if int(own) in numbers - {OWN_SENSORS}:
            return int(own)
        problem = f"no usable report of MMSI {own} in it"
    else:
        raise InputError(f"own ship {own!r}: must be an MMSI or {RECORDED!r}")
    best = candidates(recording.reports, recording.ships)
    listed = "; ".join(map(str, best)) or "none is under way"
    raise InputError(f"{path}: {problem}; choose --own MMSI, for instance {listed}")


def _start_time(path: Path, mine: Reports, at: str | datetime | None) -> float:
    """The time of t = 0 in seconds since 1970."""
    first, last = float(mine.time_s[0]), float(mine.time_s[-1])
    if at is None:
        return first
    if isinstance(at, str):
        day = datetime.fromtimestamp(first, UTC).date().isoformat()
        try:
            at = datetime.fromisoformat(at if "-" in at else f"{day}T{at}")
        except ValueError:
            raise InputError(f"time {at!r}: must be ISO 8601, or a time of day") from None
    time = (at if at.tzinfo else at.replace(tzinfo=UTC)).timestamp()
    if not first <= time < last:
        begin, end = (datetime.fromtimestamp(t, UTC).isoformat()[:19] for t in (first, last))
        raise InputError(f"{path}: own ship is heard from {begin} to {end}, not at {at}")
    return time


def _plane_at(mine: Reports, t0: float, settings: RecordingSettings) -> tuple[Plane, int]:
    """The plane centred on own ship at t = 0, and the index of her latest report then."""
    now = int(np.searchsorted(mine.time_s, t0, side="right")) - 1
    age = min(t0 - mine.time_s[now], settings.lost_after_s)
    run = mine.sog_kn[now] * KNOT_M_S * age
    course = math.radians(mine.cog_deg[now])
    there = Plane(mine.latitude_deg[now], mine.longitude_deg[now])
    latitude, longitude = there.to_globe(
        np.array([run * math.sin(course)]), np.array([run * math.cos(course)])
    )
    return Plane(latitude[0], longitude[0]), now


def _row(r: Reports, plane: Plane, t0: float, lost_after_s: float) -> Row:
    """One ship's reports as legs."""
    east, north = plane.to_plane(r.latitude_deg, r.longitude_deg)
    course = plane.course(r.latitude_deg, r.longitude_deg, np.radians(r.cog_deg))
    return Row.of(r.time_s - t0, east, north, course, r.sog_kn * KNOT_M_S, lost_after_s)


def _echo(reports: Reports) -> int | None:
    """The MMSI under which the recorder hears herself, if she does."""
    own = reports.mmsi == OWN_SENSORS
    if not own.any():
        return None
    mine, others = reports.take(own), reports.take(~own)
    plane = Plane(mine.latitude_deg[0], mine.longitude_deg[0])
    east, north = plane.to_plane(mine.latitude_deg, mine.longitude_deg)
    their_east, their_north = plane.to_plane(others.latitude_deg, others.longitude_deg)
    apart = np.hypot(
        their_east - np.interp(others.time_s, mine.time_s, east),
        their_north - np.interp(others.time_s, mine.time_s, north),
    )
    within = (others.time_s >= mine.time_s[0]) & (others.time_s <= mine.time_s[-1])
    for number in np.unique(others.mmsi):
        away = apart[(others.mmsi == number) & within]
        if len(away) >= 3 and away.max() < ECHO_M:
            return int(number)
    return None


def _fitted(
    ship: ShipParams,
    known: Particulars,
    own_row: Row,
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
    path: Path, number: int, own_row: Row, settings: RecordingSettings, notes: list[str]
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
    stretch = max(settings.nearest_waypoint_m / away[end], 1.0)
    if stretch > 1.0:
        notes.append(
            f"own ship's track ends {away[end] / NAUTICAL_MILE_M:.1f} NM off: her waypoint lies "
            f"{settings.nearest_waypoint_m / NAUTICAL_MILE_M:.1f} NM off in that direction"
        )
    return float(east[end] * stretch), float(north[end] * stretch)


def _info(number: int, known: Particulars) -> TargetInfo:
    if number == OWN_SENSORS:
        return TargetInfo(RECORDED, "recording ship", known.length_m, known.kind)
    return TargetInfo(str(number), known.name or called(number), known.length_m, known.kind)
