"""DAgger (Ross et al. 2011): an actor learns to steer like an expert that looks ahead.

The expert is the simulated critic (:mod:`glasshelm.planning.simulated_critic`): it values
some 770 manoeuvres and names the best course, so the actor learns on which side to pass.
Every iteration

1. draws fresh encounters (:mod:`glasshelm.training.encounter_mix`);
2. simulates them, each segment of an episode steered by the expert with probability β
   and otherwise by the actor: the data are of states that the actor gets itself into;
3. labels every decision with the rudder that steers the expert's course;
4. adds the labels to the dataset of the last iterations, and regresses the actor's
   rudder on it. A decision weighs by what is at stake: where port is as good as
   starboard, the label says little.
"""

import dataclasses
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, Int, PRNGKeyArray

from glasshelm.encounters.types import Encounter
from glasshelm.env.observe import Observation, empty_observation
from glasshelm.env.step import EnvState
from glasshelm.explanation.manoeuvre_explanation import choose
from glasshelm.networks.actors import Actor
from glasshelm.networks.ship_batch import Packed
from glasshelm.planning.manoeuvres import ManoeuvreTable
from glasshelm.planning.simulated_critic import ManoeuvreCosts, SimulatedCritic
from glasshelm.planning.situation import rudder_towards
from glasshelm.ship.nomoto import ShipParams
from glasshelm.training.action_gap import action_gap
from glasshelm.training.encounter_mix import EncounterMix
from glasshelm.training.iterations import optimiser_of, with_newest
from glasshelm.training.vector_env import reset_batch, step_batch


@dataclasses.dataclass(frozen=True)
class DaggerSettings:
    """What the expert compares, on what it is asked, and how the actor learns from it."""

    #: The manoeuvres that the expert compares, and what counts as good.
    table: ManoeuvreTable = dataclasses.field(default_factory=ManoeuvreTable)
    costs: ManoeuvreCosts = dataclasses.field(default_factory=ManoeuvreCosts)
    mix: EncounterMix = dataclasses.field(default_factory=EncounterMix)
    #: An episode is so many segments of so many decisions, each held for so many steps. The
    #: expert chooses once per segment.
    segments: int = 40
    decisions: int = 4
    hold_steps: int = 3
    #: β falls from 1 to this over so many iterations.
    beta: float = 0.2
    beta_iterations: int = 20
    #: A decision with an action gap s weighs (s + 0.1·scale) / (s + scale).
    stakes_scale: float = 3.0
    #: Errors of the rudder count by their square up to this, by their size beyond: between
    #: labels to both sides the actor then takes one, where the square would take the mean.
    huber_delta: float = 0.2
    #: The dataset holds the labels of so many iterations, the newest among them.
    dataset_iterations: int = 4
    #: 0 leaves the whole stage out.
    iterations: int = 200
    #: Gradient updates per iteration, each on so many decisions of all episodes of an iteration.
    updates: int = 100
    batch_decisions: int = 8
    learning_rate: float = 1e-3
    max_gradient_norm: float = 1.0
    #: The actor that is kept is the moving average of the actor at this rate, per update.
    average_rate: float = 0.002

    @property
    def expert(self) -> SimulatedCritic:
        return SimulatedCritic(self.table, self.costs)

    @property
    def episode_decisions(self) -> int:
        return self.segments * self.decisions

    @property
    def iteration_env_steps(self) -> int:
        return self.mix.size * self.episode_decisions * self.hold_steps

    def packed(self, encounters: Encounter) -> Packed:
        """The targets of a batch of the mix in rows."""
        return Packed(encounters.present, self.mix.total_targets, self.mix.total_pairs)


class Labels(eqx.Module):
    """Observations, the expert's rudder and the weight of each [iteration, decision, episode]."""

    observation: Observation
    rudder: Float[Array, "*b w"]
    weight: Float[Array, "*b w"]


class DaggerState(eqx.Module):
    """Everything that an iteration starts from; ``average`` is the actor that is kept."""

    actor: Actor
    average: Actor
    optimiser: optax.OptState
    dataset: Labels
    iteration: Int[Array, ""]


def init_dagger(actor: Actor, settings: DaggerSettings) -> DaggerState:
    """The state before the first iteration, its dataset empty."""
    mix = settings.mix
    shape = (settings.dataset_iterations, settings.episode_decisions, mix.size)
    observation = jax.tree.map(
        lambda x: jnp.zeros((*shape, *x.shape), x.dtype), empty_observation(mix.max_targets)
    )
    return DaggerState(
        jax.tree.map(jnp.copy, actor),  # own copies: the state is donated
        jax.tree.map(jnp.copy, actor),
        optimiser_of(settings).init(eqx.filter(actor, eqx.is_array)),
        Labels(observation, jnp.zeros(shape), jnp.zeros(shape)),
        jnp.zeros((), jnp.int32),
    )


