"""The zero of danger: what the collision head says of a ship that is no danger at all.

A critic trained on the summed reward leaves the zero of Q_ca free by a
constant (docs/explanation/paper.md); this reference lets a page draw "no danger" where the
head itself puts it.
"""

import math

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.core.geometry import Vector
from glasshelm.encounters.types import Motion
from glasshelm.env.observe import FRAMES, LENGTH_M, Observation, ObservationFrame, observe
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.ship.nomoto import KNOT_M_S, ShipState

RANGE_M = 20_000.0
SPEED_M_S = 10 * KNOT_M_S
FRAME_S = 5.0


def far_ship() -> Observation:
    """One ship 20 km astern, opening at 20 kn: both ships at 10 kn on opposite courses, steady."""

    def frame(age_s: Float[Array, ""]) -> ObservationFrame:
        own = ShipState.steady(0.0, -SPEED_M_S * age_s, 0.0, SPEED_M_S)
        one = jnp.ones(1)
        there = Motion(
            0.0 * one,
            (-RANGE_M + SPEED_M_S * age_s) * one,
            math.pi * one,
            SPEED_M_S * one,
            0.0 * one,
            one > 0,
        )
        return observe(own, Vector(jnp.zeros(()), jnp.asarray(LENGTH_M)), there, there.present)

    frames = jax.vmap(frame)(FRAME_S * jnp.arange(FRAMES))
    return Observation(frames.waypoint, frames.targets.swapaxes(0, 1), frames.present[0])


def far_value(critic: SubTaskCritic, action: Float[Array, ""]) -> Float[Array, ""]:
    """Q_ca of :func:`far_ship` at the decided action: the head's own zero of danger."""
    return critic(far_ship(), action).by_ship[0]
