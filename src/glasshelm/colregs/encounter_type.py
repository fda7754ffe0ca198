"""What kind of meeting it is: Rules 13 to 15 of the COLREGs, from bearings and courses."""

import enum
import math

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from glasshelm.core.geometry import Vector, direction, wrap_angle
from glasshelm.planning.course_planner import Situation


class Meeting(enum.IntEnum):
    """The part that own ship has in a meeting with another."""

    HEAD_ON = 0  # Rule 14: both alter to starboard
    GIVE_WAY = 1  # Rule 15: crossing, the other to starboard
    STAND_ON = 2  # Rule 15 and 17: crossing, the other to port
    OVERTAKING = 3  # Rule 13: own ship keeps clear
    OVERTAKEN = 4  # Rule 13 and 17: own ship stands on


#: More than 22.5° abaft the beam (Rule 13).
ABAFT_RAD = math.radians(112.5)
#: "Nearly reciprocal" courses (Rule 14): half the sector of Kuwata et al. 2014.
RECIPROCAL_RAD = math.radians(15.0)


def meetings(at: Situation, course_rad: Float[Array, ""]) -> Int[Array, " n"]:
    """The :class:`Meeting` with every ship if own ship is on a course (off her heading now)."""
    bearing = wrap_angle(direction(at.position) - course_rad)
    hers = direction(at.velocity)
    aspect = wrap_angle(direction(Vector(-at.position.x, -at.position.y)) - hers)
    reciprocal = jnp.abs(wrap_angle(hers - course_rad - math.pi)) < RECIPROCAL_RAD
    crossing = jnp.where(bearing >= 0, Meeting.GIVE_WAY, Meeting.STAND_ON)
    kind = jnp.where(reciprocal, Meeting.HEAD_ON, crossing)
    kind = jnp.where(jnp.abs(aspect) > ABAFT_RAD, Meeting.OVERTAKING, kind)
    return jnp.where(jnp.abs(bearing) > ABAFT_RAD, Meeting.OVERTAKEN, kind)
