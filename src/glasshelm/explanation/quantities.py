"""The quantities of one decision: values (Eq. 19), priorities (22), attention (23), intention (24).

Actions are rudders as fractions of the limit.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.env.observe import Observation
from glasshelm.networks.actors import Actor, AttentionActor
from glasshelm.networks.critics import QValues, SubTaskCritic

SWEEP_RUDDERS = 21  # from hard port to hard starboard, rudder 0 among them


class Intention(eqx.Module):
    """Eq. 24 in both readings, one value a slot.

    ``level`` is Q_ca(s_i, a)·α_i (the preprint); ``increment`` is
    (Q_ca(s_i, a) − Q_ca(s_i, 0))·α_i (the journal version, the default reading).
    """

    increment: Float[Array, " n"]
    level: Float[Array, " n"]


class Sweep(eqx.Module):
    """Actions [k] over the whole rudder range, and the values of each: [k] and [k, n]."""

    action: Float[Array, " k"]
    value: QValues


def values_at(
    critic: SubTaskCritic, observation: Observation, actions: Float[Array, " k"]
) -> QValues:
    """Q_wp(s, a) [k] and Q_ca(s_i, a) [k, n] of every action (Eq. 19).

    The part of each head's first layer that does not see the action is computed once for all.
    """
    return jax.vmap(lambda action: critic(observation, action))(actions)


def rudder_range(rudders: int = SWEEP_RUDDERS) -> Float[Array, " k"]:
    """Evenly spaced actions from hard port (−1) to hard starboard (+1)."""
    return jnp.linspace(-1.0, 1.0, rudders)


def priorities(decided: QValues, amidships: QValues) -> QValues:
    """p_wp = Q_wp(s, a) − Q_wp(s, 0) and, a ship, p_i = Q_ca(s_i, a) − Q_ca(s_i, 0) (Eq. 22).

    Eq. 22 prints Q_wp in p_oth; Q_ca is meant (docs/explanation/paper.md). All are 0 where the
    decided rudder is 0.
    """
    return jax.tree.map(jnp.subtract, decided, amidships)


def attention_of(actor: Actor, observation: Observation) -> Float[Array, " n"] | None:
    """α of every slot (Eq. 23): sums to 1 over the ships present; None without attention."""
    return actor.attention(observation) if isinstance(actor, AttentionActor) else None


def intentions(value: QValues, priority: QValues, attention: Float[Array, " n"]) -> Intention:
    """Intention from the values and priorities of the decided rudder and the attention (Eq. 24)."""
    return Intention(priority.by_ship * attention, value.by_ship * attention)
