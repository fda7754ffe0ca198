"""Everything that can be said of one decision, from one pass through the networks."""

from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from glasshelm.env.observe import Observation
from glasshelm.explain.attention import attention_of
from glasshelm.explain.coalitions import MAX_EXACT, ShapleyValues
from glasshelm.explain.danger_zero import far_value
from glasshelm.explain.intention import Intention, intentions
from glasshelm.explain.priority import priorities
from glasshelm.explain.shapley import (
    MAX_PADDED_EXACT,
    leave_one_out,
    shapley_padded,
    value_function,
)
from glasshelm.explain.sweep import RUDDERS, Sweep, rudder_range
from glasshelm.explain.values import pick, values_at
from glasshelm.networks.actors import Actor
from glasshelm.networks.critics import QValues, SubTaskCritic


class Explanation(eqx.Module):
    """The reasons of one decision (sections 4-5 of the paper); empty slots are 0.

    ``value`` is Q of the decided rudder (Eq. 19), ``priority`` its gain over
    rudder 0 (Eq. 22), ``far`` the head's zero of danger, ``sweep`` Q over the
    rudder range: ``None`` without a critic. ``attention`` is Eq. 23: ``None``
    unless the actor has it. ``intention`` is Eq. 24 and needs both. ``moves`` shares
    the rudder (a fraction of the limit) out among the ships, ``left_out`` is what each
    changes by not being there; ``worth`` shares out Q of the decision among few
    ships, not a number for more (:mod:`glasshelm.explain.shapley`).
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
    actor: Actor,
    critic: SubTaskCritic | None,
    observation: Observation,
    action: Float[Array, ""],
    rudders: int = RUDDERS,
) -> Explanation:
    """Why ``action`` (a fraction of the rudder limit) in this observation.

    Pure and traceable, for one observation. The decided rudder, rudder 0 and
    the ``rudders`` of the sweep go through the critic as one batch.
    """
    attention, slots = attention_of(actor, observation), observation.present.shape[-1]
    rudder = value_function("rudder", actor, critic, observation, 1.0)
    moves, left_out = (
        shapley_padded(rudder, observation.present, MAX_EXACT, True),
        leave_one_out(rudder, slots),
    )
    if critic is None:
        nothing = (None, None, None, None, attention, None)
        return Explanation(observation.present, *nothing, moves, left_out, None)
    sweep = rudder_range(rudders)
    values = values_at(
        critic, observation, jnp.concatenate([jnp.stack([action, jnp.zeros_like(action)]), sweep])
    )
    value = pick(values, 0)
    priority = priorities(value, pick(values, 1))
    return Explanation(
        observation.present,
        value,
        priority,
        far_value(critic, action),
        Sweep(sweep, QValues(values.waypoint[2:], values.by_ship[2:])),
        attention,
        None if attention is None else intentions(value, priority, attention),
        moves,
        left_out,
        shapley_padded(
            value_function("decision", actor, critic, observation, 1.0),
            observation.present,
            MAX_PADDED_EXACT,
            sampled=False,
        ),
    )


def cut(explanation: Explanation, slots: int) -> Explanation:
    """The explanation of the first ``slots`` slots: undoes the padding of an observation."""
    explanation = eqx.tree_at(_by_slot, explanation, replace_fn=lambda x: x[..., :slots])
    return eqx.tree_at(_by_pair, explanation, replace_fn=lambda x: x[:slots, :slots])


def _by_slot(e: Explanation) -> list[Any]:
    """The arrays whose last axis is the slots."""
    values = (e.value, e.priority, None if e.sweep is None else e.sweep.value)
    found = [e.present, *(v.by_ship for v in values if v is not None)]
    if e.attention is not None:
        found.append(e.attention)
    if e.intention is not None:
        found += [e.intention.increment, e.intention.level]
    for shares in (e.rudder_shapley, e.value_shapley):
        found += [] if shares is None else [shares.by_ship, shares.error]
    return [*found, e.leave_one_out]


def _by_pair(e: Explanation) -> list[Any]:
    """The arrays whose last two axes are the slots."""
    return [shares.pairs for shares in (e.rudder_shapley, e.value_shapley) if shares is not None]
