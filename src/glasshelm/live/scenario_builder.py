"""From what is known of ships to the arrays of an encounter, in a plane, at an instant."""

import dataclasses
import math
from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np

from glasshelm.ais.mmsi import is_number, station_label
from glasshelm.ais.vessel import DRIFTING_M_S, CourseSpeed, Fix, Timed, Vessel
from glasshelm.encounters.projection import LocalProjection
from glasshelm.encounters.tracks import TrackColumns, single_track
from glasshelm.encounters.types import TargetInfo, Track
from glasshelm.ship.nomoto import ShipState

#: A rate of turn or a rudder angle older than this [s] is no longer valid.
SENSOR_HOLDS_S = 10.0


@dataclasses.dataclass(frozen=True)
class OwnPosition:
    """Own ship dead-reckoned to now, in the plane; ``age_s`` is that of its last fix.

    ``rudder_rad`` is None where there is no sensor of it.
    """

    east_m: float
    north_m: float
    course_rad: float
    rate_of_turn_rad_s: float
    rudder_rad: float | None
    speed_m_s: float
    age_s: float

    def state(self) -> ShipState:
        """The state as arrays, so that other numbers compile no other program."""
        *motion, rudder, speed, _ = dataclasses.astuple(self)
        return ShipState(*(jnp.asarray(x, jnp.float32) for x in (*motion, rudder or 0.0, speed)))

    def track(self, duration_s: float) -> Track:
        """Straight on for ``duration_s``."""
        leg = ([x] for x in (0.0, self.east_m, self.north_m, self.course_rad, self.speed_m_s))
        return single_track(TrackColumns.of(*leg, leg_duration_s=duration_s))


def to_plane(fix: Fix, plane: LocalProjection) -> tuple[float, float]:
    """East and north [m] of a fix."""
    east, north = plane.to_plane(np.array([fix.latitude_deg]), np.array([fix.longitude_deg]))
    return float(east[0]), float(north[0])


def own_position(
    own: Vessel, fix: Fix, motion: CourseSpeed, plane: LocalProjection, now_s: float
) -> OwnPosition:
    """Own ship at ``now_s``, on its course over ground (adrift: its heading).

    Where neither is known, it is shown heading north.
    """
    course = motion.course_rad or 0.0
    if motion.speed_m_s < DRIFTING_M_S and "heading_rad" in own.motion:
        course = own.motion["heading_rad"].value
    east, north = to_plane(fix, plane)
    place = (np.array([x]) for x in (fix.latitude_deg, fix.longitude_deg, course))
    plane_course = float(plane.course(*place)[0])
    age = max(now_s - fix.time_s, 0.0)
    run = motion.speed_m_s * age
    return OwnPosition(
        east + run * math.sin(plane_course),
        north + run * math.cos(plane_course),
        plane_course,
        _if_valid(own.motion.get("rate_of_turn_rad_s"), now_s) or 0.0,
        _if_valid(own.motion.get("rudder_rad"), now_s),
        motion.speed_m_s,
        age,
    )


def _if_valid(value: Timed | None, now_s: float) -> float | None:
    """The value of a sensor, while it still holds."""
    return value.value if value and now_s - value.time_s <= SENSOR_HOLDS_S else None


def target_tracks(
    vessels: Sequence[Vessel | None], plane: LocalProjection, now_s: float, duration_s: float
) -> Track:
    """One leg a slot, from the latest position; empty slots have one that never begins.

    A target whose course is not known is shown at its last position, with speed 0.
    """
    known = [
        (k, v.fix, motion)
        for k, v in enumerate(vessels)
        if v is not None and v.fix is not None and (motion := v.course_speed()) is not None
    ]
    slots = [k for k, _, _ in known]
    time_s = np.array([fix.time_s for _, fix, _ in known])
    latitude = np.array([fix.latitude_deg for _, fix, _ in known])
    longitude = np.array([fix.longitude_deg for _, fix, _ in known])
    course = np.array([motion.course_rad or 0.0 for _, _, motion in known])
    start, end = np.full((2, len(vessels)), np.inf)
    east, north, direction, speed = np.zeros((4, len(vessels)))
    if slots:
        # A report dated a little after now (by another clock) counts as of now.
        start[slots] = np.minimum(time_s - now_s, 0.0)
        end[slots] = start[slots] + duration_s
        east[slots], north[slots] = plane.to_plane(latitude, longitude)
        direction[slots] = plane.course(latitude, longitude, course)
        speed[slots] = [0.0 if m.course_rad is None else m.speed_m_s for _, _, m in known]
    columns = (start, end, east, north, direction, speed)
    return Track(*(jnp.asarray(x[:, None], jnp.float32) for x in columns))


def target_info(vessel: Vessel | None) -> TargetInfo:
    """Which ship is in a slot."""
    if vessel is None:
        return TargetInfo("", "empty slot")
    number = vessel.shares_id_of or vessel.id
    name = vessel.static.name or (station_label(number) if is_number(number) else number)
    if vessel.shares_id_of:
        name = f"{name} (second)"
    return TargetInfo(vessel.id, name, vessel.static.length_m, vessel.static.ship_type)
