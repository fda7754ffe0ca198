"""Learning what manoeuvres cost: regression on what really happens, under the critic's own helm.

Every iteration

1. draws fresh encounters, of which a share is disturbed (:mod:`glasshelm.simulation.disturbances`);
2. sails them by the argmax of the critic, and now and then on a course drawn at random: the data
   are of situations that the critic gets itself into;
3. labels every decision: for each ship and every ``stride``-th manoeuvre, what sailing the
   manoeuvre with the true own ship would cost with the ship as it really goes on. Neighbours in
   the table cost nearly the same: more situations teach more than more manoeuvres of each;
4. adds the labels to the dataset of the last iterations, and fits the network to it.

The network's output f is the logarithm of an *expectation*, 1 + E[cost], so that critics of
several ships add up in expectation. The loss is that of a gamma distribution,
(1 + y)·exp(−f) + f, whose minimum is f = log E[1 + y] whatever the distribution of y. A squared
error of log(1 + y) would have its minimum at E[log(1 + y)], below it: of a cost that comes
rarely it learns next to nothing. Errors count relative to 1 + y, so small costs, which decide
between manoeuvres that are nearly as good, are learned as well as large ones. Where y = 0, f below
0 costs nothing: such f count as 0, and "this ship does not matter" is learned exactly.
"""

import dataclasses
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from glasshelm.core.geometry import Vector, offset, to_body, wrap_angle
from glasshelm.env.observe import Observation, waypoint_bearing_rad
from glasshelm.env.step import EnvSettings, EnvState, observe_step, targets_at, waypoint_of
from glasshelm.networks.input_features import COURSE_INPUTS, encode_courses
from glasshelm.networks.ship_batch import Packed
from glasshelm.pilots.glassbox import ManoeuvreCritic, best_course
from glasshelm.pilots.protocols import Memory
from glasshelm.planning.learned_critic import LearnedCritic
from glasshelm.planning.manoeuvres import ManoeuvreTable
from glasshelm.planning.simulated_critic import ManoeuvreCosts, simulate_manoeuvres
from glasshelm.planning.situation import Situation, rudder_towards
from glasshelm.ship.autopilot import autopilot_for
from glasshelm.ship.nomoto import ShipParams, advance, with_drift
from glasshelm.simulation.disturbances import with_random_disturbances
from glasshelm.simulation.rollout import Case, plain_cases, reset_case
from glasshelm.simulation.sensor_model import PerceivedTraffic, next_perception
from glasshelm.training.encounter_mix import EncounterMix
from glasshelm.training.iterations import optimiser_of, with_newest


@dataclasses.dataclass(frozen=True)
class RegressionSettings:
    """On what the critic is asked, and how its network learns."""

    mix: EncounterMix = dataclasses.field(
        default_factory=lambda: EncounterMix((2, 4, 6, 8, 12, 14, 18))
    )
    #: Probability that an encounter is disturbed.
    disturbed: float = 0.5
    #: An episode is so many decisions, each held for so many steps.
    decisions: int = 32
    hold_steps: int = 12
    #: Labels know of alterations of course within so long [s]: later ones are seen in time.
    #: Counted in full, they would have it keep clear of all that any ship could ever do.
    reaction_s: float = 400.0
    #: Of all manoeuvres, every so manieth is labelled, beginning with one that is drawn.
    stride: int = 4
    #: A course off the waypoint's bearing is drawn within these limits for so many decisions, with
    #: this probability; otherwise the critic steers.
    explore: float = 0.3
    explore_decisions: int = 4
    explore_rad: float = 1.6
    #: The dataset holds the labels of so many iterations, the newest among them.
    dataset_iterations: int = 24
    iterations: int = 150
    #: Gradient updates per iteration, each on so many rows (a ship in a situation).
    updates: int = 80
    batch_rows: int = 1024
    learning_rate: float = 1.5e-3
    max_gradient_norm: float = 1.0
    #: The critic that is kept is the moving average at this rate, per update.
    average_rate: float = 0.002

    @property
    def iteration_rows(self) -> int:
        """Labels of an iteration: one a ship and decision."""
        return self.mix.total_targets * self.decisions

    @property
    def iteration_env_steps(self) -> int:
        return self.mix.size * self.decisions * self.hold_steps


