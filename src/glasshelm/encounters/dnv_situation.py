"""Traffic situations of DNV's open JSON format as scenarios."""

import math
from datetime import UTC, datetime
from pathlib import Path

import jax.numpy as jnp
import numpy as np

from glasshelm.core.errors import InputError
from glasshelm.core.geometry import Vector
from glasshelm.encounters.dnv_schema import VoyagePlan, read_situation_file, voyage_plan
from glasshelm.encounters.imazu import PAPER_WAYPOINT_M
from glasshelm.encounters.projection import LocalProjection
from glasshelm.encounters.tracks import TrackColumns, stack_tracks
from glasshelm.encounters.types import Encounter, Scenario, TargetInfo, with_dimensions
from glasshelm.ship.nomoto import KNOT_M_S, ShipParams, ShipState


def read_situation(path: str | Path, ship: ShipParams) -> Scenario:
    """The scenario of a traffic-situation file, in either layout.

    Targets follow their waypoints at their leg speeds and keep straight on after the
    last. A file whose list of targets is empty gives a scenario without ships.

    Args:
        path: A JSON file, packed or not, in any encoding.
        ship: Own ship's K, T and rudder; length, beam and speed where the file has none.

    Raises:
        InputError: A field is missing or impossible, or a target starts within own ship's
            length. The message names the file and the field.
    """
    file = Path(path)
    situation, unused = read_situation_file(file)
    notes = [f"not used in the file: {', '.join(unused)[:200]}"] if unused else []
    own = voyage_plan(situation.own_ship, f"{file}: ownShip")
    if own.speeds_kn[0] == 0:
        raise InputError(f"{file}: ownShip stands still (sog 0): it must be above 0")
    plane = LocalProjection(*own.points[0])
    if own.length_m is None:
        notes.append(f"own ship's length is not in the file: {float(ship.loa_m):.0f} m assumed")
    ship = with_dimensions(ship, own.length_m, own.beam_m, own.speeds_kn[0] * KNOT_M_S)
    vessels = situation.target_ships or situation.target_ship or []
    plans = [voyage_plan(v, f"{file}: targetShips[{i}]") for i, v in enumerate(vessels)]
    rows = [_legs(v, plane) for v in plans]
    for i, (row, target) in enumerate(zip(rows, plans, strict=True)):
        range_m = math.hypot(row.east_m[0], row.north_m[0])
        if range_m < ship.loa_m:
            raise InputError(
                f"{file}: targetShips[{i}] ({target.name or 'no name'}) starts {range_m:.0f} m "
                f"from own ship: it must be at least her length, {ship.loa_m:.0f} m"
            )
    if not vessels:
        notes.append("the file has no target ships")
    own_legs = _legs(own, plane)
    if len(own.points) == 1:
        notes.append("own ship has no second waypoint: she sails straight on")
    if len(set(own.speeds_kn)) > 1:
        notes.append("own ship keeps the speed of her first leg")
    # A lone point is followed by the paper's waypoint, straight ahead.
    if len(own.points) == 1:
        east = np.array([PAPER_WAYPOINT_M * math.sin(own_legs.course_rad[0])])
        north = np.array([PAPER_WAYPOINT_M * math.cos(own_legs.course_rad[0])])
    else:
        east, north = plane.to_plane(*np.array(own.points[1:]).T)
    heading = own_legs.course_rad[0] if own.heading_deg is None else math.radians(own.heading_deg)
    return Scenario(
        source=str(path),
        title=situation.title or file.stem,
        encounter=Encounter(
            ShipState.steady(0.0, 0.0, heading, ship.speed_m_s),
            Vector(jnp.asarray(east, jnp.float32), jnp.asarray(north, jnp.float32)),
            stack_tracks(rows),
            jnp.ones(len(rows), bool),
        ),
        targets=tuple(
            TargetInfo(v.id or str(i + 1), v.name or f"ship {i + 1}", v.length_m, v.ship_type)
            for i, v in enumerate(plans)
        ),
        ship=ship,
        duration_s=_duration_s(own, east, north, float(ship.speed_m_s)),
        own_name=own.name or "own ship",
        origin=plane.origin,
        start=_start_time(situation.start_time, file),
        notes=tuple(notes),
    )


def _legs(ship: VoyagePlan, plane: LocalProjection) -> TrackColumns:
    """The legs of a vessel: one from each point to the next, the last for ever."""
    points = np.array(ship.points)
    east, north = plane.to_plane(points[:, 0], points[:, 1])
    steps = np.hypot(np.diff(east), np.diff(north))
    if not np.any(steps > 1.0):  # she lies still, or sails straight on from one point
        course = math.radians(ship.course_deg or 0.0)
        speed = ship.speeds_kn[0] * KNOT_M_S if len(points) == 1 else 0.0
        return TrackColumns.of([0.0], east[:1], north[:1], [course], [speed])
    starts, legs, time = [], [], 0.0
    for i in np.flatnonzero(steps > 1.0):
        starts.append(time)
        legs.append(i)
        speed = ship.speeds_kn[i] * KNOT_M_S
        if speed == 0:
            break
        time += steps[i] / speed
    kept = np.array(legs)
    course = np.arctan2(np.diff(east)[kept], np.diff(north)[kept])
    speeds = np.array(ship.speeds_kn)[kept] * KNOT_M_S
    return TrackColumns.of(starts, east[kept], north[kept], course, speeds)


def _duration_s(own: VoyagePlan, east: np.ndarray, north: np.ndarray, speed: float) -> float:
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
