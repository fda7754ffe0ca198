"""Learning a critic of courses from own experience: Monte-Carlo control, head by head.

There are rewards and nothing else: no teacher, no planner, no model of own ship. Every iteration

1. draws fresh encounters (:mod:`glasshelm.training.encounter_mix`);
2. sails each by the joint argmax of the critic, decided anew every minute, up to a decision drawn
   at random; there one manoeuvre is drawn and sailed to its end, and from there the way to the
   waypoint. Half of the manoeuvres are any at all, half are near the critic's own choice: an
   argmax finds what is valued too high, so that is tried;
3. sums up, from the end backwards, what the way to the waypoint and each ship cost from every
   minute of that manoeuvre on;
4. adds these returns to the dataset of the last iterations, and fits both networks to it.

What follows a manoeuvre is always the way to the waypoint, never another decision. Own ship's way
then depends on no other ship, so the return of one ship is a function of that ship alone, and a
head can learn it exactly. With what the joint argmax would do afterwards, as in Q(λ), it could
not: the same ship costs more or less as others hem own ship in. The price is that later decisions
count as none; deciding anew every minute makes up for it.
"""

import dataclasses
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from glasshelm.core.geometry import Vector, wrap_angle
from glasshelm.encounters.types import Encounter
from glasshelm.env.observe import LENGTH_M, Observation, waypoint_bearing_rad
from glasshelm.env.rewards import course_reward
from glasshelm.env.step import FAR_M, EnvSettings, EnvState
from glasshelm.explanation.manoeuvre_explanation import choose
from glasshelm.networks.ship_batch import Packed
from glasshelm.planning.course_critic import (
    TARGET_INPUTS,
    WAYPOINT_INPUTS,
    CourseCritic,
    encode_manoeuvres,
)
from glasshelm.planning.manoeuvres import Manoeuvres
from glasshelm.planning.simulated_critic import Encountered, ManoeuvreCosts
from glasshelm.planning.situation import rudder_towards, situation_of
from glasshelm.ship.nomoto import ShipParams
from glasshelm.training.encounter_mix import EncounterMix
from glasshelm.training.iterations import optimiser_of, with_newest
from glasshelm.training.vector_env import reset_batch, step_batch


@dataclasses.dataclass(frozen=True)
class CourseLearningSettings:
    """On what experience the critic learns, and how."""

    mix: EncounterMix = dataclasses.field(
        default_factory=lambda: EncounterMix((4, 12, 24, 36, 48, 60, 72))
    )
    #: Steps between two decisions.
    hold_steps: int = 12
    #: An episode is so many decisions; returns of the first ``labelled`` are learned from, so
    #: that each sees at least the rest of them.
    decisions: int = 48
    labelled: int = 32
    #: The manoeuvre that is tried begins before this decision.
    begins_before: int = 26
    #: Share of the tried manoeuvres that are any at all, within these limits.
    explore: float = 0.5
    explore_rad: float = 2.2
    explore_s: float = 1900.0
    #: Of those, the share that keeps the present heading.
    explore_keep: float = 0.1
    #: How far the others are from the critic's choice [rad].
    near_rad: float = 0.15
    #: The dataset holds the returns of so many iterations, the newest among them.
    dataset_iterations: int = 8
    iterations: int = 60
    #: Gradient updates per iteration, each on so many rows of both networks.
    updates: int = 120
    batch_rows: int = 2048
    learning_rate: float = 3e-3
    max_gradient_norm: float = 5.0
    #: A cost valued too low weighs so much more than one valued too high.
    caution: float = 1.0
    #: The critic that is kept is the moving average at this rate, per update.
    average_rate: float = 0.005

    @property
    def iteration_env_steps(self) -> int:
        return self.mix.size * self.decisions * self.hold_steps


class Rows(eqx.Module):
    """Inputs of one network, the return [points, a cost] and the weight of each row."""

    inputs: Float[Array, "*b d"]
    cost: Float[Array, "*b"]
    weight: Float[Array, "*b"]


