"""Many worlds at once that never stop: encounters from a pool, one tick at a time."""

from functools import partial
from typing import TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from glasshelm.encounters.random_encounters import RandomEncounters, random_encounter
from glasshelm.encounters.types import Encounter
from glasshelm.env.rewards import Reward
from glasshelm.env.step import EnvSettings, EnvState, reset, step
from glasshelm.networks.actors import Actor
from glasshelm.ship.nomoto import ShipParams
from glasshelm.training.exploration import Noise, NoiseSettings, explore, quiet
from glasshelm.training.replay_buffer import Row, row_of

Tree = TypeVar("Tree")


class Pool(eqx.Module):
    """Encounters drawn in advance, with their first states: a reset is a look-up."""

    encounters: Encounter
    starts: EnvState


class Worlds(eqx.Module):
    """All worlds at one instant. ``ended``: the episode is over, its last frame not yet written."""

    encounter: Encounter
    state: EnvState
    noise: Noise
    ended: Bool[Array, " w"]


def draw_pool(key: PRNGKeyArray, size: int, ship: ShipParams, settings: RandomEncounters) -> Pool:
    """A fresh pool of ``size`` random encounters."""
    encounters = draw_encounters(key, size, ship, settings)
    return Pool(encounters, _starts(encounters, ship))


@partial(jax.jit, static_argnums=(1, 3))
def draw_encounters(
    key: PRNGKeyArray, size: int, ship: ShipParams, settings: RandomEncounters
) -> Encounter:
    """``size`` independent random encounters."""
    keys = jax.random.split(key, size)
    return jax.vmap(lambda k: random_encounter(k, ship, settings))(keys)


@jax.jit
def _starts(encounters: Encounter, ship: ShipParams) -> EnvState:
    return jax.vmap(lambda e: reset(e, ship))(encounters)


def first_worlds(pool: Pool, worlds: int) -> Worlds:
    """Worlds at the start of the first encounters of a pool."""
    return Worlds(
        jax.tree.map(lambda x: x[:worlds], pool.encounters),
        jax.tree.map(lambda x: x[:worlds], pool.starts),
        quiet(worlds),
        jnp.zeros(worlds, bool),
    )


def cut_short(number: Int[Array, ""], worlds: int, episode_steps: int) -> Bool[Array, " w"]:
    """Worlds whose first episode the clock ends early, so that they do not all end together."""
    return number == jnp.arange(worlds) * episode_steps // worlds


def tick(
    worlds: Worlds,
    actor: Actor,
    pool: Pool,
    progress: Float[Array, ""],
    cut: Bool[Array, " w"],
    key: PRNGKeyArray,
    ship: ShipParams,
    settings: EnvSettings,
    noise_settings: NoiseSettings,
) -> tuple[Worlds, Row]:
    """One step of every world, and the row that it leaves in the replay.

    ``progress`` is the fraction of the training done, ``cut`` ends episodes by
    the clock. A world whose episode is over spends a tick on writing its last frame, as a
    row that is no transition, and then begins another encounter of the pool.
    """
    noise_key, reset_key = jax.random.split(key)
    observation = worlds.state.observation
    action, noise = explore(worlds.noise, actor(observation), progress, noise_settings, noise_key)
    out = jax.vmap(lambda e, s, a: step(e, s, a * ship.rudder_limit_rad, ship, settings))(
        worlds.encounter, worlds.state, action
    )
    row = row_of(
        observation,
        action,
        Reward(out.reward.waypoint, out.reward.by_ship),
        worlds.state.step,
        ~worlds.ended,
        out.terminated,
    )
    chosen = jax.random.randint(reset_key, worlds.ended.shape, 0, pool.encounters.present.shape[0])
    fresh_encounter, fresh_state, fresh_noise = (
        jax.tree.map(lambda x: x[chosen], pool.encounters),
        jax.tree.map(lambda x: x[chosen], pool.starts),
        quiet(worlds.ended.shape[0]),
    )
    return (
        Worlds(
            _choose(worlds.ended, fresh_encounter, worlds.encounter),
            _choose(worlds.ended, fresh_state, out.state),
            _choose(worlds.ended, fresh_noise, noise),
            ~worlds.ended & (out.terminated | out.truncated | cut),
        ),
        row,
    )


def _choose(mask: Bool[Array, " w"], yes: Tree, no: Tree) -> Tree:
    def pick(a: Array, b: Array) -> Array:
        return jnp.where(mask.reshape(-1, *[1] * (a.ndim - 1)), a, b)

    return jax.tree.map(pick, yes, no)
