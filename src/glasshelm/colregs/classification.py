"""Encounter types, roles and risk of collision by Rules 7 and 13-15 of the COLREGs.

This is the only classifier. Pilots, the evaluation, the bridge page and the text all use it.
Rule 13 gives a number (22.5 degrees abaft the beam); Rule 14 gives none for "reciprocal or
nearly reciprocal courses". Two limits for it are in use, :data:`EVALUATION_HEAD_ON` and
:data:`PILOT_HEAD_ON`. They stand side by side because all published results were computed
with them: over 1,000 random encounters they differ on 0.7 % of the targets with risk of
collision (and on who gives way for 0.25 %), which is enough to change single voyages.
"""

import dataclasses
import enum
import math

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from glasshelm.core.geometry import Vector, direction, wrap_angle
from glasshelm.ship.nomoto import KNOT_M_S, NAUTICAL_MILE_M

#: Risk of collision: the ships would pass this near on their present courses and speeds ...
RISK_DCPA_M = NAUTICAL_MILE_M
#: ... within this time ...
RISK_TCPA_S = 1800.0
#: ... while in sight of one another: the range of a masthead light (Rule 22(a)).
VISIBILITY_M = 6 * NAUTICAL_MILE_M
#: A ship slower over ground counts as stopped. Rules 13-15 are for vessels under way, and the
#: course of a stopped ship means nothing.
STOPPED_M_S = 0.5 * KNOT_M_S
#: A ship that comes up from more than 22.5 degrees abaft the beam is overtaking (Rule 13(b)).
ABAFT_RAD = math.radians(112.5)


_Numbers = Float[Array, "*n"] | float


@dataclasses.dataclass(frozen=True)
class HeadOnLimits:
    """What counts as meeting "on reciprocal or nearly reciprocal courses" (Rule 14(a)).

    Attributes:
        bearing_rad: Each ship sees the other at most this far off its bow.
        course_rad: The courses differ from opposite ones by at most this.
    """

    bearing_rad: float = math.inf
    course_rad: float = math.inf


#: The evaluation and the page: each ship is ahead or nearly ahead of the other (Rule 14(b)).
EVALUATION_HEAD_ON = HeadOnLimits(bearing_rad=math.radians(13.0))
#: The rule-based pilots: half the head-on sector of Kuwata et al. (2014).
PILOT_HEAD_ON = HeadOnLimits(course_rad=math.radians(15.0))


class EncounterType(enum.IntEnum):
    """The part that own ship has in an encounter with one target."""

    NONE = 0  #: no risk of collision
    HEAD_ON = 1  #: Rule 14: both alter to starboard
    CROSSING_GIVE_WAY = 2  #: Rule 15: the target is to starboard
    CROSSING_STAND_ON = 3  #: Rules 15 and 17: the target is to port
    OVERTAKING = 4  #: Rule 13: own ship keeps clear
    OVERTAKEN = 5  #: Rules 13 and 17: own ship stands on


def gives_way(types: Int[Array, "*n"]) -> Bool[Array, "*n"]:
    """Whether own ship must keep clear; in a head-on encounter both ships must."""
    head_on, crossing = types == EncounterType.HEAD_ON, types == EncounterType.CROSSING_GIVE_WAY
    return head_on | crossing | (types == EncounterType.OVERTAKING)


def stands_on(types: Int[Array, "*n"] | EncounterType) -> Bool[Array, "*n"] | bool:
    """Whether own ship must keep course and speed (Rule 17)."""
    return (types == EncounterType.CROSSING_STAND_ON) | (types == EncounterType.OVERTAKEN)


def risk_of_collision(
    dcpa_m: _Numbers,
    tcpa_s: _Numbers,
    range_m: _Numbers,
    own_speed_m_s: Float[Array, ""] | float,
    target_speed_m_s: _Numbers,
) -> Bool[Array, "*n"] | np.bool | bool:
    """Whether there is risk of collision (Rule 7) between ships under way and in sight."""
    near = (dcpa_m < RISK_DCPA_M) & (range_m <= VISIBILITY_M)
    soon = (tcpa_s > 0) & (tcpa_s <= RISK_TCPA_S)
    under_way = (target_speed_m_s >= STOPPED_M_S) & (own_speed_m_s >= STOPPED_M_S)
    return near & soon & under_way


def classify(
    bearing_rad: Float[Array, "*n"],
    aspect_rad: Float[Array, "*n"],
    own_faster: Bool[Array, "*n"] | bool = False,
    head_on: HeadOnLimits = EVALUATION_HEAD_ON,
) -> Int[Array, "*n"]:
    """The encounter type of two ships at risk of collision.

    Args:
        bearing_rad: The target's bearing from own ship's bow, in [-pi, pi].
        aspect_rad: Own ship's bearing from the target's bow, in [-pi, pi].
        own_faster: Decides who overtakes where each is abaft the other's beam.
        head_on: The limits of Rule 14.
    """
    from_abaft = jnp.abs(aspect_rad) > ABAFT_RAD  # own ship comes up from abaft the target's beam
    behind = jnp.abs(bearing_rad) > ABAFT_RAD
    ahead = jnp.maximum(jnp.abs(bearing_rad), jnp.abs(aspect_rad)) <= head_on.bearing_rad
    reciprocal = jnp.abs(wrap_angle(bearing_rad - aspect_rad)) <= head_on.course_rad
    crossing = jnp.where(
        bearing_rad >= 0, EncounterType.CROSSING_GIVE_WAY, EncounterType.CROSSING_STAND_ON
    )
    types = jnp.where(ahead & reciprocal, EncounterType.HEAD_ON, crossing)
    types = jnp.where(behind & ~(from_abaft & own_faster), EncounterType.OVERTAKEN, types)
    overtaking = from_abaft & (~behind | own_faster)
    return jnp.where(overtaking, EncounterType.OVERTAKING, types).astype(jnp.int32)


def classify_targets(
    position: Vector,
    velocity: Vector,
    course_rad: Float[Array, ""],
    head_on: HeadOnLimits = PILOT_HEAD_ON,
) -> Int[Array, " n"]:
    """The :class:`EncounterType` with every target if own ship were on a course.

    Args:
        position: The targets' positions relative to own ship [m].
        velocity: Their velocities over ground [m/s], in the same axes.
        course_rad: Own ship's course, clockwise from the y axis.
        head_on: The limits of Rule 14.
    """
    bearing = wrap_angle(direction(position) - course_rad)
    aspect = wrap_angle(direction(Vector(-position.x, -position.y)) - direction(velocity))
    return classify(bearing, aspect, head_on=head_on)
