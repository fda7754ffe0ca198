"""DDPG with sub-task critics (section 2.2): worlds, replay, noise and updates in one program.

With ``actor_update=False`` the same program evaluates a fixed pilot: the
critics learn the return of that pilot, with exploring rudders in between.
"""

import dataclasses
from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, Int

from glasshelm.encounters.random_encounters import PAPER, RandomEncounters
from glasshelm.env.step import EnvSettings
from glasshelm.networks.actors import Actor, AttentionActor
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.networks.ship_batch import Packed
from glasshelm.ship.nomoto import ShipParams
from glasshelm.training.exploration import NoiseSettings
from glasshelm.training.losses import (
    ActorLossSettings,
    CriticTraining,
    Follows,
    actor_loss,
    critic_loss,
    polyak,
    td_target,
)
from glasshelm.training.replay_buffer import Batch, Replay, empty_replay, sample, write
from glasshelm.training.vector_env import Pool, Worlds, cut_short, draw_pool, first_worlds, tick


@dataclasses.dataclass(frozen=True)
class DdpgSettings:
    """Table A.6 by default; what it does not give is in docs/explanation/paper.md."""

    env_steps: int = 10_000_000
    #: Environment steps a gradient update.
    train_interval: int = 100
    batch: int = 1024
    discount: float = 0.98
    target_rate: float = 0.001
    learning_rate: float = 0.001
    #: The learning rate falls to this share of itself along a cosine (1: constant).
    learning_rate_end: float = 1.0
    replay: int = 1_000_000
    critic_from: int = 20_480
    actor_from: int = 102_400
    worlds: int = 100
    actor_update: bool = True
    #: Whose return the critics learn. A pilot who never intrudes has no collision return at all:
    #: what is dangerous to her shows only if she may lapse.
    follows: Follows = "pilot"
    encounters: RandomEncounters = PAPER
    world: EnvSettings = dataclasses.field(default_factory=EnvSettings)
    noise: NoiseSettings = dataclasses.field(default_factory=NoiseSettings)
    actor_loss: ActorLossSettings = dataclasses.field(default_factory=ActorLossSettings)
    #: Encounters drawn in advance, and how many cycles they serve.
    pool: int = 2048
    pool_cycles: int = 1000

    @property
    def cycle_ticks(self) -> int:
        """Steps of every world in one cycle."""
        return max(1, self.train_interval // self.worlds)

    @property
    def cycle_updates(self) -> int:
        """Updates in one cycle: their ratio to steps is 1 : train_interval."""
        return max(1, self.cycle_ticks * self.worlds // self.train_interval)

    @property
    def cycle_env_steps(self) -> int:
        return self.cycle_ticks * self.worlds

    @property
    def cycles(self) -> int:
        return -(-self.env_steps // self.cycle_env_steps)

    @property
    def replay_ticks(self) -> int:
        return self.replay // self.worlds


class DdpgState(eqx.Module):
    """All that changes while learning. Random keys follow from ``cycle`` and the seed."""

    actor: Actor
    critic: SubTaskCritic
    target_actor: Actor
    target_critic: SubTaskCritic
    actor_optimiser: optax.OptState
    critic_optimiser: optax.OptState
    worlds: Worlds
    replay: Replay
    cycle: Int[Array, ""]


class Report(eqx.Module):
    """What a cycle tells: losses (0 where nothing was learned) and the mean reward of its steps."""

    critic_loss: Float[Array, ""]
    actor_loss: Float[Array, ""]
    reward: Float[Array, ""]


class Rows(NamedTuple):
    """Rows that a packed batch keeps for ships and for pairs of ships."""

    ships: int
    pairs: int | None


def packed_rows(batch: int, targets: tuple[int, int], pairs: bool) -> Rows:
    """Mean + 4 σ of the ships (pairs) in a batch whose worlds hold low..high ships uniformly."""
    counts = range(targets[0], targets[1] + 1)

    def rows(power: int) -> int:
        mean = sum(n**power for n in counts) / len(counts)
        variance = sum(n ** (2 * power) for n in counts) / len(counts) - mean**2
        wanted = batch * mean + 4 * (batch * variance) ** 0.5
        most = batch * targets[1] ** power
        return max(1, min(most, -(-int(wanted) // 16) * 16))

    return Rows(rows(1), rows(2) if pairs else None)


def optimiser(settings: DdpgSettings) -> optax.GradientTransformation:
    """Adam (Table A.6), with the settings' schedule."""
    if settings.learning_rate_end == 1.0:
        return optax.adam(settings.learning_rate)
    updates = settings.cycles * settings.cycle_updates
    return optax.adam(
        optax.cosine_decay_schedule(settings.learning_rate, updates, settings.learning_rate_end)
    )


def pool_of(seed: int, cycle: int, ship: ShipParams, settings: DdpgSettings) -> Pool:
    """The pool that serves a cycle: a function of the seed and the cycle alone."""
    key = jax.random.fold_in(jax.random.key(seed), cycle // settings.pool_cycles)
    return draw_pool(jax.random.fold_in(key, 0), settings.pool, ship, settings.encounters)


def begin_ddpg(
    actor: Actor, critic: SubTaskCritic, pool: Pool, settings: DdpgSettings
) -> DdpgState:
    """The state before the first step. Targets start as copies of the networks."""
    return _begin(actor, critic, first_worlds(pool, settings.worlds), settings)


@partial(jax.jit, static_argnums=3)
def _begin(
    actor: Actor, critic: SubTaskCritic, worlds: Worlds, settings: DdpgSettings
) -> DdpgState:
    """Every array of the result has a buffer of its own: they are donated."""
    adam = optimiser(settings)
    return DdpgState(
        actor,
        critic,
        jax.tree.map(jnp.copy, actor),
        jax.tree.map(jnp.copy, critic),
        adam.init(eqx.filter(actor, eqx.is_array)),
        adam.init(eqx.filter(critic, eqx.is_array)),
        worlds,
        empty_replay(settings.replay_ticks, settings.worlds, settings.encounters.slots),
        jnp.zeros((), jnp.int32),
    )


def cycle(
    state: DdpgState,
    pool: Pool,
    learn_critic: bool,
    learn_actor: bool,
    seed: int,
    ship: ShipParams,
    settings: DdpgSettings,
    training: CriticTraining,
) -> tuple[DdpgState, Report]:
    """The worlds' steps of one cycle, then its updates (1 : train_interval)."""
    key = jax.random.fold_in(jax.random.fold_in(jax.random.key(seed), 1), state.cycle)
    state, reward = _sail(state, pool, jax.random.fold_in(key, 0), ship, settings)
    zero = jnp.zeros(())
    critic_loss_, actor_loss_ = zero, zero
    if learn_critic:
        for number in range(settings.cycle_updates):
            update_key = jax.random.fold_in(key, number + 1)
            state, critic_loss_, actor_loss_ = update(
                state, update_key, learn_actor, settings, training
            )
    state = eqx.tree_at(lambda s: s.cycle, state, state.cycle + 1)
    return state, Report(critic_loss_, actor_loss_, reward)


def _sail(
    state: DdpgState, pool: Pool, key: Array, ship: ShipParams, settings: DdpgSettings
) -> tuple[DdpgState, Float[Array, ""]]:
    progress = state.cycle / settings.cycles
    worlds, replay, total = state.worlds, state.replay, jnp.zeros(())
    for number in range(settings.cycle_ticks):
        cut = cut_short(replay.written, settings.worlds, settings.world.episode_steps)
        worlds, row = tick(
            worlds,
            state.actor,
            pool,
            progress,
            cut,
            jax.random.fold_in(key, number),
            ship,
            settings.world,
            settings.noise,
        )
        replay = write(replay, row)
        total += row.rewards.sum(-1).mean() / settings.cycle_ticks
    state = eqx.tree_at(lambda s: (s.worlds, s.replay), state, (worlds, replay))
    return state, total


def update(
    state: DdpgState,
    key: Array,
    learn_actor: bool,
    settings: DdpgSettings,
    training: CriticTraining,
) -> tuple[DdpgState, Float[Array, ""], Float[Array, ""]]:
    """One gradient update of the critics and, if asked, of the actor (Eq. 2-5)."""
    sample_key, noise_key = jax.random.split(key)
    batch = sample(state.replay, settings.batch, sample_key)
    rows = packed_rows(
        settings.batch, settings.encounters.targets, isinstance(state.actor, AttentionActor)
    )
    return learn(state, batch, rows, noise_key, learn_actor, settings, training)


def learn(
    state: DdpgState,
    batch: Batch,
    rows: Rows,
    key: Array,
    learn_actor: bool,
    settings: DdpgSettings,
    training: CriticTraining,
) -> tuple[DdpgState, Float[Array, ""], Float[Array, ""]]:
    """:func:`update` on a given batch. Worlds whose ships do not all fit the rows are left out."""
    fleet = Packed(batch.observation.present, rows.ships, rows.pairs)
    batch = eqx.tree_at(lambda b: b.weight, batch, batch.weight * fleet.whole)
    adam = optimiser(settings)
    pilot = state.target_actor if settings.actor_update else state.actor
    target = td_target(
        state.target_critic, pilot, batch, settings.discount, fleet, settings.follows
    )
    critic_value, slope = eqx.filter_value_and_grad(critic_loss)(
        state.critic, target, batch, training, fleet
    )
    changes, critic_optimiser = adam.update(slope, state.critic_optimiser)
    critic = eqx.apply_updates(state.critic, changes)
    state = eqx.tree_at(
        lambda s: (s.critic, s.target_critic, s.critic_optimiser),
        state,
        (critic, polyak(state.target_critic, critic, settings.target_rate), critic_optimiser),
    )
    if not learn_actor:
        return state, critic_value, jnp.zeros(())
    actor_value, slope = eqx.filter_value_and_grad(actor_loss)(
        state.actor, critic, batch, settings.actor_loss, fleet, key
    )
    changes, actor_optimiser = adam.update(slope, state.actor_optimiser)
    actor = eqx.apply_updates(state.actor, changes)
    state = eqx.tree_at(
        lambda s: (s.actor, s.target_actor, s.actor_optimiser),
        state,
        (actor, polyak(state.target_actor, actor, settings.target_rate), actor_optimiser),
    )
    return state, critic_value, actor_value
