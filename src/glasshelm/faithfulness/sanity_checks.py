"""Does an explanation hold still when the scene does, and change when the pilot does?"""

import itertools
from collections.abc import Callable
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from glasshelm.core.geometry import Vector
from glasshelm.env.observe import LENGTH_M, SPEED_M_S, TARGET_FEATURES, Observation, target_row
from glasshelm.networks.actors import Actor, AttentionActor
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.networks.mlp import Mlp
from glasshelm.ship.nomoto import KNOT_M_S

#: An actor, a critic, or that there is none.
Network = TypeVar("Network")

#: Errors of AIS as navigators meet them: position [m] and each component of velocity [m/s].
POSITION_M = 10.0
VELOCITY_M_S = 0.1 * KNOT_M_S
#: Draws of which the worst counts.
DRAWS = 10

_DX, _DY, _VX, _VY = (TARGET_FEATURES.index(name) for name in ("dx", "dy", "vx", "vy"))


def perturb_sensors(observation: Observation, key: PRNGKeyArray) -> Observation:
    """The same scene through sensors that err: one offset a ship, the same in all five frames.

    Offsets are uniform in ± :data:`POSITION_M` and ± :data:`VELOCITY_M_S` on each
    axis; everything that follows from them (distance, CPA) is computed anew.
    """
    place_key, speed_key = jax.random.split(key)
    ships = observation.present.shape[-1]
    shift = jax.random.uniform(place_key, (ships, 1, 2), minval=-1.0, maxval=1.0) * POSITION_M
    speed_shift = (
        jax.random.uniform(speed_key, (ships, 1, 2), minval=-1.0, maxval=1.0) * VELOCITY_M_S
    )
    offset = observation.targets[..., (_DX, _DY)] * LENGTH_M + shift
    speed = observation.targets[..., (_VX, _VY)] * SPEED_M_S + speed_shift
    rows = target_row(Vector(offset[..., 0], offset[..., 1]), Vector(speed[..., 0], speed[..., 1]))
    return eqx.tree_at(lambda o: o.targets, observation, rows)


def sensitivity(
    attribute: Callable[[Observation], Float[Array, "e n"]],
    observation: Observation,
    key: PRNGKeyArray,
) -> Float[Array, " e"]:
    """max ‖e(s + ε) − e(s)‖ / ‖e(s)‖ over :data:`DRAWS` draws of the sensors' errors.

    Of every row that ``attribute`` gives; a jumpy pilot is not the explanation's fault, so
    let the rudder be one of them.
    """
    base = attribute(observation)
    others = jax.vmap(lambda draw: attribute(perturb_sensors(observation, draw)))(
        jax.random.split(key, DRAWS)
    )
    worst = jnp.linalg.norm(others - base, axis=-1).max(0)
    return worst / jnp.maximum(jnp.linalg.norm(base, axis=-1), 1e-9)


def randomise_weights(network: Network, seed: int, layers: int | None = None) -> Network:
    """The network with the weights of its top layers exchanged within each matrix, at random.

    ``layers`` are counted from the output down; None: all. Shapes and scales
    stay, what was learned is randomised (Adebayo et al. 2018). With one seed the layers that
    are randomised first are shuffled alike however many follow.
    """
    rank = {
        id(leaf): place
        for place, stage in enumerate(_from_output(network))
        for leaf in jax.tree.leaves(stage)
    }
    leaves, tree = jax.tree.flatten(network)
    rng = np.random.default_rng(seed)
    leaves_out = []
    for leaf in leaves:
        shuffled = rng.permutation(np.ravel(leaf)).reshape(leaf.shape)
        randomised = layers is None or rank[id(leaf)] < layers
        leaves_out.append(shuffled if randomised else np.asarray(leaf))
    return jax.tree.unflatten(tree, leaves_out)


def count_layers(network: Actor | SubTaskCritic | None) -> int:
    """The number of layers that there are to forget, one after the other."""
    return len(_from_output(network))


def _from_output(network: Any) -> list[tuple[Any, ...]]:
    """Weights and biases layer by layer from the output down; what lies side by side together.

    Of an actor first the head, then the encoders and the attention score.
    """
    if network is None:
        return []
    if isinstance(network, SubTaskCritic):
        stages: list[tuple[Mlp, ...]] = [(network.of_waypoint, network.of_target)]
    else:
        encoders = (network.encode_waypoint, network.encode_target)
        score = (network.score,) if isinstance(network, AttentionActor) else ()
        stages = [(network.head,), (*encoders, *score)]
    found = []
    for side_by_side in stages:
        layers = [list(zip(m.weights, m.biases, strict=True))[::-1] for m in side_by_side]
        found += [tuple(filter(None, same)) for same in itertools.zip_longest(*layers)]
    return found


def spearman(a: Float[Array, " n"], b: Float[Array, " n"]) -> Float[Array, ""]:
    """Spearman's ρ by mean ranks; 0 where one has only ties."""

    def ranks(x: Float[Array, " n"]) -> Float[Array, " n"]:
        above = (x[:, None] > x[None, :]).sum(1) + ((x[:, None] == x[None, :]).sum(1) - 1) / 2
        return above - above.mean()

    ra, rb = ranks(a), ranks(b)
    return (ra * rb).sum() / jnp.maximum(jnp.sqrt((ra**2).sum() * (rb**2).sum()), 1e-9)
