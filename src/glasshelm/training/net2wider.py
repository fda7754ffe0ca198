"""Widen the layers of an actor without changing what it computes (Net2WiderNet).

Chen, Goodfellow and Shlens 2016, arXiv:1511.05641: every new unit is a copy of an old
one, and the weights from that unit to the next layer are divided among the copies, at
random and for each unit of the next layer anew. The copies then learn apart, so a
training continues with more capacity from where it was.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from glasshelm.networks.actors import Actor, ActorSizes, AttentionActor
from glasshelm.networks.mlp import Mlp

#: Which old unit each new unit is a copy of.
Origins = Int[Array, " units"]


def widen(actor: Actor, sizes: ActorSizes, key: PRNGKeyArray) -> Actor:
    """The actor with layers of ``sizes`` and the same rudder.

    Raises:
        ValueError: A layer would become narrower, or there are more or fewer layers.
    """
    middle_key, waypoint_key, target_key, head_key, score_key = jax.random.split(key, 5)
    width = actor.encode_target.biases[-1].size
    middle = _origins(width, sizes.encoder[-1], middle_key)  # the encoders are added there
    parts = [
        ("encode_waypoint", sizes.encoder[:-1], waypoint_key, None, middle),
        ("encode_target", sizes.encoder[:-1], target_key, None, middle),
        ("head", sizes.head, head_key, middle, None),
    ]
    if isinstance(actor, AttentionActor):
        parts.append(("score", sizes.attention, score_key, None, None))
    for name, hidden, part_key, inputs, outputs in parts:
        wide = _widened(getattr(actor, name), hidden, part_key, inputs, outputs)
        actor = eqx.tree_at(lambda a, name=name: getattr(a, name), actor, wide)
    return actor


def _widened(
    mlp: Mlp,
    hidden: tuple[int, ...],
    key: PRNGKeyArray,
    inputs: Origins | None,
    outputs: Origins | None,
) -> Mlp:
    """The network with wider hidden layers, its inputs and outputs copies of the old ones."""
    if len(hidden) != len(mlp.biases) - 1:
        raise ValueError(f"{len(mlp.biases) - 1} hidden layers cannot become {len(hidden)}")
    origins_key, share_key = jax.random.split(key)
    keys = jax.random.split(origins_key, len(hidden) or 1)
    origins = [jnp.arange(mlp.weights[0].shape[0]) if inputs is None else inputs]
    for bias, units, k in zip(mlp.biases, hidden, keys, strict=False):
        origins.append(_origins(bias.size, units, k))
    origins.append(jnp.arange(mlp.biases[-1].size) if outputs is None else outputs)
    weights = tuple(
        _shared(weight, before, k)[:, after]
        for weight, before, after, k in zip(
            mlp.weights,
            origins[:-1],
            origins[1:],
            jax.random.split(share_key, len(mlp.weights)),
            strict=True,
        )
    )
    biases = tuple(bias[after] for bias, after in zip(mlp.biases, origins[1:], strict=True))
    return eqx.tree_at(lambda m: (m.weights, m.biases), mlp, (weights, biases))


def _origins(units: int, wide: int, key: PRNGKeyArray) -> Origins:
    if wide < units:
        raise ValueError(f"a layer of {units} units cannot become one of {wide}")
    return jnp.concatenate([jnp.arange(units), jax.random.randint(key, (wide - units,), 0, units)])


def _shared(
    weight: Float[Array, "i o"], origins: Origins, key: PRNGKeyArray
) -> Float[Array, "w o"]:
    """Rows for the copies: random shares of the row of their origin that add up to it."""
    share = jax.random.uniform(key, (origins.size, weight.shape[1]), minval=0.5)
    whole = jnp.zeros_like(weight).at[origins].add(share)
    return weight[origins] * share / whole[origins]