class Experience(eqx.Module):
    """What both networks learn from [iteration, row]."""

    waypoint: Rows
    target: Rows


class CourseState(eqx.Module):
    """Everything that an iteration starts from; ``average`` is the critic that is kept."""

    critic: CourseCritic
    average: CourseCritic
    optimiser: optax.OptState
    dataset: Experience
    iteration: Int[Array, ""]


class _Minute(eqx.Module):
    """One decision: the inputs of both networks, whether they count, what came of it."""

    waypoint: Float[Array, " w d"]
    target: Float[Array, "r e"]
    tried: Bool[Array, " w"]
    lost: Float[Array, " w"]
    met: Encountered


class _Sailing(eqx.Module):
    """A batch under way: the true course that is steered, and how long yet [s]; 0: the waypoint."""

    state: EnvState
    course_rad: Float[Array, " w"]
    left_s: Float[Array, " w"]

    def offset_rad(self) -> Float[Array, " w"]:
        """The course off the bearing of the waypoint; 0 where that is the way."""
        bearing = waypoint_bearing_rad(self.state.observation.waypoint[:, 0])
        off = wrap_angle(self.course_rad - self.state.own.heading_rad - bearing)
        return jnp.where(self.left_s > 0, off, 0.0)

    def on(self, offset_rad: Float[Array, " w"], held_s: Float[Array, " w"]) -> "_Sailing":
        """The same on another manoeuvre."""
        bearing = waypoint_bearing_rad(self.state.observation.waypoint[:, 0])
        return _Sailing(self.state, self.state.own.heading_rad + bearing + offset_rad, held_s)


def init_course(critic: CourseCritic, settings: CourseLearningSettings) -> CourseState:
    """The state before the first iteration, its dataset empty."""

    def rows(inputs: int, per_decision: int) -> Rows:
        shape = (settings.dataset_iterations, settings.labelled * per_decision)
        return Rows(jnp.zeros((*shape, inputs)), jnp.zeros(shape), jnp.zeros(shape))

    mix = settings.mix
    return CourseState(
        jax.tree.map(jnp.copy, critic),  # own copies: the state is donated
        jax.tree.map(jnp.copy, critic),
        optimiser_of(settings).init(eqx.filter(critic, eqx.is_array)),
        Experience(rows(WAYPOINT_INPUTS, mix.size), rows(TARGET_INPUTS, mix.total_targets)),
        jnp.zeros((), jnp.int32),
    )


