"""The trial manoeuvre of a radar: the CPA of every ship if own ship took another course.

Closed form, as an ARPA computes it. Own ship is taken to keep her present
course for a lag and then to turn on a circle at full rudder; from the end of
the turn on everything is straight, and the CPA exact.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.core.geometry import Cpa, Vector, closest_approach, velocity, wrap_angle
from glasshelm.planning.situation import Situation
from glasshelm.ship.autopilot import MIN_TIME_CONSTANT_S
from glasshelm.ship.nomoto import ShipParams

#: Share of Nomoto's T by which a turn comes late (fitted to turns of 10 to 120 degrees under the
#: autopilot: within 30 s of delay for both preset ships).
_LAG = 0.9


def turning_loss(turn_rad: Float[Array, "*c"], ship: ShipParams) -> Vector:
    """Where own ship will be, less where she would be had she turned at once [m].

    The same for all times after the turn; axes of her present heading.
    """
    fastest = ship.gain_1_s * ship.rudder_limit_rad
    speed, radius = ship.speed_m_s, ship.speed_m_s / fastest
    angle = jnp.abs(turn_rad)
    new, arc = velocity(angle, 1.0), radius * angle
    lag = speed * jnp.maximum(_LAG * ship.time_constant_s, MIN_TIME_CONSTANT_S)
    across = radius * (1.0 - new.y) - (arc + lag) * new.x
    along = radius * new.x - (arc + lag) * new.y + lag
    return Vector(jnp.sign(turn_rad) * across, along)


def try_courses(
    at: Situation, course_rad: Float[Array, " c"], ship: ShipParams
) -> tuple[Vector, Vector]:
    """Relative position [m] and velocity [m/s] of every ship, [course, ship], on each course.

    Courses are off the present heading, and so are the axes. A position is
    where a ship would be now relative to an own ship that turns at once and is
    later where own ship, who cannot, will be.
    """
    turn = wrap_angle(course_rad)[:, None]
    own, lost = velocity(turn, ship.speed_m_s), turning_loss(turn, ship)
    return (
        Vector(at.position.x - lost.x, at.position.y - lost.y),
        Vector(at.velocity.x - own.x, at.velocity.y - own.y),
    )


def cpa_on(at: Situation, course_rad: Float[Array, " c"], ship: ShipParams) -> Cpa:
    """CPA of every ship on each course, [course, ship]."""
    return closest_approach(*try_courses(at, course_rad, ship))
