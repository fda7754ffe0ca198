"""Manoeuvres, the actions of pilots that think in courses, and own ship's way under each.

A manoeuvre is a course held for a time, a second one, and then the way to the waypoint. It fixes
own ship's future whatever others do, so what one ship will cost depends on that ship alone:
sub-task critics of manoeuvres add up exactly.
"""

import dataclasses

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from glasshelm.core.geometry import Vector, direction, velocity, wrap_angle
from glasshelm.planning.situation import Situation
from glasshelm.ship.autopilot import Autopilot, autopilot_for
from glasshelm.ship.nomoto import ShipParams

_SIDE = (10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 75.0, 90.0, 120.0)


@dataclasses.dataclass(frozen=True)
class ManoeuvreTable:
    """Which manoeuvres there are. Courses [deg] are off the bearing of the waypoint.

    The first is the way to the waypoint. One alteration: each of ``offsets_deg`` for each of
    ``durations_s``. Two: each of ``first_deg`` for ``first_s``, then ``second_deg`` for
    ``second_s``. And the present heading, kept for each of ``keep_s``; the last of them is
    *keep course and speed*, from which priorities are measured (Eq. 22).
    """

    offsets_deg: tuple[float, ...] = (*(-a for a in reversed(_SIDE)), *_SIDE)
    durations_s: tuple[float, ...] = (200.0, 400.0, 700.0, 1000.0, 1400.0, 1900.0)
    first_deg: tuple[float, ...] = (-90.0, -60.0, -40.0, -20.0, 0.0, 20.0, 40.0, 60.0, 90.0)
    first_s: tuple[float, ...] = (100.0, 250.0, 500.0, 900.0)
    second_deg: tuple[float, ...] = (-110.0, -70.0, -30.0, 30.0, 70.0, 110.0)
    second_s: tuple[float, ...] = (150.0, 400.0, 1000.0)
    keep_s: tuple[float, ...] = (150.0, 400.0, 700.0, 1000.0, 1400.0, 1900.0)

    @property
    def size(self) -> int:
        """How many manoeuvres there are."""
        one = sum(a != 0 for a in self.offsets_deg) * len(self.durations_s)
        changes = sum(a != b for a in self.first_deg for b in self.second_deg)
        two = changes * len(self.first_s) * len(self.second_s)
        return 1 + one + two + len(self.keep_s)

    def off_waypoint(self) -> Float[np.ndarray, "c 4"]:
        """Those off the waypoint: course [rad], duration [s], second course [rad], duration [s]."""
        one = [(a, s, 0, 0) for a in self.offsets_deg for s in self.durations_s if a]
        two = [
            (a, s, b, t)
            for a in self.first_deg
            for s in self.first_s
            for b in self.second_deg
            for t in self.second_s
            if a != b
        ]
        table = np.array([(0.0, 0.0, 0.0, 0.0), *one, *two], np.float32)
        table[:, [0, 2]] = np.radians(table[:, [0, 2]])
        return table

    def at(self, bearing_rad: Float[Array, ""]) -> "Manoeuvres":
        """The manoeuvres where the waypoint bears so much off the bow [rad]."""
        rows = [(0.0, seconds, 0.0, 0.0) for seconds in self.keep_s]
        keep = jnp.array(rows).reshape(-1, 4).at[:, 0].set(-bearing_rad)
        return Manoeuvres(*jnp.concatenate([jnp.asarray(self.off_waypoint()), keep]).T)

    def along(self, course_rad: Float[Array, ""], bearing_rad: Float[Array, ""]) -> "Manoeuvres":
        """One course, relative to own heading, held for each of ``durations_s``."""
        durations = jnp.array(self.durations_s)
        zero = jnp.zeros_like(durations)
        return Manoeuvres(wrap_angle(course_rad - bearing_rad) + zero, durations, zero, zero)


