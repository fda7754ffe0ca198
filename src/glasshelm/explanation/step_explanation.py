"""Everything that can be said of one decision, from one pass through the networks."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from glasshelm.env.observe import Observation
from glasshelm.explanation.coalitions import MAX_EXACT, ShapleyValues
from glasshelm.explanation.danger_zero import far_value
from glasshelm.explanation.quantities import (
    Intention,
    Sweep,
    attention_of,
    intentions,
    priorities,
    rudder_range,
    values_at,
)
from glasshelm.explanation.shapley import (
    MAX_PADDED_EXACT,
    leave_one_out,
    shapley_padded,
    value_function,
)
from glasshelm.networks.actors import Actor
from glasshelm.networks.critics import QValues, SubTaskCritic


class Explanation(eqx.Module):
    """The reasons of one decision (sections 4-5 of the paper); empty slots are 0.

    Attributes:
        present: Which slots hold a ship.
        value: Q of the decided rudder (Eq. 19); None without a critic.
        priority: Its gain over rudder 0 (Eq. 22); None without a critic.
        far: The critic's zero of danger: Q_ca of a ship far off; None without a critic.
        sweep: Q over the rudder range; None without a critic.
        attention: α of every slot (Eq. 23); None without an attention actor.
        intention: Eq. 24; None unless there are both a critic and attention.
        rudder_shapley: How much each ship moves the rudder (a fraction of the limit).
        leave_one_out: What each ship alone changes by not being there (the same unit).
        value_shapley: What each ship contributes to Q of the decision, NaN for more than
            :data:`~glasshelm.explanation.shapley.MAX_PADDED_EXACT` ships; None without a critic.
    """

    present: Bool[Array, " n"]
    value: QValues | None
    priority: QValues | None
    far: Float[Array, ""] | None
    sweep: Sweep | None
    attention: Float[Array, " n"] | None
    intention: Intention | None
    rudder_shapley: ShapleyValues
    leave_one_out: Float[Array, " n"]
    value_shapley: ShapleyValues | None


def explain(
    actor: Actor, critic: SubTaskCritic | None, observation: Observation, action: Float[Array, ""]
) -> Explanation:
    """Why ``action`` (a fraction of the rudder limit) in this observation.

    Pure and traceable, for one observation. The decided rudder, rudder 0 and
    the rudders of the sweep go through the critic as one batch.
    """
    present = observation.present
    attention = attention_of(actor, observation)
    rudder = value_function("rudder", actor, critic, observation, 1.0)
    moved_by = shapley_padded(rudder, present, MAX_EXACT, sampled=True)
    alone = leave_one_out(rudder, present.shape[-1])
    if critic is None:
        absent = (None, None, None, None, attention, None)
        return Explanation(present, *absent, moved_by, alone, None)
    sweep = rudder_range()
    both = jnp.stack([action, jnp.zeros_like(action)])
    values = values_at(critic, observation, jnp.concatenate([both, sweep]))
    decided, amidships = (QValues(values.waypoint[i], values.by_ship[i]) for i in (0, 1))
    priority = priorities(decided, amidships)
    worth = value_function("decision", actor, critic, observation, 1.0)
    return Explanation(
        present,
        decided,
        priority,
        far_value(critic, action),
        Sweep(sweep, QValues(values.waypoint[2:], values.by_ship[2:])),
        attention,
        None if attention is None else intentions(decided, priority, attention),
        moved_by,
        alone,
        shapley_padded(worth, present, MAX_PADDED_EXACT, sampled=False),
    )