class HeldCourses(eqx.Module):
    """A critic of manoeuvres at the helm, as a policy that chooses anew every ``hold_steps``."""

    critic: ManoeuvreCritic
    ship: ShipParams = eqx.field(static=True)
    hold_steps: int = eqx.field(static=True)

    def start(self, size: int) -> Memory:
        """How many steps were made, and the courses that are steered."""
        return jnp.zeros((), jnp.int32), jnp.zeros(size)

    def __call__(
        self, observation: Observation, memory: Memory
    ) -> tuple[Float[Array, " w"], Memory]:
        """The rudders towards the courses, off the bearing of the waypoint."""
        step, held = memory
        courses = jax.lax.cond(
            step % self.hold_steps == 0,
            lambda: jax.vmap(lambda o: best_course(self.critic, o, self.ship))(observation),
            lambda: held,
        )
        rudders = jax.vmap(lambda c, o: rudder_towards(c, o, self.ship))(courses, observation)
        return rudders, (step + 1, courses)


class CostLabels(eqx.Module):
    """Inputs of the network, and log(1 + cost) of some manoeuvres, one row a ship.

    ``first`` is the first manoeuvre that is labelled.
    """

    inputs: Float[Array, "*b r d"]
    first: Int[Array, "*b r"]
    log_cost: Float[Array, "*b r k"]


class RegressionState(eqx.Module):
    """Everything that an iteration starts from; ``average`` is the critic that is kept."""

    critic: LearnedCritic
    average: LearnedCritic
    optimiser: optax.OptState
    dataset: CostLabels
    iteration: Int[Array, ""]


