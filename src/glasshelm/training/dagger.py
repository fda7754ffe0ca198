"""A first pilot from a teacher who plans: what side to pass on is learned here.

Gradients through the world (:mod:`glasshelm.training.analytic_policy_gradient`) improve the
manoeuvre that an actor makes, but never tell it that the manoeuvre to the other
side would have been better. The teacher does: it tries 763
manoeuvres in simulation (:mod:`glasshelm.planning.course_planner`). Every iteration

1. draws fresh encounters, of which a share are the *hardest of several*: those in
   which the actor, sailing each of them alone, came nearest to a ship's domain or
   deepest into it (prioritised by its own failures, and always by its present ones);
2. sails them, mostly under the actor itself, some stretches under the teacher
   (DAgger, Ross et al. 2011: the actor is taught where *it* goes);
3. asks the teacher at every stretch for the course to steer, and labels every
   decision with the rudder that would steer it;
4. regresses the actor's rudder on the labels, decisions weighted by what is at
   stake: where left is as good as right, the label says little.
"""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, Int, PRNGKeyArray

from glasshelm.encounters.types import Encounter
from glasshelm.env.observe import Observation, empty_observation
from glasshelm.env.step import EnvState, reset, step
from glasshelm.networks.actors import Actor
from glasshelm.networks.ship_batch import Packed
from glasshelm.planning.course_planner import (
    CourseSettings,
    agreeing,
    plan_course,
    rudder_to,
    stakes,
)
from glasshelm.ship.nomoto import ShipParams
from glasshelm.training.analytic_policy_gradient import AnalyticSettings, draw_batch, sail
from glasshelm.training.losses import polyak


@dataclasses.dataclass(frozen=True)
class ImitationSettings:
    """How the teacher plans, how often, and how the actor learns from it.

    The encounters are those of :class:`AnalyticSettings`; 0 iterations: no teacher.
    """

    teacher: CourseSettings = dataclasses.field(default_factory=CourseSettings)
    #: Stretches of a voyage, decisions in each, steps that a decision is held.
    stretches: int = 40
    decisions: int = 4
    hold: int = 3
    #: Share of the stretches that the actor steers, after the first iterations.
    actor_share: float = 0.8
    share_from: int = 20
    #: A decision with stakes s weighs (s + 0.1·scale) / (s + scale).
    stakes_scale: float = 3.0
    #: The teacher agrees with the actor's own choice while it costs at most this (in return).
    tolerance: float = 0.0
    #: Errors of the rudder count by their square up to this, by their size beyond: between
    #: labels to both sides the actor then takes one, where the square would take the mean.
    even_until: float = 0.2
    #: Batches of voyages that are remembered, the newest among them.
    kept: int = 4
    #: Share of the voyages that are the hardest of so many encounters for the actor.
    hard_share: float = 0.0
    hardest_of: int = 4
    iterations: int = 200
    updates: int = 100
    #: Instants (of all worlds of a batch) in one update.
    instants: int = 8
    learning_rate: float = 1e-3
    gradient_norm: float = 1.0
    #: The pilot that is kept is the moving average of the actor at this rate, per update.
    average_rate: float = 0.002


class Lessons(eqx.Module):
    """What was seen, what the teacher would have done, how much it mattered [batch, t, world]."""

    observation: Observation
    rudder: Float[Array, "*b w"]
    weight: Float[Array, "*b w"]


class ImitationState(eqx.Module):
    """Everything that an iteration starts from; ``average`` is the pilot that is kept."""

    actor: Actor
    average: Actor
    optimiser: optax.OptState
    lessons: Lessons
    iteration: Int[Array, ""]


class Lesson(eqx.Module):
    """What one iteration reports: the mean loss of the rudder."""

    error: Float[Array, ""]


def start_imitation(
    actor: Actor, analytic: AnalyticSettings, settings: ImitationSettings, slots: int
) -> ImitationState:
    """The state before the first iteration: no lessons yet."""
    shape = (settings.kept, settings.stretches * settings.decisions, analytic.worlds)
    observation = jax.tree.map(
        lambda x: jnp.zeros((*shape, *x.shape), x.dtype), empty_observation(slots)
    )
    lessons = Lessons(observation, jnp.zeros(shape), jnp.zeros(shape))
    return ImitationState(
        jax.tree.map(jnp.copy, actor),  # own copies: the state is donated
        jax.tree.map(jnp.copy, actor),
        _optimiser(settings).init(eqx.filter(actor, eqx.is_array)),
        lessons,
        jnp.zeros((), jnp.int32),
    )


def draw_lessons(
    actor: Actor,
    key: PRNGKeyArray,
    ship: ShipParams,
    analytic: AnalyticSettings,
    settings: ImitationSettings,
) -> Encounter:
    """A batch of encounters, a share of them the hardest of several for this actor [w].

    The numbers of ships are those of :func:`draw_batch`: candidates compete with
    others of as many ships. The hardest has the largest margin of its voyage (Eq. 13
    unclipped).
    """
    if not settings.hard_share:
        return draw_batch(key, ship, analytic)
    share_key, *keys = jax.random.split(key, 1 + settings.hardest_of)

    def try_out(key: PRNGKeyArray) -> tuple[Encounter, Float[Array, " w"]]:
        batch = draw_batch(key, ship, analytic)
        return batch, sail(actor, batch, ship, analytic)[1].worst

    candidates, worst = jax.lax.map(try_out, jnp.stack(keys))
    hard = jax.random.bernoulli(share_key, settings.hard_share, worst.shape[1:])
    chosen = jnp.where(hard, worst.argmax(0), 0)
    return jax.tree.map(lambda x: x[chosen, jnp.arange(chosen.size)], candidates)


