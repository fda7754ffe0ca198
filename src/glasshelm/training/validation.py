"""How good is an actor: batched voyages through a fixed set of random encounters."""

import dataclasses
from collections.abc import Callable
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from glasshelm.core.geometry import wrap_angle
from glasshelm.encounters.random_encounters import PAPER, RandomEncounters
from glasshelm.encounters.types import Encounter
from glasshelm.env.observe import Observation
from glasshelm.env.rewards import SUB_TASKS
from glasshelm.env.step import EnvState, reset, step
from glasshelm.networks.ship_batch import Padded
from glasshelm.ship.course_reversals import WEAVING, Reversals
from glasshelm.ship.nomoto import ShipParams
from glasshelm.training.exploration import Noise, NoiseSettings, explore, quiet
from glasshelm.training.losses import CriticOf
from glasshelm.training.vector_env import draw_encounters

#: An actor, or any other pytree that turns a batch of observations into rudders.
Steers = Callable[[Observation], Float[Array, " w"]]

#: The same with a memory: observations and memory -> rudders and memory.
Remembers = Callable[[Observation, Any], tuple[Float[Array, " w"], Any]]

#: One value or return by sub-task, of many states.
Columns = Float[Array, "n 2"]

#: The fixed evaluation set is drawn with this seed, whatever the training's.
EVALUATION_SEED = 20_240_501


class Voyages(eqx.Module):
    """What happened in each encounter of a set, over a short and a long voyage.

    ``margin`` is the worst Eq. 13 (unclipped) of any ship, ``range_m`` the
    nearest centre distance; index 0: the first ``short`` steps, 1: all.
    Returns are undiscounted, over the first ``short`` steps. ``reversals`` counts
    the alterations taken back, of all steps (:mod:`glasshelm.ship.course_reversals`).
    """

    margin: Float[Array, "2 w"]
    range_m: Float[Array, "2 w"]
    return_by_task: Float[Array, "w 2"]
    rudder: Float[Array, " w"]
    reversals: Int[Array, " w"]
    ships: Int[Array, " w"]


@dataclasses.dataclass(frozen=True)
class Score:
    """Rates and means over an evaluation set. ``by_ships``: long intrusion rate by number of ships.

    An intrusion is a ship inside the domain (Eq. 13 > 0) at any step, a
    collision a centre distance below own ship's length. ``reversals`` is their mean
    number a voyage, ``weaving`` the share of voyages with ``WEAVING`` or more.
    """

    intrusions: float
    intrusions_long: float
    collisions: float
    collisions_long: float
    return_waypoint: float
    return_collision: float
    rudder: float
    reversals: float
    weaving: float
    by_ships: tuple[float | None, ...]

    @property
    def total(self) -> float:
        return self.return_waypoint + self.return_collision

    @property
    def fault(self) -> float:
        """What the pilot kept is chosen by, lower is better: a collision counts as ten intrusions.

        Three points of return (of about 50) count as one intrusion in a hundred, and so do
        ten voyages of weaving.
        """
        rates = self.intrusions + self.intrusions_long
        rates += 10.0 * (self.collisions + self.collisions_long)
        return rates - self.total / 300.0 + 0.1 * self.weaving


def evaluation_set(
    ship: ShipParams, size: int = 256, settings: RandomEncounters = PAPER
) -> Encounter:
    """The fixed set of random encounters, the same for every training."""
    return draw_encounters(jax.random.key(EVALUATION_SEED), size, ship, settings)


class _Forgetful(eqx.Module):
    """An actor as something that has a memory and leaves it as it is."""

    actor: Steers

    def __call__(self, observation: Observation, memory: Any) -> tuple[Float[Array, " w"], Any]:
        return self.actor(observation), memory


def sail_set(
    actor: Steers, encounters: Encounter, ship: ShipParams, short: int = 240, long: int = 480
) -> Voyages:
    """Sail every encounter under the actor, without exploration."""
    return sail_remembering(_Forgetful(actor), (), encounters, ship, short, long)