def collect_experience(
    critic: CourseCritic,
    encounters: Encounter,
    key: PRNGKeyArray,
    ship: ShipParams,
    settings: CourseLearningSettings,
) -> Experience:
    """Sail a batch of encounters, one manoeuvre tried in each, and sum up what came of it.

    Args:
        critic: What steers until a manoeuvre is tried.
        encounters: A batch of the settings' mix.
        key: Random key that draws when which manoeuvre is tried.
        ship: Own ship; the critic uses its speed and the autopilot steers it.
        settings: Decisions and exploration.
    """
    begin_key, course_key, held_key, kind_key = jax.random.split(key, 4)
    size = (settings.mix.size,)
    begins = jax.random.randint(begin_key, size, 0, settings.begins_before)
    course = jax.random.uniform(course_key, size, minval=-1.0, maxval=1.0)
    held = jax.random.uniform(held_key, size)
    kind = jax.random.uniform(kind_key, size)
    free, keep = kind < settings.explore, kind < settings.explore * settings.explore_keep
    rows = Packed(encounters.present, settings.mix.total_targets)

    def choices(observation: Observation) -> tuple[Array, Array]:
        return jax.vmap(lambda o: _best(critic, o, ship))(observation)

    def decide(at: _Sailing, number: Int[Array, ""]) -> tuple[_Sailing, _Minute]:
        observation = at.state.observation
        deciding = number < settings.begins_before
        nothing = (jnp.zeros(size), jnp.zeros(size))
        off, held_s = jax.lax.cond(deciding, choices, lambda _: nothing, observation)
        bearing = waypoint_bearing_rad(observation.waypoint[:, 0])
        any_rad = jnp.where(keep, -bearing, settings.explore_rad * course)
        tried = at.on(
            jnp.where(free, any_rad, off + settings.near_rad * course),
            jnp.where(free, settings.explore_s * held, held_s * (0.5 + held)),
        )
        at = _where(number < begins, at.on(off, held_s), _where(number == begins, tried, at))
        inputs = jax.vmap(lambda o, off, left: _inputs(o, off, left, ship))(
            observation, at.offset_rad(), at.left_s
        )
        at, lost, met = _sail_on(at, encounters, ship, critic.costs, settings.hold_steps)
        return at, _Minute(inputs[0], rows.to_rows(inputs[1]), number >= begins, lost, met)

    start = _Sailing(reset_batch(encounters, ship), jnp.zeros(size), jnp.zeros(size))
    _, minutes = jax.lax.scan(decide, start, jnp.arange(settings.decisions))
    lost = jnp.cumsum(minutes.lost[::-1], axis=0)[::-1]
    met = jax.lax.associative_scan(Encountered.followed_by, minutes.met, reverse=True)
    cost = -met.value(ship.loa_m, critic.costs)
    tried = minutes.tried.astype(jnp.float32)
    by_row = jax.vmap(rows.to_rows)
    weight = by_row(jnp.broadcast_to(tried[..., None], cost.shape))
    experience = Experience(
        Rows(minutes.waypoint, lost, tried), Rows(minutes.target, by_row(cost), weight)
    )
    return jax.tree.map(lambda x: x[: settings.labelled].reshape(-1, *x.shape[2:]), experience)


