"""The stages of a training: each starts, advances by one unit, and shows its policy and critic.

``dagger`` makes an actor that steers like an expert, ``critic`` evaluates critics
on it, ``ddpg`` learns both at once, ``regression`` and ``course`` learn critics of
manoeuvres that steer. The trainer (:mod:`glasshelm.training.trainer`) treats them alike.
A unit is an iteration (dagger, regression, course) or a cycle (ddpg, critic);
``time_share`` is the share of a time budget after which the stage ends; ``advance``
uses the old state up and returns the next with the unit's metrics.
"""

from functools import partial
from pathlib import Path
from typing import Any

import jax
import numpy as np
from jaxtyping import PRNGKeyArray

from glasshelm.core.errors import InputError
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.pilots.load_networks import read_networks
from glasshelm.planning.course_critic import CourseCritic
from glasshelm.planning.learned_critic import LearnedCritic
from glasshelm.ship.nomoto import ship_named
from glasshelm.simulation.rollout import Case
from glasshelm.training.config import TrainConfig
from glasshelm.training.course_learning import CourseState, course_iteration, init_course
from glasshelm.training.dagger import DaggerState, dagger_iteration, init_dagger
from glasshelm.training.ddpg import DdpgState, encounter_pool, init_ddpg, run_cycle
from glasshelm.training.init_actor import init_actor
from glasshelm.training.manoeuvre_regression import (
    HeldCourses,
    RegressionState,
    draw_cases,
    init_regression,
    regression_iteration,
)
from glasshelm.training.validation import AnyPolicy
from glasshelm.training.vector_env import EncounterPool

#: The state of a stage: DaggerState, DdpgState, RegressionState or CourseState.
State = Any


class DaggerStage:
    """The actor by the labels of an expert that plans (:mod:`glasshelm.training.dagger`)."""

    name, unit = "dagger", "iterations"

    def __init__(self, config: TrainConfig):
        settings = config.dagger
        self.units = settings.iterations
        self.updates_per_unit = settings.updates
        self.env_steps_per_unit = settings.iteration_env_steps
        self.evaluate_every = config.iterations_between
        self.time_share = config.dagger_time_share
        self._config = config

    def start(self, policy: Any) -> DaggerState:
        """The first state, from the initial actor."""
        return init_dagger(policy, self._config.dagger)

    def advance(self, state: DaggerState, number: int) -> tuple[DaggerState, dict[str, jax.Array]]:
        state, loss = _iterate_dagger(state, self._config)
        return state, {"rudder_error": loss}

    def policy(self, state: DaggerState) -> AnyPolicy:
        return state.average

    def critic(self, state: DaggerState) -> SubTaskCritic | None:
        return None


class DdpgStage:
    """DDPG, or with a fixed actor the evaluation of its critics.

    One unit is one call of one jitted program (environment steps and updates), its
    state donated so that the replay buffer is written in place.
    """

    unit = "cycles"
    time_share = 1.0

    def __init__(self, config: TrainConfig):
        settings = config.ddpg
        self.name = "ddpg" if settings.actor_update else "critic"
        self.units = settings.cycles
        self.updates_per_unit = settings.cycle_updates
        self.env_steps_per_unit = settings.cycle_env_steps
        self.evaluate_every = config.cycles_between
        self._config = config
        self._pool: tuple[int, EncounterPool] | None = None

    def start(self, policy: Any) -> DdpgState:
        """The first state, from the actor of the stage before or the initial one."""
        config = self._config
        key = jax.random.fold_in(jax.random.key(config.seed), 4)
        critic = jax.jit(SubTaskCritic, static_argnums=0)(config.critic_sizes, key)
        return init_ddpg(policy, critic, self._pool_at(0), config.ddpg)

    def advance(self, state: DdpgState, number: int) -> tuple[DdpgState, dict[str, jax.Array]]:
        settings = self._config.ddpg
        steps = number * self.env_steps_per_unit
        critic = steps >= settings.critic_starts
        actor = critic and settings.actor_update and steps >= settings.actor_starts
        return _run_cycle(state, self._pool_at(number), critic, actor, self._config)

    def policy(self, state: DdpgState) -> AnyPolicy:
        return state.actor

    def critic(self, state: DdpgState) -> SubTaskCritic | None:
        return state.critic

    def _pool_at(self, number: int) -> EncounterPool:
        config = self._config
        index = number // config.ddpg.pool_cycles
        if self._pool is None or self._pool[0] != index:
            pool = encounter_pool(config.seed, number, ship_named(config.ship), config.ddpg)
            self._pool = (index, pool)
        return self._pool[1]


class RegressionStage:
    """A critic of manoeuvres that steers (:mod:`glasshelm.training.manoeuvre_regression`)."""

    name, unit = "regression", "iterations"
    time_share = 1.0

    def __init__(self, config: TrainConfig):
        settings = config.regression
        self.units = settings.iterations
        self.updates_per_unit = settings.updates
        self.env_steps_per_unit = settings.iteration_env_steps
        self.evaluate_every = config.iterations_between
        self._config = config

    def start(self, policy: Any) -> RegressionState:
        """The first state, from the initial critic."""
        return init_regression(policy.critic, self._config.regression)

    def advance(
        self, state: RegressionState, number: int
    ) -> tuple[RegressionState, dict[str, jax.Array]]:
        config = self._config
        key = jax.random.fold_in(jax.random.key(config.seed), 8)
        case_key, key = jax.random.split(jax.random.fold_in(key, number))
        cases = draw_cases(case_key, ship_named(config.ship), config.regression)
        return _iterate_regression(state, cases, key, config)

    def policy(self, state: RegressionState) -> AnyPolicy:
        config = self._config
        return HeldCourses(state.average, ship_named(config.ship), config.regression.hold_steps)

    def critic(self, state: RegressionState) -> SubTaskCritic | None:
        return None


