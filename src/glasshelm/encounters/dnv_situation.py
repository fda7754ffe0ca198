"""Traffic situations of DNV's open JSON format as scenarios, and back."""

import dataclasses
import itertools
import math
from datetime import UTC, datetime
from pathlib import Path

import jax
import jax.numpy as jnp
import msgspec
import numpy as np

from glasshelm.core.errors import InputError
from glasshelm.core.geometry import Vector
from glasshelm.core.output_dir import atomic_write
from glasshelm.encounters.dnv_schema import (
    SCHEMA_VERSION,
    TRAFFICGEN_VERSION,
    Dimensions,
    Initial,
    Leg,
    Position,
    Situation,
    Static,
    Vessel,
    Voyage,
    Waypoint,
    read_file,
    voyage,
)
from glasshelm.encounters.imazu import PAPER_WAYPOINT_M
from glasshelm.encounters.projection import LocalProjection
from glasshelm.encounters.tracks import TrackColumns, stack_rows
from glasshelm.encounters.types import Encounter, Scenario, TargetInfo, motion_at
from glasshelm.ship.nomoto import KNOT_M_S, ShipParams, ShipState

_NAV_STATUS = "Under way using engine"


def read_situation(path: str | Path, ship: ShipParams) -> Scenario:
    """The scenario of a traffic-situation file, in either layout.

    Own ship keeps K, T and rudder of ``ship``; her length, beam and speed are
    the file's where it gives them. Targets sail along their waypoints at their
    leg speeds and keep straight on after the last. A file that says it has no targets is
    a scenario of no ships. InputError names the file and the field if one is
    missing or impossible, or if a target starts within own ship's length.
    """
    file = Path(path)
    situation, unused = read_file(file)
    notes = [f"not used in the file: {', '.join(unused)[:200]}"] if unused else []
    own = voyage(situation.own_ship, f"{file}: ownShip")
    if own.speeds_kn[0] == 0:
        raise InputError(f"{file}: ownShip stands still (sog 0): it must be above 0")
    plane = LocalProjection(*own.points[0])
    ship = _fitted(ship, own, notes)
    vessels = situation.target_ships or situation.target_ship or []
    voyages = [voyage(v, f"{file}: targetShips[{i}]") for i, v in enumerate(vessels)]
    rows = [_row(v, plane) for v in voyages]
    for i, (row, target) in enumerate(zip(rows, voyages, strict=True)):
        range_m = math.hypot(row.east_m[0], row.north_m[0])
        if range_m < ship.loa_m:
            raise InputError(
                f"{file}: targetShips[{i}] ({target.name or 'no name'}) starts {range_m:.0f} m "
                f"from own ship: it must be at least her length, {ship.loa_m:.0f} m"
            )
    if not vessels:
        notes.append("the file has no target ships")
    own_row = _row(own, plane)
    if len(own.points) == 1:
        notes.append("own ship has no second waypoint: she sails straight on")
    if len(set(own.speeds_kn)) > 1:
        notes.append("own ship keeps the speed of her first leg")
    # A lone point is followed by the paper's waypoint, straight ahead.
    if len(own.points) == 1:
        east = np.array([PAPER_WAYPOINT_M * math.sin(own_row.course_rad[0])])
        north = np.array([PAPER_WAYPOINT_M * math.cos(own_row.course_rad[0])])
    else:
        east, north = plane.to_plane(*np.array(own.points[1:]).T)
    heading = own_row.course_rad[0] if own.heading_deg is None else math.radians(own.heading_deg)
    return Scenario(
        source=str(path),
        title=situation.title or file.stem,
        encounter=Encounter(
            ShipState.steady(0.0, 0.0, heading, ship.speed_m_s),
            Vector(jnp.asarray(east, jnp.float32), jnp.asarray(north, jnp.float32)),
            stack_rows(rows),
            jnp.ones(len(rows), bool),
        ),
        targets=tuple(
            TargetInfo(v.id or str(i + 1), v.name or f"ship {i + 1}", v.length_m, v.kind)
            for i, v in enumerate(voyages)
        ),
        ship=ship,
        duration_s=_duration_s(own, east, north, float(ship.speed_m_s)),
        own_name=own.name or "own ship",
        origin=plane.origin,
        start=_start_time(situation.start_time, file),
        notes=tuple(notes),
    )


def write_situation(
    path: str | Path, scenario: Scenario, origin: tuple[float, float] = (0.0, 0.0)
) -> None:
    """Write a scenario in the newer layout (schemaVersion 0.2.0).

    ``origin`` is the latitude and longitude [deg] of (0, 0) for a scenario that
    has none. The format knows neither a ship that appears later nor one that is
    lost: targets not there at the start are left out and named in the
    description; the others sail on to the end.
    """
    plane = LocalProjection(*(scenario.origin or origin))
    encounter = scenario.encounter
    own = encounter.own
    own_points = [(float(own.east_m), float(own.north_m))] + [
        (float(e), float(n)) for e, n in zip(encounter.route.x, encounter.route.y, strict=True)
    ]
    vessels, left_out = [], []
    start = motion_at(encounter.targets, jnp.zeros(()))
    for i, info in enumerate(scenario.targets):
        if not (bool(start.present[i]) and bool(encounter.present[i])):
            left_out.append(info.name)
            continue
        points, speeds = _points(scenario, i)
        course = math.degrees(float(start.course_rad[i]))
        static = _static(info.name, info.length_m, None, i + 2)
        vessels.append(_vessel(plane, points, speeds, course, static))
    description = f"From {scenario.source}."
    if left_out:
        description += f" Left out, not there at the start: {', '.join(left_out)}."
    ship = scenario.ship
    own_static = _static(scenario.own_name, float(ship.loa_m), float(ship.beam_m), 1)
    speed = float(own.speed_m_s)
    document = Situation(
        own_ship=_vessel(
            plane,
            own_points,
            [speed] * len(own_points),
            math.degrees(float(own.heading_rad)),
            own_static,
        ),
        target_ships=vessels,
        title=scenario.title,
        description=description,
        start_time=None if scenario.start is None else scenario.start.isoformat(),
        schema_version=SCHEMA_VERSION,
        trafficgen_version=TRAFFICGEN_VERSION,
    )
    with atomic_write(path) as partial:
        partial.write_bytes(msgspec.json.format(msgspec.json.encode(document), indent=4) + b"\n")


