"""DDPG with sub-task critics (section 2.2): environments, replay and updates in one program.

With ``actor_update=False`` the same program evaluates a fixed actor: the
critics learn the return of that actor, exploration included or not
(:data:`glasshelm.training.losses.TdTarget`).
"""

import dataclasses
from functools import partial
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
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
    TdError,
    TdTarget,
    actor_loss,
    critic_loss,
    td_target,
)
from glasshelm.training.replay_buffer import (
    ReplayBuffer,
    TransitionBatch,
    append,
    empty_buffer,
    sample,
)
from glasshelm.training.vector_env import (
    EncounterPool,
    VectorEnvState,
    draw_pool,
    init_envs,
    staggered_end,
    step_all,
)


@dataclasses.dataclass(frozen=True)
class DdpgSettings:
    """Table A.6 by default; what it does not give is in docs/explanation/paper.md."""

    env_steps: int = 10_000_000
    #: Environment steps for each gradient update.
    train_interval: int = 100
    batch_size: int = 1024
    discount: float = 0.98
    #: τ of the target networks (Eq. 4).
    tau: float = 0.001
    learning_rate: float = 0.001
    #: The learning rate falls to this share of itself along a cosine (1: constant).
    learning_rate_end: float = 1.0
    replay_size: int = 1_000_000
    #: Environment steps before the first update of the critics, and of the actor.
    critic_starts: int = 20_480
    actor_starts: int = 102_400
    num_envs: int = 100
    actor_update: bool = True
    #: Whose return the critics learn. An actor that never intrudes has no collision return at
    #: all: what is dangerous to it shows only if exploration counts (``sarsa``).
    target: TdTarget = "policy"
    encounters: RandomEncounters = PAPER
    env: EnvSettings = dataclasses.field(default_factory=EnvSettings)
    noise: NoiseSettings = dataclasses.field(default_factory=NoiseSettings)
    actor_loss: ActorLossSettings = dataclasses.field(default_factory=ActorLossSettings)
    #: Encounters drawn in advance, and how many cycles they serve.
    pool_size: int = 2048
    pool_cycles: int = 1000

    @property
    def cycle_steps(self) -> int:
        """Steps of every environment in one cycle."""
        return max(1, self.train_interval // self.num_envs)

    @property
    def cycle_updates(self) -> int:
        """Updates in one cycle: their ratio to steps is 1 : train_interval."""
        return max(1, self.cycle_env_steps // self.train_interval)

    @property
    def cycle_env_steps(self) -> int:
        return self.cycle_steps * self.num_envs

    @property
    def cycles(self) -> int:
        return -(-self.env_steps // self.cycle_env_steps)


class DdpgState(eqx.Module):
    """All that changes while learning. Random keys follow from ``cycle`` and the seed."""

    actor: Actor
    critic: SubTaskCritic
    target_actor: Actor
    target_critic: SubTaskCritic
    actor_optimiser: optax.OptState
    critic_optimiser: optax.OptState
    envs: VectorEnvState
    replay: ReplayBuffer
    cycle: Int[Array, ""]


class PackedSize(NamedTuple):
    """Rows that a packed batch keeps for targets and for pairs of targets."""

    targets: int
    pairs: int | None


def packed_size(batch_size: int, targets: tuple[int, int], pairs: bool) -> PackedSize:
    """Mean + 4 σ of the targets (pairs) in a batch whose episodes have low..high targets."""
    counts = np.arange(targets[0], targets[1] + 1)

    def rows(power: int) -> int:
        per_episode = counts**power
        wanted = batch_size * per_episode.mean() + 4 * batch_size**0.5 * per_episode.std()
        return max(1, min(batch_size * int(per_episode[-1]), -(-int(wanted) // 16) * 16))

    return PackedSize(rows(1), rows(2) if pairs else None)


def critic_optimiser(settings: DdpgSettings) -> optax.GradientTransformation:
    """Adam (Table A.6), with the settings' schedule."""
    return optax.adam(_learning_rate(settings))


def actor_optimiser(settings: DdpgSettings) -> optax.GradientTransformation:
    """The same, and λ_reg·Σθ² of Eq. 5 as a decay of the weights (AdamW, Loshchilov & Hutter 2019).

    Within the loss, Adam would scale the slope of Σθ² up with that of Q: wherever Q hardly
    depends on a weight, that weight would shrink by the whole learning rate with every update.
    """
    decay = 2.0 * settings.actor_loss.regularisation
    return optax.adamw(_learning_rate(settings), weight_decay=decay)


def _learning_rate(settings: DdpgSettings) -> optax.Schedule:
    updates = settings.cycles * settings.cycle_updates
    return optax.cosine_decay_schedule(settings.learning_rate, updates, settings.learning_rate_end)


def encounter_pool(
    seed: int, cycle: int, ship: ShipParams, settings: DdpgSettings
) -> EncounterPool:
    """The pool that serves a cycle: a function of the seed and the cycle alone."""
    key = jax.random.fold_in(jax.random.key(seed), cycle // settings.pool_cycles)
    return draw_pool(jax.random.fold_in(key, 0), settings.pool_size, ship, settings.encounters)


@partial(jax.jit, static_argnums=3)
def init_ddpg(
    actor: Actor, critic: SubTaskCritic, pool: EncounterPool, settings: DdpgSettings
) -> DdpgState:
    """The state before the first step; target networks start as copies of the networks.

    Every array of the result has a buffer of its own: the state is donated.
    """
    num_envs = settings.num_envs
    return DdpgState(
        actor,
        critic,
        jax.tree.map(jnp.copy, actor),
        jax.tree.map(jnp.copy, critic),
        actor_optimiser(settings).init(eqx.filter(actor, eqx.is_array)),
        critic_optimiser(settings).init(eqx.filter(critic, eqx.is_array)),
        init_envs(pool, num_envs),
        empty_buffer(settings.replay_size // num_envs, num_envs, settings.encounters.slots),
        jnp.zeros((), jnp.int32),
    )


def run_cycle(
    state: DdpgState,
    pool: EncounterPool,
    learn_critic: bool,
    learn_actor: bool,
    seed: int,
    ship: ShipParams,
    settings: DdpgSettings,
    td_error: TdError,
) -> tuple[DdpgState, dict[str, Float[Array, ""]]]:
    """The environments' steps of one cycle, then its updates (1 : train_interval).

    Returns:
        The state after the cycle; its losses (0 where nothing was learned) and the mean reward
        of its steps.
    """
    key = jax.random.fold_in(jax.random.fold_in(jax.random.key(seed), 1), state.cycle)
    state, reward = _collect(state, pool, jax.random.fold_in(key, 0), ship, settings)
    critic_value, actor_value = jnp.zeros(()), jnp.zeros(())
    if learn_critic:
        for number in range(settings.cycle_updates):
            sample_key, noise_key = jax.random.split(jax.random.fold_in(key, number + 1))
            batch = sample(state.replay, settings.batch_size, sample_key)
            attends = isinstance(state.actor, AttentionActor)
            size = packed_size(settings.batch_size, settings.encounters.targets, attends)
            state, critic_value, actor_value = update(
                state, batch, size, noise_key, learn_actor, settings, td_error
            )
    state = eqx.tree_at(lambda s: s.cycle, state, state.cycle + 1)
    return state, {"critic_loss": critic_value, "actor_loss": actor_value, "reward": reward}


def _collect(
    state: DdpgState, pool: EncounterPool, key: Array, ship: ShipParams, settings: DdpgSettings
) -> tuple[DdpgState, Float[Array, ""]]:
    progress = state.cycle / settings.cycles
    envs, replay, mean_reward = state.envs, state.replay, jnp.zeros(())
    for number in range(settings.cycle_steps):
        envs, row = step_all(
            envs,
            state.actor,
            pool,
            progress,
            staggered_end(replay.written, settings.num_envs, settings.env.episode_steps),
            jax.random.fold_in(key, number),
            ship,
            settings.env,
            settings.noise,
        )
        replay = append(replay, row)
        mean_reward += row.rewards.sum(-1).mean() / settings.cycle_steps
    return eqx.tree_at(lambda s: (s.envs, s.replay), state, (envs, replay)), mean_reward


def update(
    state: DdpgState,
    batch: TransitionBatch,
    size: PackedSize,
    key: Array,
    learn_actor: bool,
    settings: DdpgSettings,
    td_error: TdError,
) -> tuple[DdpgState, Float[Array, ""], Float[Array, ""]]:
    """One gradient update of the critics and, if asked, of the actor (Eq. 2-5).

    Args:
        state: The networks before the update.
        batch: Transitions to learn from.
        size: Rows for the batch's targets; episodes whose targets do not all fit are left out.
        key: Random key of the noise of ŝ (Eq. 5).
        learn_actor: Whether the actor is updated too.
        settings: Learning rates, discount and gains.
        td_error: Of which TD error the critics minimise the square.

    Returns:
        The state after the update, the critics' loss, and the actor's (0 if not updated).
    """
    fleet = Packed(batch.observation.present, size.targets, size.pairs)
    batch = eqx.tree_at(lambda b: b.weight, batch, batch.weight * fleet.complete)
    policy = state.target_actor if settings.actor_update else state.actor
    target = td_target(
        state.target_critic, policy, batch, settings.discount, fleet, settings.target
    )
    critic_value, gradient = eqx.filter_value_and_grad(critic_loss)(
        state.critic, target, batch, td_error, fleet
    )
    changes, critic_state = critic_optimiser(settings).update(gradient, state.critic_optimiser)
    critic = eqx.apply_updates(state.critic, changes)
    target_critic = _follow(critic, state.target_critic, settings)
    state = eqx.tree_at(
        lambda s: (s.critic, s.target_critic, s.critic_optimiser),
        state,
        (critic, target_critic, critic_state),
    )
    if not learn_actor:
        return state, critic_value, jnp.zeros(())
    actor_value, gradient = eqx.filter_value_and_grad(actor_loss)(
        state.actor, critic, batch, settings.actor_loss, fleet, key
    )
    weights = eqx.filter(state.actor, eqx.is_array)
    changes, actor_state = actor_optimiser(settings).update(
        gradient, state.actor_optimiser, weights
    )
    actor = eqx.apply_updates(state.actor, changes)
    target_actor = _follow(actor, state.target_actor, settings)
    state = eqx.tree_at(
        lambda s: (s.actor, s.target_actor, s.actor_optimiser),
        state,
        (actor, target_actor, actor_state),
    )
    return state, critic_value, actor_value


def _follow(network: Any, target: Any, settings: DdpgSettings) -> Any:
    """Eq. 4: θ' ← τ·θ + (1 − τ)·θ'."""
    return optax.incremental_update(network, target, settings.tau)
