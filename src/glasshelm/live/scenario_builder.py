"""From what is known of ships to the arrays of an encounter, in a plane, at an instant."""

import dataclasses
import math
from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np

from glasshelm.ais.mmsi import is_number, station_label
from glasshelm.ais.vessel import CourseSpeed, Fix, Timed, Vessel
from glasshelm.encounters.projection import LocalProjection
from glasshelm.encounters.tracks import TrackColumns, single_track
from glasshelm.encounters.types import TargetInfo, Track
from glasshelm.ship.nomoto import ShipParams, ShipState

#: Below this speed [m/s] the course over ground is noise, and the heading is used.
DRIFTING_M_S = 0.5
#: A rate of turn or a rudder said so long ago [s] is no longer hers.
SENSOR_HOLDS_S = 10.0


@dataclasses.dataclass(frozen=True)
class OwnPosition:
    """Own ship dead-reckoned to now, in the plane; ``age_s`` is that of her position.

    ``rudder_rad`` is None where no sensor tells it.
    """

    east_m: float
    north_m: float
    course_rad: float
    rate_of_turn_rad_s: float
    rudder_rad: float | None
    speed_m_s: float
    age_s: float

    def state(self) -> ShipState:
        """As the world has it: arrays, so that other numbers need no other program."""
        fields = (
            self.east_m,
            self.north_m,
            self.course_rad,
            self.rate_of_turn_rad_s,
            self.rudder_rad or 0.0,
            self.speed_m_s,
        )
        return ShipState(*(jnp.asarray(x, jnp.float32) for x in fields))

    def track(self, lasts_s: float) -> Track:
        """Straight on for ``lasts_s``."""
        one = ([x] for x in (0.0, self.east_m, self.north_m, self.course_rad, self.speed_m_s))
        return single_track(TrackColumns.of(*one, lasts_s=lasts_s))


def to_plane(fix: Fix, plane: LocalProjection) -> tuple[float, float]:
    """East and north [m] of a position."""
    east, north = plane.to_plane(np.array([fix.latitude_deg]), np.array([fix.longitude_deg]))
    return float(east[0]), float(north[0])


def own_position(
    own: Vessel, fix: Fix, motion: CourseSpeed, plane: LocalProjection, now_s: float
) -> OwnPosition:
    """Own ship at ``now_s``, on her course over ground (adrift: her heading).

    Where neither is known, she is shown heading north.
    """
    course = motion.course_rad or 0.0
    if motion.speed_m_s < DRIFTING_M_S and own.heading is not None:
        course = own.heading.value
    east, north = to_plane(fix, plane)
    latitude, longitude, true = (
        np.array([x]) for x in (fix.latitude_deg, fix.longitude_deg, course)
    )
    in_plane = float(plane.course(latitude, longitude, true)[0])
    age = max(now_s - fix.time_s, 0.0)
    run = motion.speed_m_s * age
    return OwnPosition(
        east + run * math.sin(in_plane),
        north + run * math.cos(in_plane),
        in_plane,
        _held(own.rate_of_turn, now_s) or 0.0,
        _held(own.rudder, now_s),
        motion.speed_m_s,
        age,
    )


def _held(said: Timed | None, now_s: float) -> float | None:
    """What a sensor said, while it is still so."""
    return said.value if said and now_s - said.time_s <= SENSOR_HOLDS_S else None


def target_tracks(
    vessels: Sequence[Vessel | None], plane: LocalProjection, now_s: float, lasts_s: float
) -> Track:
    """One leg a slot, from the latest position; empty slots have one that never begins.

    Who may be going anywhere is shown where she is: without a course no speed is a direction.
    """
    found = [
        (k, v.fix, motion)
        for k, v in enumerate(vessels)
        if v is not None and v.fix is not None and (motion := v.course_speed()) is not None
    ]
    slots = [k for k, _, _ in found]
    time_s = np.array([fix.time_s for _, fix, _ in found])
    latitude = np.array([fix.latitude_deg for _, fix, _ in found])
    longitude = np.array([fix.longitude_deg for _, fix, _ in found])
    course = np.array([motion.course_rad or 0.0 for _, _, motion in found])
    start, end = np.full((2, len(vessels)), np.inf)
    east, north, direction, speed = np.zeros((4, len(vessels)))
    if slots:
        # A report dated a little after now (by another clock) counts as of now.
        start[slots] = np.minimum(time_s - now_s, 0.0)
        end[slots] = start[slots] + lasts_s
        east[slots], north[slots] = plane.to_plane(latitude, longitude)
        direction[slots] = plane.course(latitude, longitude, course)
        speed[slots] = [0.0 if m.course_rad is None else m.speed_m_s for _, _, m in found]
    columns = (start, end, east, north, direction, speed)
    return Track(*(jnp.asarray(x[:, None], jnp.float32) for x in columns))


def with_own_dimensions(ship: ShipParams, own: Vessel, speed_m_s: float) -> ShipParams:
    """The ship with the speed of now (an array) and, where told, own ship's length and beam."""
    loa = own.length_m or float(ship.loa_m)
    beam = own.beam_m or float(ship.beam_m) * loa / float(ship.loa_m)
    speed = jnp.asarray(speed_m_s, jnp.float32)
    return dataclasses.replace(ship, loa_m=loa, beam_m=beam, speed_m_s=speed)


def target_info(vessel: Vessel | None) -> TargetInfo:
    """Who is in a slot."""
    if vessel is None:
        return TargetInfo("", "empty slot")
    number = vessel.shares_id_of or vessel.id
    name = vessel.name or (station_label(number) if is_number(number) else number)
    if vessel.shares_id_of:
        name = f"{name} (second)"
    return TargetInfo(vessel.id, name, vessel.length_m, vessel.ship_type)