class Manoeuvres(eqx.Module):
    """Manoeuvres, one a row.

    Attributes:
        offset_rad: The course that each begins with, off the bearing of the waypoint now.
        duration_s: How long that course is held; 0: steer for the waypoint at once.
        then_offset_rad: The second course, off the same bearing.
        then_duration_s: How long that is held; 0: there is none.
    """

    offset_rad: Float[Array, "*c"]
    duration_s: Float[Array, "*c"]
    then_offset_rad: Float[Array, "*c"]
    then_duration_s: Float[Array, "*c"]

    def altered_rad(self, bearing_rad: Float[Array, ""]) -> Float[Array, "*c"]:
        """All alterations of course that it takes, from the present heading to the waypoint."""
        last = jnp.where(self.then_duration_s > 0, self.then_offset_rad, self.offset_rad)
        first = jnp.abs(wrap_angle(bearing_rad + self.offset_rad))
        return first + jnp.abs(last - self.offset_rad) + jnp.abs(last)


class PredictedOwn(eqx.Module):
    """Imagined own ships, one a manoeuvre; ``way`` is where their bows point, a unit vector."""

    x: Float[Array, " c"]
    y: Float[Array, " c"]
    heading: Float[Array, " c"]
    rate: Float[Array, " c"]
    way: Vector

    @staticmethod
    def here(rate_of_turn_rad_s: Float[Array, ""], manoeuvres: int) -> "PredictedOwn":
        """All of them where own ship is, with its rate of turn."""
        zero = jnp.zeros(manoeuvres)
        return PredictedOwn(zero, zero, zero, zero + rate_of_turn_rad_s, Vector(zero, zero + 1.0))

    def bearing_of(self, place: Vector) -> Float[Array, " c"]:
        """The bearing of a place, in the frame of own ship's heading now."""
        return direction(Vector(place.x - self.x, place.y - self.y))

    def body(self, place: Vector) -> Vector:
        """A place relative to each (starboard, ahead)."""
        x, y = place.x - self.x, place.y - self.y
        return Vector(x * self.way.y - y * self.way.x, x * self.way.x + y * self.way.y)


def predict_manoeuvres(
    ahead: PredictedOwn,
    bearing_rad: Float[Array, " c"],
    manoeuvres: Manoeuvres,
    time_s: Float[Array, ""],
    at: Situation,
    ship: ShipParams,
    tau_s: float,
    autopilot: Autopilot | None = None,
) -> PredictedOwn:
    """Own ship one step of ``tau_s`` later on each manoeuvre, ``time_s`` after its beginning.

    ``bearing_rad`` is that of the waypoint from where each is. The autopilot is the ship's own
    unless another is given.
    """
    m = manoeuvres
    second = jnp.where(time_s < m.duration_s + m.then_duration_s, m.then_offset_rad, 0.0)
    altered = jnp.where(time_s < m.duration_s, m.offset_rad, second)
    course = jnp.where(altered == 0.0, bearing_rad, at.bearing_rad + altered)
    return predict_step(ahead, course, autopilot or autopilot_for(ship), ship, tau_s)


def predict_step(
    ahead: PredictedOwn,
    course: Float[Array, " c"],
    autopilot: Autopilot,
    ship: ShipParams,
    tau_s: float,
) -> PredictedOwn:
    """One step towards a course: Eq. 6 exactly for a constant rudder, Eq. 7 along the arc.

    The run over ground is the mean of both ways, lengthened from that of a chord's ends
    to the chord's (by Δψ²/12): one sine a step instead of two.
    """
    rudder = autopilot.rudder_rad(wrap_angle(course - ahead.heading), ahead.rate)
    lag = ship.time_constant_s
    decay = jnp.exp(-tau_s / lag)
    steady = ship.gain_1_s * rudder
    transient = ahead.rate - steady
    turned = steady * tau_s + transient * (lag * (1.0 - decay))
    heading = ahead.heading + turned
    way = velocity(heading, 1.0)
    run = (0.5 * ship.speed_m_s * tau_s) * (1.0 + turned * turned * (1.0 / 12.0))
    return PredictedOwn(
        ahead.x + run * (ahead.way.x + way.x),
        ahead.y + run * (ahead.way.y + way.y),
        heading,
        steady + transient * decay,
        way,
    )