@partial(jax.jit, static_argnames=("short", "long"))
def sail_remembering(
    helm: Remembers,
    memory: Any,
    encounters: Encounter,
    ship: ShipParams,
    short: int = 240,
    long: int = 480,
) -> Voyages:
    """:func:`sail_set` for what carries a memory from one decision to the next."""

    def go(carry: tuple[EnvState, Any, Reversals, Voyages], number: Int[Array, ""]):
        state, memory, turns, so_far = carry
        action, memory = helm(state.observation, memory)
        out = jax.vmap(lambda e, s, a: step(e, s, a * ship.rudder_limit_rad, ship))(
            encounters, state, action
        )
        counts = jnp.array([True, True]).at[0].set(number < short)[:, None]
        worst = jnp.where(encounters.present, out.margin, -jnp.inf).max(-1, initial=-jnp.inf)
        nearest = jnp.where(encounters.present, out.range_m, jnp.inf).min(-1, initial=jnp.inf)
        change = wrap_angle(out.state.own.heading_rad - state.own.heading_rad)
        turns = turns.after(change)
        return (
            out.state,
            memory,
            turns,
            Voyages(
                jnp.where(counts, jnp.maximum(so_far.margin, worst), so_far.margin),
                jnp.where(counts, jnp.minimum(so_far.range_m, nearest), so_far.range_m),
                so_far.return_by_task + counts[0] * out.reward.by_task,
                so_far.rudder + jnp.abs(action) / long,
                turns.count,
                so_far.ships,
            ),
        ), None

    size = encounters.present.shape[0]
    start = Voyages(
        jnp.full((2, size), -jnp.inf),
        jnp.full((2, size), jnp.inf),
        jnp.zeros((size, 2)),
        jnp.zeros(size),
        jnp.zeros(size, jnp.int32),
        encounters.present.sum(-1),
    )
    states = jax.vmap(lambda e: reset(e, ship))(encounters)
    carry = (states, memory, Reversals.none(size), start)
    (*_, voyages), _ = jax.lax.scan(go, carry, jnp.arange(long))
    return voyages


def score(voyages: Voyages, loa_m: float) -> Score:
    """Rates and means of a set of voyages."""
    intruded = np.asarray(voyages.margin) > 0
    collided = np.asarray(voyages.range_m) < loa_m
    ships = np.asarray(voyages.ships)
    returns = np.asarray(voyages.return_by_task).mean(0)
    slots = int(ships.max(initial=0))
    short, long = (float(x) for x in intruded.mean(-1))
    short_collided, long_collided = (float(x) for x in collided.mean(-1))
    return Score(
        intrusions=short,
        intrusions_long=long,
        collisions=short_collided,
        collisions_long=long_collided,
        return_waypoint=float(returns[0]),
        return_collision=float(returns[1]),
        rudder=float(np.asarray(voyages.rudder).mean()),
        reversals=float(np.asarray(voyages.reversals).mean()),
        weaving=float((np.asarray(voyages.reversals) >= WEAVING).mean()),
        by_ships=tuple(
            float(intruded[1][ships == n].mean()) if (ships == n).any() else None
            for n in range(slots + 1)
        ),
    )


class Agreement(eqx.Module):
    """How well the critics' values agree with the returns that followed, by sub-task.

    Correlation, root mean square error and spread of the discounted returns,
    over all states of the short voyages.
    """

    correlation: Float[Array, "2"]
    error: Float[Array, "2"]
    spread: Float[Array, "2"]

    def numbers(self) -> dict[str, float]:
        """The same by name, for a log."""
        return {
            f"{task.name.lower()}_{name}": float(getattr(self, name)[task])
            for task in SUB_TASKS
            for name in ("correlation", "error", "spread")
        }


@partial(jax.jit, static_argnames=("short", "long", "lapses"))
def agreement(
    actor: Steers,
    critic: CriticOf,
    encounters: Encounter,
    ship: ShipParams,
    discount: float | Float[Array, ""],
    short: int = 240,
    long: int = 480,
    lapses: NoiseSettings | None = None,
) -> Agreement:
    """Q(s, a) against the discounted return of the rest of the voyage, sub-task by sub-task.

    a is π(s), or with ``lapses`` what this exploration makes of it, as it goes on to do.
    Values are taken in the first ``short`` steps; what would follow after
    ``long`` is missing from the returns.
    """

    def go(carry: tuple[EnvState, Noise], number: Int[Array, ""]):
        state, noise = carry
        action = actor(state.observation)
        if lapses is not None:
            key = jax.random.fold_in(jax.random.key(EVALUATION_SEED), number)
            action, noise = explore(noise, action, jnp.zeros(()), lapses, key)
        values = critic(state.observation, action, Padded(state.observation.present)).by_task
        out = jax.vmap(lambda e, s, a: step(e, s, a * ship.rudder_limit_rad, ship))(
            encounters, state, action
        )
        return (out.state, noise), (values, out.reward.by_task)

    def back(after: Float[Array, "w 2"], reward: Float[Array, "w 2"]):
        value = reward + discount * after
        return value, value

    states = jax.vmap(lambda e: reset(e, ship))(encounters)
    start = (states, quiet(encounters.present.shape[0]))
    _, (values, rewards) = jax.lax.scan(go, start, jnp.arange(long))
    _, returns = jax.lax.scan(back, jnp.zeros_like(rewards[0]), rewards, reverse=True)
    q, g = values[:short].reshape(-1, 2), returns[:short].reshape(-1, 2)
    return Agreement(correlation(q, g), jnp.sqrt(((q - g) ** 2).mean(0)), g.std(0))


def correlation(a: Columns, b: Columns) -> Float[Array, "2"]:
    """Pearson's r of each column; 0 where one of them is constant."""
    da, db = a - a.mean(0), b - b.mean(0)
    return (da * db).mean(0) / jnp.maximum(da.std(0) * db.std(0), 1e-9)
