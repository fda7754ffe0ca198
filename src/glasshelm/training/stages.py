"""The parts of a training: each begins, advances by one unit, and shows its pilot.

``imitation`` makes an actor from a teacher's lessons, ``actor`` improves it by
gradients through the world, ``critic`` evaluates critics on the actor that was
found, ``ddpg`` learns both at once. The loop (:mod:`glasshelm.training.trainer`)
treats them alike.
"""

from functools import partial
from typing import Any, Protocol, runtime_checkable

import jax
import jax.numpy as jnp

from glasshelm.networks.actors import Actor
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.ship.nomoto import ship_named
from glasshelm.training.analytic_policy_gradient import (
    AnalyticState,
    Voyages,
    iterate,
    start_training,
)
from glasshelm.training.config import TrainConfig
from glasshelm.training.dagger import ImitationState, Lesson, imitate, start_imitation
from glasshelm.training.ddpg import DdpgState, Pool, Report, begin_ddpg, cycle, pool_of

#: A state is an eqx.Module whose leaves are all arrays.
State = Any
#: What one unit reports, still on the device.
Told = Any


@runtime_checkable
class Stage(Protocol):
    """One part of a training. A unit is an iteration (actor) or a cycle (ddpg, critic)."""

    name: str
    unit: str
    units: int
    updates_per_unit: int
    env_steps_per_unit: int
    evaluate_every: int
    time_share: float

    def begin(self, actor: Actor) -> State:
        """The first state; ``actor`` is the pilot of the stage before, or that of the beginning."""
        ...

    def advance(self, state: State, number: int) -> tuple[State, Told]:
        """One unit on from state ``number`` (0 is the first). The old state is used up."""
        ...

    def tell(self, told: list[Told]) -> dict[str, float]:
        """Means of what a run of units reported."""
        ...

    def actor(self, state: State) -> Actor: ...

    def critic(self, state: State) -> SubTaskCritic | None: ...


class ImitationStage:
    """The actor by the lessons of a teacher who plans (:mod:`glasshelm.training.dagger`)."""

    name, unit = "imitation", "iterations"

    def __init__(self, config: TrainConfig):
        settings = config.imitation
        self.units = settings.iterations
        self.updates_per_unit = settings.updates
        voyage = settings.stretches * settings.decisions * settings.hold
        self.env_steps_per_unit = config.analytic.worlds * voyage
        self.evaluate_every = config.units_between[0]
        self.time_share = config.time_shares[0]
        self._config = config

    def begin(self, actor: Actor) -> ImitationState:
        slots = self._config.analytic.encounters.slots
        return start_imitation(actor, self._config.analytic, self._config.imitation, slots)

    def advance(self, state: ImitationState, number: int) -> tuple[ImitationState, Lesson]:
        return _imitate(state, self._config)

    def tell(self, told: list[Lesson]) -> dict[str, float]:
        return {"rudder_error": _mean([t.error for t in told])}

    def actor(self, state: ImitationState) -> Actor:
        return state.average

    def critic(self, state: ImitationState) -> SubTaskCritic | None:
        return None


class ActorStage:
    """The actor by gradients through the environment."""

    name, unit = "actor", "iterations"
    updates_per_unit = 1

    def __init__(self, config: TrainConfig):
        settings = config.analytic
        self.units = settings.iterations
        self.env_steps_per_unit = settings.worlds * settings.decisions * settings.hold
        self.evaluate_every = config.units_between[1]
        self.time_share = config.time_shares[1]
        self._config = config

    def begin(self, actor: Actor) -> AnalyticState:
        return _start(actor, self._config)

    def advance(self, state: AnalyticState, number: int) -> tuple[AnalyticState, Voyages]:
        return _iterate(state, self._config)

    def tell(self, told: list[Voyages]) -> dict[str, float]:
        return {
            "smooth_return": _mean([t.returns for t in told]),
            "train_intrusions": _mean([t.intruded for t in told]),
        }

    def actor(self, state: AnalyticState) -> Actor:
        return state.average

    def critic(self, state: AnalyticState) -> SubTaskCritic | None:
        return None