def _fitted(ship: ShipParams, own: Voyage, notes: list[str]) -> ShipParams:
    """The ship with the length, beam and speed of the file."""
    loa, beam = own.length_m, own.beam_m
    if loa is None:
        notes.append(f"own ship's length is not in the file: {float(ship.loa_m):.0f} m assumed")
        loa = float(ship.loa_m)
    if beam is None:
        beam = float(ship.beam_m) * loa / float(ship.loa_m)
    speed = own.speeds_kn[0] * KNOT_M_S
    return dataclasses.replace(ship, loa_m=loa, beam_m=beam, speed_m_s=speed)


def _row(vessel: Voyage, plane: LocalProjection) -> TrackColumns:
    """The legs of a vessel: one from each point to the next, the last for ever."""
    points = np.array(vessel.points)
    east, north = plane.to_plane(points[:, 0], points[:, 1])
    steps = np.hypot(np.diff(east), np.diff(north))
    if not np.any(steps > 1.0):  # she lies still, or sails straight on from one point
        course = math.radians(vessel.course_deg or 0.0)
        speed = vessel.speeds_kn[0] * KNOT_M_S if len(points) == 1 else 0.0
        return TrackColumns.of([0.0], east[:1], north[:1], [course], [speed])
    starts, legs, time = [], [], 0.0
    for i in np.flatnonzero(steps > 1.0):
        starts.append(time)
        legs.append(i)
        speed = vessel.speeds_kn[i] * KNOT_M_S
        if speed == 0:
            break
        time += steps[i] / speed
    kept = np.array(legs)
    course = np.arctan2(np.diff(east)[kept], np.diff(north)[kept])
    speeds = np.array(vessel.speeds_kn)[kept] * KNOT_M_S
    return TrackColumns.of(starts, east[kept], north[kept], course, speeds)


def _duration_s(own: Voyage, east: np.ndarray, north: np.ndarray, speed: float) -> float:
    """How long own ship's route takes, at least 20 min; 40 min if she has no route."""
    if len(own.points) == 1:
        return 2400.0
    lengths = np.hypot(np.diff(east, prepend=0.0), np.diff(north, prepend=0.0))
    return max(float(lengths.sum()) / speed, 1200.0)


def _start_time(text: str | None, file: Path) -> datetime | None:
    if text is None:
        return None
    try:
        time = datetime.fromisoformat(text)
    except ValueError:
        raise InputError(f"{file}: startTime {text!r} is not an ISO 8601 time") from None
    time = time if time.tzinfo else time.replace(tzinfo=UTC)
    if not 1970 <= time.year <= 2100:
        raise InputError(f"{file}: startTime {text!r} must be between 1970 and 2100")
    return time


def _points(scenario: Scenario, slot: int) -> tuple[list[tuple[float, float]], list[float]]:
    """Where a target's legs begin from t = 0 on, her place at the end, and the leg speeds."""
    track = jax.tree.map(lambda x: x[slot], scenario.encounter.targets)
    now = motion_at(track, jnp.zeros(()))
    starts = np.asarray(track.start_s)
    later = np.flatnonzero((starts > 0) & np.isfinite(starts))
    times = [0.0, *starts[later].tolist()]
    points = [(float(now.east_m), float(now.north_m))]
    points += [(float(track.east_m[i]), float(track.north_m[i])) for i in later]
    last = int(later[-1]) if len(later) else int(np.sum(starts <= 0)) - 1
    speed, course = float(track.speed_m_s[last]), float(track.course_rad[last])
    left_s = max(scenario.duration_s - times[-1], 60.0)
    east, north = points[-1]
    run = speed * left_s
    points.append((east + run * math.sin(course), north + run * math.cos(course)))
    times.append(times[-1] + left_s)
    speeds = [
        math.dist(a, b) / (t_b - t_a)
        for (a, b), (t_a, t_b) in zip(
            itertools.pairwise(points), itertools.pairwise(times), strict=True
        )
    ]
    return points, [*speeds, speeds[-1]]


def _vessel(
    plane: LocalProjection,
    points: list[tuple[float, float]],
    speeds_m_s: list[float],
    course_deg: float,
    static: Static,
) -> Vessel:
    latitude, longitude = plane.to_globe(*np.array(points).T)
    waypoints = [
        Waypoint(
            Position(lat=round(float(lat), 8), lon=round(float(lon), 8)),
            Leg(sog=round(speed / KNOT_M_S, 6)),
        )
        for lat, lon, speed in zip(latitude, longitude, speeds_m_s, strict=True)
    ]
    heading = round(course_deg % 360.0, 4)
    return Vessel(static, Initial(heading=heading, nav_status=_NAV_STATUS), waypoints)


def _static(name: str, length_m: float | None, beam_m: float | None, number: int) -> Static:
    size = None if length_m is None else Dimensions(length=length_m, width=beam_m)
    return Static(id=number, name=name, dimensions=size)
