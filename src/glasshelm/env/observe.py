"""What the pilot sees (Eq. 10-12): waypoint and targets relative to own ship, five frames deep.

Positions and velocities are in own ship's body frame (starboard, ahead), so an
observation does not change when the whole scene is moved or turned.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from glasshelm.core.geometry import (
    Vector,
    closest_approach,
    direction,
    norm,
    offset,
    to_body,
    velocity,
    wrap_angle,
)
from glasshelm.encounters.types import Motion
from glasshelm.ship.nomoto import KNOT_M_S, ShipState

FRAMES = 5  # the current one and four past (below Eq. 12)

LENGTH_M = 20_000.0
DISTANCE_M = LENGTH_M * 2**0.5
ANGLE_RAD = jnp.pi
SPEED_M_S = 20 * KNOT_M_S
TIME_S = 1000.0

#: The columns of Eq. 10, in order.
WAYPOINT_FEATURES = ("dx", "dy", "bearing")
#: The columns of Eq. 11, in order.
TARGET_FEATURES = (
    "dx", "dy", "bearing", "vx", "vy", "distance", "cpa_dx", "cpa_dy", "dcpa", "tcpa",
)  # fmt: skip


class ObservationFrame(eqx.Module):
    """One frame of the observation, normalised: s_wp (Eq. 10) and s_oth (Eq. 11)."""

    waypoint: Float[Array, "3"]
    targets: Float[Array, "n 10"]
    present: Bool[Array, " n"]


class Observation(eqx.Module):
    """What networks read: the current frame and the past ones, newest first (Eq. 12)."""

    waypoint: Float[Array, "*batch frames 3"]
    targets: Float[Array, "*batch n frames 10"]
    present: Bool[Array, "*batch n"]


def observe(
    own: ShipState, waypoint: Vector, motion: Motion, present: Bool[Array, " n"]
) -> ObservationFrame:
    """The normalised frame of one instant (Eq. 10-11).

    Args:
        own: Own ship.
        waypoint: Where it is going (east, north) [m].
        motion: The targets.
        present: Which slots hold a target.

    Returns:
        The frame; absent slots are zero.
    """
    to_waypoint = to_body(offset(own, waypoint), own.heading_rad)
    s_wp = jnp.stack(
        [
            to_waypoint.x / LENGTH_M,
            to_waypoint.y / LENGTH_M,
            direction(to_waypoint) / ANGLE_RAD,
        ]
    )
    s_oth = target_row(*relative_motion(own, motion))
    return ObservationFrame(s_wp, jnp.where(present[:, None], s_oth, 0.0), present)


def relative_motion(own: ShipState, motion: Motion) -> tuple[Vector, Vector]:
    """Positions [m] and velocities [m/s] of targets relative to own ship, in its body frame."""
    own_v = velocity(own.heading_rad, own.speed_m_s)
    target_v = velocity(motion.course_rad, motion.speed_m_s)
    relative_v = Vector(target_v.x - own_v.x, target_v.y - own_v.y)
    return to_body(offset(own, motion), own.heading_rad), to_body(relative_v, own.heading_rad)


def target_row(position: Vector, relative_v: Vector) -> Float[Array, "*n 10"]:
    """One normalised row of Eq. 11 a target: her place [m] and motion [m/s] in the body frame."""
    cpa = closest_approach(position, relative_v)
    return jnp.stack(
        [
            position.x / LENGTH_M,
            position.y / LENGTH_M,
            direction(position) / ANGLE_RAD,
            relative_v.x / SPEED_M_S,
            relative_v.y / SPEED_M_S,
            norm(position) / DISTANCE_M,
            cpa.position.x / LENGTH_M,
            cpa.position.y / LENGTH_M,
            cpa.dcpa_m / DISTANCE_M,
            cpa.tcpa_s / TIME_S,
        ],
        axis=-1,
    )


def empty_observation(slots: int) -> Observation:
    """The history before the first frame."""
    return Observation(
        jnp.zeros((FRAMES, 3)), jnp.zeros((slots, FRAMES, 10)), jnp.zeros(slots, bool)
    )


def push_frame(
    history: Observation, sight: ObservationFrame, first: Bool[Array, ""] | bool
) -> Observation:
    """The history with a new frame in front.

    On the first frame of an episode, and for a target that was not there a
    moment ago, all five frames are the new one: a history of zeros never
    occurs at sea.
    """
    new = jnp.logical_not(history.present) | first
    waypoint = in_front(sight.waypoint, history.waypoint, jnp.asarray(first))
    return Observation(waypoint, in_front(sight.targets, history.targets, new), sight.present)


def in_front(
    row: Float[Array, "*b d"], frames: Float[Array, "*b frames d"], new: Bool[Array, "*b"]
) -> Float[Array, "*b frames d"]:
    """Frames with one more in front and the oldest gone; all of them this one where ``new``."""
    shifted = jnp.concatenate([row[..., None, :], frames[..., :-1, :]], axis=-2)
    return jnp.where(new[..., None, None], row[..., None, :], shifted)


def waypoint_bearing_rad(sight_waypoint: Float[Array, "*b 3"]) -> Float[Array, "*b"]:
    """dθ_wp [rad] read back from a frame's waypoint row."""
    return wrap_angle(sight_waypoint[..., 2] * ANGLE_RAD)
