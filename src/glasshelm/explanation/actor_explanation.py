"""Why an actor's rudder, from one pass through its networks."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.env.observe import Observation
from glasshelm.explanation.coalitions import MAX_EXACT
from glasshelm.explanation.danger_zero import far_value
from glasshelm.explanation.quantities import (
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
from glasshelm.explanation.step_explanation import Explanation
from glasshelm.networks.actors import Actor
from glasshelm.networks.critics import QValues, SubTaskCritic


def explain_rudder(
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