def teach(
    actor: Actor,
    batch: Encounter,
    share: Float[Array, ""],
    key: PRNGKeyArray,
    ship: ShipParams,
    fleet: Packed,
    settings: ImitationSettings,
) -> Lessons:
    """Sail a batch, the actor steering a ``share`` of the stretches: lessons [t, w]."""
    worlds = batch.present.shape[0]

    def hold(e: Encounter, state: EnvState, action: Float[Array, ""]) -> EnvState:
        def once(state: EnvState, _: None):
            return step(e, state, action * ship.rudder_limit_rad, ship).state, None

        return jax.lax.scan(once, state, None, length=settings.hold)[0]

    def stretch(state: EnvState, key: PRNGKeyArray):
        plan = jax.vmap(lambda s: plan_course(s, ship, settings.teacher))(state.observation)
        at_stake = jax.vmap(lambda p, s: stakes(p, s, ship))(plan, state.observation)
        weight = (at_stake + 0.1 * settings.stakes_scale) / (at_stake + settings.stakes_scale)
        if settings.tolerance:
            own = actor(state.observation, fleet)
            plan = jax.vmap(lambda p, a, s: agreeing(p, a, s, ship, settings.tolerance))(
                plan, own, state.observation
            )
        steers = jax.random.bernoulli(key, share, (worlds,))

        def decide(state: EnvState, _: None):
            observation = state.observation
            label = jax.vmap(lambda o, s: rudder_to(o, s, ship))(plan.offset_rad, observation)
            action = jnp.where(steers, actor(observation, fleet), label)
            return jax.vmap(hold)(batch, state, action), Lessons(observation, label, weight)

        return jax.lax.scan(decide, state, None, length=settings.decisions)

    start = jax.vmap(lambda e: reset(e, ship))(batch)
    _, lessons = jax.lax.scan(stretch, start, jax.random.split(key, settings.stretches))
    return jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), lessons)


def imitate(
    state: ImitationState,
    key: PRNGKeyArray,
    ship: ShipParams,
    analytic: AnalyticSettings,
    settings: ImitationSettings,
) -> tuple[ImitationState, Lesson]:
    """One iteration: sail and be taught, then learn from the lessons kept."""
    draw_key, sail_key, learn_key = jax.random.split(key, 3)
    batch = draw_lessons(state.actor, draw_key, ship, analytic, settings)
    fleet = Packed(batch.present, analytic.ships, analytic.pairs)
    ramp = jnp.minimum(1.0, state.iteration / settings.share_from)
    fresh = teach(state.actor, batch, settings.actor_share * ramp, sail_key, ship, fleet, settings)
    place = state.iteration % settings.kept
    lessons = jax.tree.map(lambda all_, new: all_.at[place].set(new), state.lessons, fresh)
    filled = jnp.minimum(state.iteration + 1, settings.kept)
    optimiser = _optimiser(settings)

    def loss(actor: Actor, lesson: Lessons) -> Float[Array, ""]:
        error = actor(lesson.observation, fleet) - lesson.rudder
        return jnp.mean(lesson.weight * optax.losses.huber_loss(error, delta=settings.even_until))

    def update(carry: tuple[Actor, Actor, optax.OptState], key: PRNGKeyArray):
        actor, average, memory = carry
        batch_key, time_key = jax.random.split(key)
        batches = jax.random.randint(batch_key, (settings.instants,), 0, filled)
        times = jax.random.randint(time_key, (settings.instants,), 0, lessons.rudder.shape[1])

        def add(carry, where):
            lesson = jax.tree.map(lambda x: x[where], lessons)
            value, gradient = jax.value_and_grad(loss)(actor, lesson)
            return jax.tree.map(jnp.add, carry, (value, gradient)), None

        nothing = (jnp.zeros(()), jax.tree.map(jnp.zeros_like, actor))
        (value, gradient), _ = jax.lax.scan(add, nothing, (batches, times))
        gradient = jax.tree.map(lambda g: g / settings.instants, gradient)
        steps, memory = optimiser.update(gradient, memory)
        actor = eqx.apply_updates(actor, steps)
        warm = 1.0 / (1.0 + state.iteration * settings.updates)  # at first the mean, evenly
        rate = jnp.maximum(settings.average_rate, warm)
        return (actor, polyak(average, actor, rate), memory), value / settings.instants

    start = (state.actor, state.average, state.optimiser)
    (actor, average, memory), errors = jax.lax.scan(
        update, start, jax.random.split(learn_key, settings.updates)
    )
    return (
        ImitationState(actor, average, memory, lessons, state.iteration + 1),
        Lesson(errors.mean()),
    )


def _optimiser(settings: ImitationSettings) -> optax.GradientTransformation:
    updates = settings.iterations * settings.updates
    schedule = optax.warmup_cosine_decay_schedule(
        0.1 * settings.learning_rate,
        settings.learning_rate,
        min(300, updates // 10 + 1),
        max(updates, 2),
        0.02 * settings.learning_rate,
    )
    return optax.chain(optax.clip_by_global_norm(settings.gradient_norm), optax.adam(schedule))