class DdpgStage:
    """DDPG, or with a fixed actor the evaluation of its critics.

    One unit is one call of one jitted program (worlds' steps and updates), its
    state donated so that the replay is written in place.
    """

    unit = "cycles"

    def __init__(self, config: TrainConfig):
        settings = config.ddpg
        self.name = "ddpg" if settings.actor_update else "critic"
        self.units = settings.cycles
        self.updates_per_unit = settings.cycle_updates
        self.env_steps_per_unit = settings.cycle_env_steps
        self.evaluate_every = config.units_between[2]
        self.time_share = config.time_shares[2]
        self._config = config
        self._pool: tuple[int, Pool] | None = None

    def begin(self, actor: Actor) -> DdpgState:
        config = self._config
        key = jax.random.fold_in(jax.random.key(config.seed), 4)
        critic = jax.jit(SubTaskCritic, static_argnums=0)(config.critic_sizes, key)
        return begin_ddpg(actor, critic, self._pool_at(0), config.ddpg)

    def advance(self, state: DdpgState, number: int) -> tuple[DdpgState, Report]:
        settings = self._config.ddpg
        steps = number * self.env_steps_per_unit
        critic = steps >= settings.critic_from
        actor = critic and settings.actor_update and steps >= settings.actor_from
        return _cycle(state, self._pool_at(number), critic, actor, self._config)

    def tell(self, told: list[Report]) -> dict[str, float]:
        return {
            "critic_loss": _mean([t.critic_loss for t in told]),
            "actor_loss": _mean([t.actor_loss for t in told]),
            "reward": _mean([t.reward for t in told]),
        }

    def actor(self, state: DdpgState) -> Actor:
        return state.actor

    def critic(self, state: DdpgState) -> SubTaskCritic | None:
        return state.critic

    def _pool_at(self, number: int) -> Pool:
        index = number // self._config.ddpg.pool_cycles
        if self._pool is None or self._pool[0] != index:
            ship = ship_named(self._config.ship)
            self._pool = (index, pool_of(self._config.seed, number, ship, self._config.ddpg))
        return self._pool[1]


def stages_of(config: TrainConfig) -> list[Stage]:
    """The stages of a training, in order; those that have nothing to do are left out."""
    if config.way == "ddpg":
        return [DdpgStage(config)]
    stages: list[Stage] = [ImitationStage(config), ActorStage(config), DdpgStage(config)]
    return [stage for stage in stages if stage.units > 0]


@partial(jax.jit, static_argnums=1)
def _start(actor: Actor, config: TrainConfig) -> AnalyticState:
    key = jax.random.fold_in(jax.random.fold_in(jax.random.key(config.seed), 2), 0)
    return start_training(actor, key, ship_named(config.ship), config.analytic)


@partial(jax.jit, static_argnums=1, donate_argnums=0)
def _imitate(state: ImitationState, config: TrainConfig) -> tuple[ImitationState, Lesson]:
    key = jax.random.fold_in(jax.random.key(config.seed), 5)
    key = jax.random.fold_in(key, state.iteration)
    ship = ship_named(config.ship)
    return imitate(state, key, ship, config.analytic, config.imitation)


@partial(jax.jit, static_argnums=1)
def _iterate(state: AnalyticState, config: TrainConfig) -> tuple[AnalyticState, Voyages]:
    key = jax.random.fold_in(jax.random.key(config.seed), 2)
    key = jax.random.fold_in(key, state.iteration + 1)
    return iterate(state, key, ship_named(config.ship), config.analytic)


@partial(jax.jit, static_argnums=(2, 3, 4), donate_argnums=0)
def _cycle(
    state: DdpgState, pool: Pool, learn_critic: bool, learn_actor: bool, config: TrainConfig
) -> tuple[DdpgState, Report]:
    ship = ship_named(config.ship)
    return cycle(
        state, pool, learn_critic, learn_actor, config.seed, ship, config.ddpg, config.critic
    )


def _mean(values: list[jax.Array]) -> float:
    return float(jnp.mean(jnp.stack([v.astype(jnp.float32).mean() for v in values])))