def _best(
    critic: CourseCritic, observation: Observation, ship: ShipParams
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Course and duration of the joint argmax."""
    manoeuvres, values = critic(observation, ship)
    best = choose(values)
    return manoeuvres.offset_rad[best], manoeuvres.duration_s[best]


def _inputs(
    observation: Observation,
    offset_rad: Float[Array, ""],
    held_s: Float[Array, ""],
    ship: ShipParams,
) -> tuple[Float[Array, " d"], Float[Array, "n e"]]:
    """What both networks see of one manoeuvre."""
    zero = jnp.zeros(1)
    one = Manoeuvres(offset_rad[None], held_s[None], zero, zero)
    waypoint, targets = encode_manoeuvres(one, situation_of(observation, ship), ship)
    return waypoint[0], targets[0]


def _sail_on(
    at: _Sailing, encounters: Encounter, ship: ShipParams, costs: ManoeuvreCosts, steps: int
) -> tuple[_Sailing, Float[Array, " w"], Encountered]:
    """Sail on until the next decision: what of Eq. 17 was lost, and what was met of each ship."""

    def step(carry: tuple[_Sailing, Array, Encountered], _: None):
        at, lost, met = carry
        off, observation = at.offset_rad(), at.state.observation
        rudder = jax.vmap(lambda c, o: rudder_towards(c, o, ship))(off, observation)
        state = step_batch(encounters, at.state, rudder, ship).state
        bearing = waypoint_bearing_rad(state.observation.waypoint[:, 0])
        lost = lost + course_reward(jnp.zeros(())) - course_reward(bearing)
        met = jax.vmap(lambda m, o: m.and_then(_places(o), ship.loa_m, costs))(
            met, state.observation
        )
        left_s = jnp.maximum(at.left_s - EnvSettings().step_s, 0.0)
        return (_Sailing(state, at.course_rad, left_s), lost, met), None

    nothing = jax.vmap(Encountered.nothing)(jnp.zeros(encounters.present.shape))
    carry, _ = jax.lax.scan(step, (at, jnp.zeros(at.left_s.shape), nothing), length=steps)
    return carry


def _places(observation: Observation) -> Vector:
    """Where each ship is [m] (starboard, ahead); absent ones far ahead."""
    place = observation.targets[:, 0, :2] * LENGTH_M
    return Vector(place[:, 0], jnp.where(observation.present, place[:, 1], FAR_M))


def _where(condition: Bool[Array, " w"], yes: _Sailing, no: _Sailing) -> _Sailing:
    """One of two courses, in the same state."""
    return _Sailing(
        yes.state,
        jnp.where(condition, yes.course_rad, no.course_rad),
        jnp.where(condition, yes.left_s, no.left_s),
    )


def course_loss(log_cost: Float[Array, " b"], rows: Rows, caution: float = 0.0) -> Float[Array, ""]:
    """Mean square error of log(1 + cost); below 0 is right where there is no cost.

    Args:
        log_cost: What a network says of the rows.
        rows: What came of them.
        caution: A cost said too low weighs so much more than one said too high.
    """
    label = jnp.log1p(rows.cost)
    error = jnp.where(rows.cost > 0, log_cost, jnp.maximum(log_cost, 0.0)) - label
    weight = rows.weight * jnp.where(error < 0, 1.0 + caution, 1.0)
    return jnp.sum(weight * error**2) / jnp.maximum(jnp.sum(rows.weight), 1.0)


def course_iteration(
    state: CourseState, key: PRNGKeyArray, ship: ShipParams, settings: CourseLearningSettings
) -> tuple[CourseState, dict[str, Float[Array, ""]]]:
    """Collect experience, add it to the dataset, and learn from it.

    Returns:
        The state after the iteration, and the mean losses of its updates.
    """
    draw_key, collect_key, learn_key = jax.random.split(key, 3)
    encounters = settings.mix.draw(draw_key, ship)
    new = collect_experience(state.average, encounters, collect_key, ship, settings)
    dataset, filled = with_newest(state.dataset, new, state.iteration, settings)
    optimiser = optimiser_of(settings)

    def drawn(rows: Rows, number: int, key: PRNGKeyArray) -> Rows:
        at = jax.random.randint(key, (number,), 0, filled * rows.cost.shape[1])
        return jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:])[at], rows)

    def loss(critic: CourseCritic, experience: Experience):
        of_waypoint = course_loss(
            critic.of_waypoint(experience.waypoint.inputs)[:, 0], experience.waypoint
        )
        of_target = course_loss(
            critic.of_target(experience.target.inputs)[:, 0], experience.target, settings.caution
        )
        return of_waypoint + of_target, {"waypoint_error": of_waypoint, "ship_error": of_target}

    def update(carry: Any, key: PRNGKeyArray):
        critic, average, optimiser_state, number = carry
        waypoint_key, target_key = jax.random.split(key)
        batch = Experience(
            drawn(dataset.waypoint, settings.batch_rows // 4, waypoint_key),
            drawn(dataset.target, settings.batch_rows, target_key),
        )
        gradient, losses = jax.grad(loss, has_aux=True)(critic, batch)
        changes, optimiser_state = optimiser.update(gradient, optimiser_state)
        critic = eqx.apply_updates(critic, changes)
        rate = jnp.maximum(settings.average_rate, 1.0 / (1.0 + 0.1 * number))
        average = optax.incremental_update(critic, average, rate)
        return (critic, average, optimiser_state, number + 1), losses

    start: Any = (
        state.critic, state.average, state.optimiser, state.iteration * settings.updates
    )  # fmt: skip
    keys = jax.random.split(learn_key, settings.updates)
    (critic, average, optimiser_state, _), losses = jax.lax.scan(update, start, keys)
    after = CourseState(critic, average, optimiser_state, dataset, state.iteration + 1)
    return after, jax.tree.map(jnp.mean, losses)
