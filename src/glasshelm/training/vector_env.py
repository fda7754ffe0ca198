"""Many environments stepped together, without end: a finished episode is followed by another."""

from functools import partial
from typing import TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from glasshelm.encounters.random_encounters import RandomEncounters, random_encounters
from glasshelm.encounters.types import Encounter
from glasshelm.env.step import EnvSettings, EnvState, StepResult, reset, step
from glasshelm.networks.actors import Actor
from glasshelm.ship.nomoto import ShipParams
from glasshelm.training.exploration import Noise, NoiseSettings, explore, no_noise
from glasshelm.training.replay_buffer import ReplayRow, replay_row

Tree = TypeVar("Tree")


class EncounterPool(eqx.Module):
    """Encounters drawn in advance, with their first states: a reset is a look-up."""

    encounters: Encounter
    starts: EnvState


class VectorEnvState(eqx.Module):
    """All environments at one instant.

    ``ended``: the episode is over, its last frame is not yet in the replay buffer.
    """

    encounter: Encounter
    state: EnvState
    noise: Noise
    ended: Bool[Array, " w"]


def reset_batch(encounters: Encounter, ship: ShipParams) -> EnvState:
    """The first state of every encounter of a batch."""
    return jax.vmap(lambda e: reset(e, ship))(encounters)


def step_batch(
    encounters: Encounter,
    states: EnvState,
    actions: Float[Array, " w"],
    ship: ShipParams,
    settings: EnvSettings = EnvSettings(),
) -> StepResult:
    """One step of every encounter of a batch; ``actions`` are fractions of the rudder limit."""
    return jax.vmap(lambda e, s, a: step(e, s, a * ship.rudder_limit_rad, ship, settings))(
        encounters, states, actions
    )


def draw_pool(
    key: PRNGKeyArray, size: int, ship: ShipParams, settings: RandomEncounters
) -> EncounterPool:
    """A fresh pool of ``size`` random encounters."""
    encounters = random_encounters(key, size, ship, settings)
    return EncounterPool(encounters, jax.jit(reset_batch)(encounters, ship))


def init_envs(pool: EncounterPool, num_envs: int) -> VectorEnvState:
    """Environments at the start of the first encounters of a pool."""
    encounters, starts = jax.tree.map(lambda x: x[:num_envs], (pool.encounters, pool.starts))
    return VectorEnvState(encounters, starts, no_noise(num_envs), jnp.zeros(num_envs, bool))


def staggered_end(steps: Int[Array, ""], num_envs: int, episode_steps: int) -> Bool[Array, " w"]:
    """Which first episodes to truncate now, so that not all episodes end at the same step."""
    return steps == jnp.arange(num_envs) * episode_steps // num_envs


def step_all(
    envs: VectorEnvState,
    actor: Actor,
    pool: EncounterPool,
    progress: Float[Array, ""],
    truncate: Bool[Array, " w"],
    key: PRNGKeyArray,
    ship: ShipParams,
    settings: EnvSettings,
    noise_settings: NoiseSettings,
) -> tuple[VectorEnvState, ReplayRow]:
    """One step of every environment under the actor with exploration.

    An environment whose episode is over spends a step on its last frame (a row
    that is no transition) and then begins another encounter of the pool.

    Args:
        envs: The environments before the step.
        actor: The actor that steers.
        pool: Where the next encounters come from.
        progress: Fraction of the training done, for the exploration.
        truncate: Environments whose episode is to end with this step.
        key: Random key of this step.
        ship: Own ship.
        settings: The environment's settings.
        noise_settings: The exploration's settings.

    Returns:
        The environments after the step, and the row that it adds to the replay buffer.
    """
    noise_key, reset_key = jax.random.split(key)
    observation = envs.state.observation
    action, noise = explore(envs.noise, actor(observation), progress, noise_settings, noise_key)
    result = step_batch(envs.encounter, envs.state, action, ship, settings)
    row = replay_row(
        observation, action, result.reward, envs.state.step, ~envs.ended, result.terminated
    )
    num_envs, pool_size = envs.ended.shape[0], pool.encounters.present.shape[0]
    drawn = jax.random.randint(reset_key, (num_envs,), 0, pool_size)
    encounters, starts = jax.tree.map(lambda x: x[drawn], (pool.encounters, pool.starts))
    choose = partial(_choose, envs.ended)
    return (
        VectorEnvState(
            choose(encounters, envs.encounter),
            choose(starts, result.state),
            choose(no_noise(num_envs), noise),
            ~envs.ended & (result.terminated | result.truncated | truncate),
        ),
        row,
    )


def _choose(mask: Bool[Array, " w"], yes: Tree, no: Tree) -> Tree:
    def pick(a: Array, b: Array) -> Array:
        return jnp.where(mask.reshape(-1, *[1] * (a.ndim - 1)), a, b)

    return jax.tree.map(pick, yes, no)
