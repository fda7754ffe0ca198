"""Q sub-task by sub-task and ship by ship (Eq. 19), for one rudder or many at once."""

import jax
from jaxtyping import Array, Float

from glasshelm.env.observe import Observation
from glasshelm.networks.critics import QValues, SubTaskCritic


def values_at(
    critic: SubTaskCritic, observation: Observation, actions: Float[Array, " k"]
) -> QValues:
    """Q_wp(s, a) [k] and Q_ca(s_i, a) [k, n] of every action (Eq. 19).

    ``actions`` are fractions of the rudder limit. The part of each head's first
    layer that does not see the action is computed once for all of them.
    """
    return jax.vmap(lambda action: critic(observation, action))(actions)


def pick(values: QValues, index: int) -> QValues:
    """The values of one of the actions of :func:`values_at`."""
    return QValues(values.waypoint[index], values.by_ship[index])