def init_regression(critic: LearnedCritic, settings: RegressionSettings) -> RegressionState:
    """The state before the first iteration, its dataset empty."""
    shape = (settings.dataset_iterations, settings.iteration_rows)
    return RegressionState(
        jax.tree.map(jnp.copy, critic),  # own copies: the state is donated
        jax.tree.map(jnp.copy, critic),
        optimiser_of(settings).init(eqx.filter(critic, eqx.is_array)),
        CostLabels(
            jnp.zeros((*shape, COURSE_INPUTS)),
            jnp.zeros(shape, jnp.int32),
            jnp.zeros((*shape, -(-critic.table.size // settings.stride)), jnp.float16),
        ),
        jnp.zeros((), jnp.int32),
    )


def draw_cases(key: PRNGKeyArray, ship: ShipParams, settings: RegressionSettings) -> Case:
    """The encounters of one iteration, some of them disturbed."""
    encounter_key, seed_key = jax.random.split(key)
    cases = jax.tree.map(np.asarray, _plain(encounter_key, ship, settings))
    rng = np.random.default_rng(np.asarray(jax.random.bits(seed_key, (4,))))
    return with_random_disturbances(cases, settings.disturbed, rng)


@partial(jax.jit, static_argnums=(1, 2))
def _plain(key: PRNGKeyArray, ship: ShipParams, settings: RegressionSettings) -> Case:
    steps = settings.decisions * settings.hold_steps
    return plain_cases(settings.mix.draw(key, ship), ship, steps)


def true_costs(
    case: Case,
    state: EnvState,
    observation: Observation,
    ship: ShipParams,
    table: ManoeuvreTable,
    costs: ManoeuvreCosts,
    rows: Int[Array, " k"] | None = None,
    reaction_s: float = np.inf,
) -> Float[Array, "n k"]:
    """What each ship would cost on each manoeuvre: the label of a decision.

    Courses are counted from the bearing that is perceived and steered by the autopilot of the ship
    that is believed in. The ship that moves, the current that carries it, and the other ships'
    tracks are the true ones.

    Args:
        case: The true world.
        state: Its state now.
        observation: What the pilot sees of it.
        ship: Own ship as the pilot knows it.
        table: The manoeuvres.
        costs: What counts.
        rows: Which of the manoeuvres; by default all.
        reaction_s: Ships alter course only within so long; by default whenever they do.
    """
    bearing = waypoint_bearing_rad(observation.waypoint[0])
    own, disturbance = state.own, case.disturbance
    now_s = state.step * EnvSettings().step_s
    target = waypoint_of(case.encounter, state.leg)
    starts = case.encounter.targets.start_s
    starts = jnp.where(starts > now_s + reaction_s, jnp.inf, starts)
    encounter = eqx.tree_at(lambda e: e.targets.start_s, case.encounter, starts)

    def surroundings(time: Float[Array, ""]) -> tuple[Vector, Vector]:
        targets = targets_at(encounter, now_s + time)
        return seen(offset(own, target), time), seen(offset(own, targets), time)

    def seen(place: Vector, time: Float[Array, ""]) -> Vector:
        """From where own ship is now, carried along by the current."""
        if disturbance is not None:
            drift = disturbance.current_m_s
            place = Vector(place.x - drift.x * time, place.y - drift.y * time)
        return to_body(place, own.heading_rad)

    waypoint, place = surroundings(jnp.zeros(()))
    at = Situation(waypoint, bearing, own.rate_of_turn_rad_s, place, place)
    manoeuvres = table.at(bearing)
    if rows is not None:
        manoeuvres = jax.tree.map(lambda x: x[rows], manoeuvres)
    _, met = simulate_manoeuvres(
        manoeuvres, at, case.ship, costs, surroundings, autopilot_for(ship)
    )
    cost = -jnp.stack([m.value(case.ship.loa_m, costs) for m in met])
    return jnp.where(observation.present[:, None], cost, 0.0)


def collect_costs(
    critic: LearnedCritic,
    cases: Case,
    key: PRNGKeyArray,
    ship: ShipParams,
    settings: RegressionSettings,
) -> CostLabels:
    """Sail a batch of cases and label every decision [decision × ship of the batch].

    Args:
        critic: What steers, except where a course is drawn.
        cases: A batch of the settings' mix.
        key: Random key of the courses.
        ship: Own ship as the pilot knows it.
        settings: Decisions, and how courses are drawn.
    """
    mix = settings.mix
    ships = Packed(cases.encounter.present, mix.total_targets)
    blocks = -(-settings.decisions // settings.explore_decisions)
    drawn_key, course_key, first_key = jax.random.split(key, 3)
    shape = (blocks, mix.size)
    drawn = jax.random.bernoulli(drawn_key, settings.explore, shape)
    reach = settings.explore_rad
    courses = jax.random.uniform(course_key, shape, minval=-reach, maxval=reach)
    drawn, courses = (
        jnp.repeat(x, settings.explore_decisions, axis=0)[: settings.decisions]
        for x in (drawn, courses)
    )

    def label(case: Case, state: EnvState, observation: Observation, first: Int[Array, ""]):
        labelled = _labelled(first, critic.table.size, settings.stride)
        table, costs = critic.table, critic.costs
        return true_costs(
            case, state, observation, ship, table, costs, labelled, settings.reaction_s
        )

    def decide(state: _Sailing, given: tuple[Bool[Array, " w"], Float[Array, " w"], PRNGKeyArray]):
        observation = state[1].observation
        best = jax.vmap(lambda o: best_course(critic, o, ship))(observation)
        course = jnp.where(given[0], given[1], best)
        first = jax.random.randint(given[2], (mix.size,), 0, settings.stride)
        costs = jax.vmap(label)(cases, state[0], observation, first)
        labels = CostLabels(
            ships.to_rows(encode_courses(observation, ship)),
            ships.to_rows(jnp.broadcast_to(first[:, None], observation.present.shape)),
            jnp.log1p(ships.to_rows(costs)).astype(jnp.float16),
        )
        # A course is held by the compass, not by a bearing that changes under way.
        bearing = waypoint_bearing_rad(observation.waypoint[:, 0])
        held = course + bearing + state[0].own.heading_rad

        def sail(state: _Sailing, _: None) -> tuple[_Sailing, None]:
            return jax.vmap(lambda c, s, h: _steered(c, s, h, ship))(cases, state, held), None

        state, _ = jax.lax.scan(sail, state, length=settings.hold_steps)
        return state, labels

    start = jax.vmap(reset_case)(cases)
    assert start.perceived is not None
    keys = jax.random.split(first_key, settings.decisions)
    _, labels = jax.lax.scan(decide, (start.state, start.perceived), (drawn, courses, keys))
    return jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), labels)


def _labelled(first: Int[Array, "*b"], size: int, stride: int) -> Int[Array, "*b k"]:
    """The manoeuvres of a label: every ``stride``-th, the last one again where there is none."""
    rows = jnp.arange(0, size, stride)
    return jnp.minimum(first[..., None] + rows, size - 1)


#: The true world, and what is perceived of it.
_Sailing = tuple[EnvState, PerceivedTraffic]


def _steered(
    case: Case, state: _Sailing, course_rad: Float[Array, ""], ship: ShipParams
) -> _Sailing:
    """One step on a true course."""
    world, seen = state
    by = case.disturbance
    assert by is not None
    bearing = waypoint_bearing_rad(seen.observation.waypoint[0])
    away = wrap_angle(course_rad - world.own.heading_rad - bearing)
    rudder = rudder_towards(away, seen.observation, ship) * case.ship.rudder_limit_rad
    step_s = EnvSettings().step_s
    own = with_drift(advance(world.own, rudder, case.ship, step_s), by.current_m_s, step_s)
    after = observe_step(case.encounter, world, own, case.ship).state
    seen = next_perception(by, seen, case.encounter, own, after.leg, after.step, step_s)
    return after, seen


def cost_loss(log_cost: Float[Array, "*b"], label: Float[Array, "*b"]) -> Float[Array, "*b"]:
    """Gamma deviance of 1 + y with mean exp(f), up to what f does not change.

    Args:
        log_cost: f; below 0 it counts as 0.
        label: log(1 + y).
    """
    free = (log_cost < 0) & (label == 0)
    f = jnp.where(free, 0.0, log_cost)
    return jnp.exp(label - f) + f


def regression_iteration(
    state: RegressionState,
    cases: Case,
    key: PRNGKeyArray,
    ship: ShipParams,
    settings: RegressionSettings,
) -> tuple[RegressionState, dict[str, Float[Array, ""]]]:
    """Collect labels, add them to the dataset, and learn from it.

    Returns:
        The state after the iteration, and the mean loss of its updates.
    """
    collect_key, learn_key = jax.random.split(key)
    labels = collect_costs(state.average, cases, collect_key, ship, settings)
    dataset, filled = with_newest(state.dataset, labels, state.iteration, settings)
    optimiser = optimiser_of(settings)

    def loss(critic: LearnedCritic, rows: CostLabels) -> Float[Array, ""]:
        label = rows.log_cost.astype(jnp.float32)
        which = _labelled(rows.first, critic.table.size, settings.stride)
        log_cost = jnp.take_along_axis(critic.network(rows.inputs), which, axis=-1)
        return jnp.mean(cost_loss(log_cost, label) - 1.0 - label)  # 0 of a perfect fit

    def update(carry: Any, key: PRNGKeyArray):
        critic, average, optimiser_state, number = carry
        rows = jax.random.randint(key, (settings.batch_rows,), 0, filled * settings.iteration_rows)
        batch = jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:])[rows], dataset)
        value, gradient = eqx.filter_value_and_grad(loss)(critic, batch)
        changes, optimiser_state = optimiser.update(gradient, optimiser_state)
        critic = eqx.apply_updates(critic, changes)
        rate = jnp.maximum(settings.average_rate, 1.0 / (1.0 + 0.1 * number))
        average = optax.incremental_update(critic, average, rate)
        return (critic, average, optimiser_state, number + 1), value

    start: Any = (
        state.critic,
        state.average,
        state.optimiser,
        state.iteration * settings.updates,
    )
    keys = jax.random.split(learn_key, settings.updates)
    (critic, average, optimiser_state, _), losses = jax.lax.scan(update, start, keys)
    after = RegressionState(critic, average, optimiser_state, dataset, state.iteration + 1)
    return after, {"cost_deviance": losses.mean()}