class CourseStage:
    """A critic of courses by its own experience (:mod:`glasshelm.training.course_learning`)."""

    name, unit = "course", "iterations"
    time_share = 1.0

    def __init__(self, config: TrainConfig):
        settings = config.course
        self.units = settings.iterations
        self.updates_per_unit = settings.updates
        self.env_steps_per_unit = settings.iteration_env_steps
        self.evaluate_every = config.iterations_between
        self._config = config

    def start(self, policy: Any) -> CourseState:
        """The first state, from the initial critic."""
        return init_course(policy.critic, self._config.course)

    def advance(self, state: CourseState, number: int) -> tuple[CourseState, dict[str, jax.Array]]:
        return _iterate_course(state, self._config)

    def policy(self, state: CourseState) -> AnyPolicy:
        config = self._config
        return HeldCourses(state.average, ship_named(config.ship), config.course.hold_steps)

    def critic(self, state: CourseState) -> SubTaskCritic | None:
        return None


Stage = DaggerStage | DdpgStage | RegressionStage | CourseStage


def initial_policy(config: TrainConfig) -> AnyPolicy:
    """What a training starts from: an actor, or whatever else steers as one does."""
    if config.algorithm == "course":
        key = jax.random.fold_in(jax.random.key(config.seed), 6)
        critic = jax.jit(CourseCritic, static_argnums=0)(config.course_sizes, key)
        return HeldCourses(critic, ship_named(config.ship), config.course.hold_steps)
    if config.algorithm != "regression":
        return init_actor(config)
    key = jax.random.fold_in(jax.random.key(config.seed), 9)
    critic = jax.jit(LearnedCritic, static_argnums=0)(config.manoeuvre_critic, key)
    if config.init_from is not None:
        critic = _read_critic(Path(config.init_from), critic)
    return HeldCourses(critic, ship_named(config.ship), config.regression.hold_steps)


def _read_critic(path: Path, like: LearnedCritic) -> LearnedCritic:
    """The critic of a weights file. InputError if it is not one to be trained so."""
    critic = read_networks(path)[0].critic
    shapes = [[leaf.shape for leaf in jax.tree.leaves(one)] for one in (critic, like)]
    alike = jax.tree.structure(critic) == jax.tree.structure(like) and shapes[0] == shapes[1]
    if not (alike and isinstance(critic, LearnedCritic)):
        raise InputError(f"{path}: its critic is not the one to be trained")
    return critic


def stages_of(config: TrainConfig) -> list[Stage]:
    """The stages of a training, in order; those that have nothing to do are left out."""
    stages: list[Stage] = [DdpgStage(config)]
    if config.algorithm == "regression":
        stages = [RegressionStage(config)]
    if config.algorithm == "course":
        stages = [CourseStage(config)]
    if config.algorithm == "dagger":
        stages.insert(0, DaggerStage(config))
    return [stage for stage in stages if stage.units > 0]


def mean_metrics(metrics: list[dict[str, jax.Array]]) -> dict[str, float]:
    """The mean of each metric over several units."""
    return {
        name: float(np.mean(jax.device_get([unit[name] for unit in metrics]), dtype=np.float32))
        for name in metrics[0]
    }


@partial(jax.jit, static_argnums=1, donate_argnums=0)
def _iterate_course(
    state: CourseState, config: TrainConfig
) -> tuple[CourseState, dict[str, jax.Array]]:
    key = jax.random.fold_in(jax.random.key(config.seed), 7)
    key = jax.random.fold_in(key, state.iteration)
    return course_iteration(state, key, ship_named(config.ship), config.course)


@partial(jax.jit, static_argnums=1, donate_argnums=0)
def _iterate_dagger(state: DaggerState, config: TrainConfig) -> tuple[DaggerState, jax.Array]:
    key = jax.random.fold_in(jax.random.key(config.seed), 5)
    key = jax.random.fold_in(key, state.iteration)
    return dagger_iteration(state, key, ship_named(config.ship), config.dagger)


@partial(jax.jit, static_argnums=3, donate_argnums=0)
def _iterate_regression(
    state: RegressionState, cases: Case, key: PRNGKeyArray, config: TrainConfig
) -> tuple[RegressionState, dict[str, jax.Array]]:
    return regression_iteration(state, cases, key, ship_named(config.ship), config.regression)


@partial(jax.jit, static_argnums=(2, 3, 4), donate_argnums=0)
def _run_cycle(
    state: DdpgState,
    pool: EncounterPool,
    learn_critic: bool,
    learn_actor: bool,
    config: TrainConfig,
) -> tuple[DdpgState, dict[str, jax.Array]]:
    ship = ship_named(config.ship)
    return run_cycle(
        state, pool, learn_critic, learn_actor, config.seed, ship, config.ddpg, config.critic
    )