def collect_labels(
    actor: Actor,
    encounters: Encounter,
    actor_share: Float[Array, ""],
    key: PRNGKeyArray,
    ship: ShipParams,
    settings: DaggerSettings,
) -> Labels:
    """Simulate a batch of encounters and label every decision [decision, episode].

    Args:
        actor: The actor that learns.
        encounters: A batch of the settings' mix.
        actor_share: Probability 1 − β that the actor steers a segment.
        key: Random key that draws which of the two steers.
        ship: Own ship.
        settings: Segments, decisions and the expert.
    """
    fleet = settings.packed(encounters)
    episodes = encounters.present.shape[0]

    def advice(observation: Observation) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """The course of the best manoeuvre, off the waypoint's bearing, and what is at stake."""
        manoeuvres, values = settings.expert(observation, ship)
        gap = action_gap(manoeuvres, values, observation, ship)
        return manoeuvres.offset_rad[choose(values)], gap

    def segment(state: EnvState, key: PRNGKeyArray):
        offset, at_stake = jax.vmap(advice)(state.observation)
        weight = (at_stake + 0.1 * settings.stakes_scale) / (at_stake + settings.stakes_scale)
        actor_steers = jax.random.bernoulli(key, actor_share, (episodes,))

        def decide(state: EnvState, _: None):
            observation = state.observation
            label = jax.vmap(lambda c, o: rudder_towards(c, o, ship))(offset, observation)
            action = jnp.where(actor_steers, actor(observation, fleet), label)
            state, _ = jax.lax.scan(
                lambda s, _: (step_batch(encounters, s, action, ship).state, None),
                state,
                length=settings.hold_steps,
            )
            return state, Labels(observation, label, weight)

        return jax.lax.scan(decide, state, None, length=settings.decisions)

    keys = jax.random.split(key, settings.segments)
    _, labels = jax.lax.scan(segment, reset_batch(encounters, ship), keys)
    return jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), labels)


def dagger_iteration(
    state: DaggerState, key: PRNGKeyArray, ship: ShipParams, settings: DaggerSettings
) -> tuple[DaggerState, Float[Array, ""]]:
    """Collect labels, add them to the dataset, and learn from it.

    Returns:
        The state after the iteration, and the mean loss of its updates.
    """
    draw_key, collect_key, learn_key = jax.random.split(key, 3)
    encounters = settings.mix.draw(draw_key, ship)
    fleet = settings.packed(encounters)
    ramp = jnp.minimum(1.0, state.iteration / settings.beta_iterations)
    actor_share = (1.0 - settings.beta) * ramp
    labels = collect_labels(state.actor, encounters, actor_share, collect_key, ship, settings)
    dataset, filled = with_newest(state.dataset, labels, state.iteration, settings)
    optimiser = optimiser_of(settings)

    def loss(actor: Actor, labels: Labels) -> Float[Array, ""]:
        error = actor(labels.observation, fleet) - labels.rudder
        huber = optax.losses.huber_loss(error, delta=settings.huber_delta)
        return jnp.mean(labels.weight * huber)

    def update(carry: Any, key: PRNGKeyArray):
        actor, average, optimiser_state = carry
        iteration_key, decision_key = jax.random.split(key)
        number = settings.batch_decisions
        iterations = jax.random.randint(iteration_key, (number,), 0, filled)
        decisions = jax.random.randint(decision_key, (number,), 0, settings.episode_decisions)

        def add(total, where):
            part = jax.tree.map(lambda x: x[where], dataset)
            return jax.tree.map(jnp.add, total, jax.value_and_grad(loss)(actor, part)), None

        # Decision by decision: the activations of one fit the cache, those of all do not.
        zero = (jnp.zeros(()), jax.tree.map(jnp.zeros_like, actor))
        (value, gradient), _ = jax.lax.scan(add, zero, (iterations, decisions))
        gradient = jax.tree.map(lambda g: g / number, gradient)
        changes, optimiser_state = optimiser.update(gradient, optimiser_state)
        actor = eqx.apply_updates(actor, changes)
        even = 1.0 / (1.0 + state.iteration * settings.updates)  # at first the plain mean
        rate = jnp.maximum(settings.average_rate, even)
        average = optax.incremental_update(actor, average, rate)
        return (actor, average, optimiser_state), value / number

    start: Any = (state.actor, state.average, state.optimiser)
    keys = jax.random.split(learn_key, settings.updates)
    (actor, average, optimiser_state), losses = jax.lax.scan(update, start, keys)
    state = DaggerState(actor, average, optimiser_state, dataset, state.iteration + 1)
    return state, losses.mean()
