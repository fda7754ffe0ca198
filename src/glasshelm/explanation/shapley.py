"""Each ship's part in a decision: Shapley values (docs/explanation/explanations.md).

The actor takes any set of ships, so a ship is left out by not being there: no
baseline, no padding value stands in for her. Three games, three questions:

* ``rudder``    v(S) = δ_lim π(s_S): how far does each ship move the rudder? [rad, + starboard]
* ``decision``  v(S) = Q(s_N, π(s_S)): what is it worth, in the scene as it is, to know of her?
* ``contrast``  v(S) = Q(s_S, a) − Q(s_S, 0): Eq. 22, whose Shapley value is the priority itself.

For a critic that is a sum over ships (Eq. 19) the Shapley value of Q(s_S, a) at a
fixed action is Q_ca(s_i, a): the danger of the paper is one.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from glasshelm.core.errors import InputError
from glasshelm.env.observe import Observation
from glasshelm.explanation.coalitions import MAX_EXACT, ShapleyValues, coalitions, exact_from_worths
from glasshelm.networks.actors import Actor
from glasshelm.networks.critics import SubTaskCritic

Game = Literal["rudder", "decision", "contrast"]
#: The worth of one coalition: which ships are in it -> v(S), or a pytree of several worths, which
#: are shared out each for itself from one pass over the coalitions.
Worth = Callable[[Bool[Array, " n"]], Any]

#: Permutations drawn, each also read backwards, where there are too many ships for all coalitions.
PERMUTATIONS = 128
#: The same in every frame of a voyage.
LIVE_PERMUTATIONS = 32
#: So many slots are taken as they are, empty ones included; and so many ships share out Q live.
MAX_PADDED_EXACT = 8


def value_function(
    game: Game,
    actor: Actor,
    critic: SubTaskCritic | None,
    observation: Observation,
    rudder_limit_rad: float | Float[Array, ""],
) -> Worth:
    """v(S) of one of the games. InputError where it needs a critic and there is none."""

    def only(members: Bool[Array, " n"]) -> Observation:
        return eqx.tree_at(lambda o: o.present, observation, observation.present & members)

    if game == "rudder":
        return lambda members: actor(only(members)) * rudder_limit_rad
    if critic is None:
        raise InputError(f"the game {game!r} needs a critic, and this pilot has none")
    if game == "decision":
        return lambda members: critic(observation, actor(only(members))).total
    action = actor(observation)

    def contrast(members: Bool[Array, " n"]) -> Float[Array, ""]:
        scene = only(members)
        return critic(scene, action).total - critic(scene, jnp.zeros_like(action)).total

    return contrast


def exact_shapley(worth: Worth, ships: int) -> Any:
    """:class:`ShapleyValues` of each worth, from all 2ⁿ coalitions of the first ``ships`` slots.

    ``vmap`` runs over the membership alone, so what does not depend on it
    (each ship's encoding, each pair's attention score) is computed once.
    """
    return jax.tree.map(exact_from_worths, jax.vmap(worth)(jnp.asarray(coalitions(ships))))


def sampled_shapley(
    worth: Worth, ships: int, seed: int = 0, permutations: int = PERMUTATIONS
) -> Any:
    """:class:`ShapleyValues` of each worth from random orders of joining, each also read backwards.

    ``error`` is the standard error of the mean over the pairs of orders (antithetic);
    ``pairs`` are not sampled and are 0. The shares still add up to v(N) − v(∅).
    """

    def by_joining(rank: Int[Array, " n"]) -> Any:
        """What each ship adds when ships join in the order of ``rank``."""
        steps = rank[None, :] < jnp.arange(ships + 1)[:, None]
        return jax.tree.map(lambda w: jnp.diff(w)[rank], jax.vmap(worth)(steps))

    def order(rank: Int[Array, " n"]) -> Any:
        both = by_joining(rank), by_joining(ships - 1 - rank)
        return jax.tree.map(lambda one, other: (one + other) / 2, *both)

    def shares(found: Float[Array, "k n"], none: Array, everyone: Array) -> ShapleyValues:
        error = found.std(0, ddof=1) / np.sqrt(permutations)
        return ShapleyValues(none, everyone, found.mean(0), jnp.zeros((ships, ships)), error)

    found = jax.lax.map(order, jnp.asarray(_ranks(ships, seed, permutations)))
    everyone = jnp.ones(ships, bool)
    return jax.tree.map(shares, found, worth(~everyone), worth(everyone))


@lru_cache
def _ranks(ships: int, seed: int, permutations: int) -> Int[np.ndarray, "k n"]:
    """Random orders of joining, each as the rank of every ship."""
    return np.random.default_rng(seed).permuted(
        np.tile(np.arange(ships, dtype=np.int32), (permutations, 1)), axis=1
    )


def shapley_padded(worth: Worth, present: Bool[Array, " n"], most: int, sampled: bool) -> Any:
    """Shares inside a program of any number of slots, some of them empty.

    Exact for up to ``most`` ships; beyond, ``sampled`` in 2 x :data:`LIVE_PERMUTATIONS` orders
    or not a number. Only the branch that is needed is computed, unless it is vmapped.
    """
    slots = present.shape[0]
    if slots <= MAX_PADDED_EXACT:  # an empty slot is a player who never adds anything
        return exact_shapley(worth, slots)
    first = jnp.argsort(~present, stable=True)[:most]
    one, two = jnp.zeros(slots), jnp.zeros((slots, slots))

    def few() -> Any:
        def among(members: Bool[Array, " m"]) -> Any:
            return worth(jnp.zeros(slots, bool).at[first].set(members))

        def spread(found: ShapleyValues) -> ShapleyValues:
            pairs = two.at[first[:, None], first[None, :]].set(found.pairs)
            return ShapleyValues(
                found.none, found.all, one.at[first].set(found.by_ship), pairs, one
            )

        found = exact_shapley(among, first.shape[0])
        return jax.tree.map(spread, found, is_leaf=lambda x: isinstance(x, ShapleyValues))

    def many() -> Any:
        if sampled:
            return sampled_shapley(worth, slots, permutations=LIVE_PERMUTATIONS)
        no = jnp.full((), jnp.nan)
        unknown = ShapleyValues(no, no, one + no, two + no, one)
        return jax.tree.map(lambda _: unknown, jax.eval_shape(worth, present))

    return jax.lax.cond(present.sum() <= most, few, many)


def leave_one_out(worth: Worth, ships: int) -> Any:
    """v(N) − v(N∖i): what changes when one ship alone is left out."""
    everyone = jnp.ones(ships, bool)
    without = jax.vmap(worth)(~jnp.eye(ships, dtype=bool))
    return jax.tree.map(lambda whole, others: whole - others, worth(everyone), without)


def shapley_by_ship(
    game: Game,
    actor: Actor,
    critic: SubTaskCritic | None,
    observation: Observation,
    rudder_limit_rad: float,
) -> ShapleyValues:
    """Each ship's share of a decision, slot by slot; empty slots have none.

    For one observation on the host. Exact up to
    :data:`~glasshelm.explanation.coalitions.MAX_EXACT` ships; beyond, from 2 x
    :data:`PERMUTATIONS` orders of a fixed key, with ``error``. One program is compiled for each
    number of ships.
    """
    here = np.flatnonzero(np.asarray(observation.present))
    scene = Observation(
        jnp.asarray(observation.waypoint),
        jnp.asarray(np.asarray(observation.targets)[here]),
        jnp.ones(len(here), bool),
    )
    found = _program(game, actor, critic, scene, jnp.float32(rudder_limit_rad))
    slots = len(np.asarray(observation.present))
    places = np.ix_(here, here)
    by_ship, error = np.zeros(slots, np.float32), np.zeros(slots, np.float32)
    pairs = np.zeros((slots, slots), np.float32)
    by_ship[here], error[here], pairs[places] = found.by_ship, found.error, found.pairs
    return ShapleyValues(found.none, found.all, *(jnp.asarray(x) for x in (by_ship, pairs, error)))


@eqx.filter_jit
def _program(
    game: Game,
    actor: Actor,
    critic: SubTaskCritic | None,
    scene: Observation,
    rudder_limit_rad: Float[Array, ""],
) -> ShapleyValues:
    ships = scene.present.shape[0]
    worth = value_function(game, actor, critic, scene, rudder_limit_rad)
    if ships <= MAX_EXACT:
        return exact_shapley(worth, ships)
    return sampled_shapley(worth, ships)
