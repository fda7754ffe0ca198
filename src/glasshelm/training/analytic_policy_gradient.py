"""The strong way to a pilot: gradients through the differentiable world.

Every iteration sails a batch of encounters with the present actor, asks the
world's adjoint how the smoothed return would change with each rudder command
of each of these voyages, and moves the actor's outputs that way:

    ∇θ J = Σ_t  ∂J/∂a_t · ∂π(s_t)/∂θ

The commands after t are held fixed in ∂J/∂a_t (``feedback=False``). The
gradient then runs through the ship alone, where it cannot explode, and the
actor is differentiated in one large batch. A pilot at which this gradient
vanishes steers voyages that no small change of any command improves. With
``feedback=True`` the gradient also runs through what the actor sees; it is
exact, dearer, and chaotic over long voyages (docs/explanation/training.md).
"""

import dataclasses
from typing import cast

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from glasshelm.core.geometry import Vector, direction, wrap_angle
from glasshelm.encounters.random_encounters import (
    CONVERGING,
    PAPER,
    WIDE,
    RandomEncounters,
    random_encounter,
)
from glasshelm.encounters.types import Encounter
from glasshelm.env.observe import Observation, waypoint_bearing_rad
from glasshelm.env.rewards import course_reward
from glasshelm.env.step import (
    EnvSettings,
    EnvState,
    margins,
    next_leg,
    reset,
    step,
    targets_at,
    waypoint_of,
)
from glasshelm.networks.actors import Actor
from glasshelm.networks.ship_batch import Packed
from glasshelm.ship.nomoto import ShipParams, ShipState, advance, ship_named
from glasshelm.training.losses import polyak


@dataclasses.dataclass(frozen=True)
class AnalyticSettings:
    """Which encounters, how long, what is good, and how fast to learn."""

    #: Worlds with 0, 1, 2, ... ships in every batch.
    worlds_by_count: tuple[int, ...] = (4, 10, 16, 20, 24, 26, 28)
    encounters: RandomEncounters = WIDE
    #: In turn with these, world by world: half of all begin as in the paper.
    beside: tuple[RandomEncounters, ...] = (PAPER, CONVERGING, PAPER)
    decisions: int = 160
    #: A command is held for this many steps while training.
    hold: int = 3
    #: Weight, margin and softness of the penalty on Eq. 13 unclipped.
    danger_weight: float = 2.0
    danger_margin: float = 0.6
    danger_softness: float = 0.08
    #: Cost of the rudder's square and of its change, as fractions of the limit.
    rudder_cost: float = 0.03
    swing_cost: float = 0.15
    #: Pull of every rudder towards amidships, beside the adjoint's. The adjoint does
    #: not know that the actor will answer to what it sees, and alone it oversteers.
    rudder_pull: float = 0.003
    #: A voyage's adjoint a is scaled to a / (norm(a) + this): one hopeless
    #: encounter must not outweigh a hundred others.
    adjoint_scale: float = 1000.0
    #: Begin with this preset ship and change her gradually into the one that is
    #: trained for, K and T on a logarithmic scale, between these iterations.
    from_ship: str | None = None
    blend: tuple[int, int] = (0, 450)
    #: Differentiate through what the actor sees as well.
    feedback: bool = False
    iterations: int = 3000
    learning_rate: float = 1e-3
    gradient_norm: float = 1.0
    #: The pilot that is kept is the moving average of the actor at this rate.
    average_rate: float = 0.01

    @property
    def worlds(self) -> int:
        return sum(self.worlds_by_count)

    @property
    def ships(self) -> int:
        return sum(n * worlds for n, worlds in enumerate(self.worlds_by_count))

    @property
    def pairs(self) -> int:
        return sum(n * n * worlds for n, worlds in enumerate(self.worlds_by_count))


def draw_batch(key: PRNGKeyArray, ship: ShipParams, settings: AnalyticSettings) -> Encounter:
    """A batch of encounters with exactly the settings' numbers of ships."""
    counts = jnp.repeat(
        jnp.arange(len(settings.worlds_by_count)),
        jnp.array(settings.worlds_by_count),
        total_repeat_length=settings.worlds,
    )
    keys = jax.random.split(key, settings.worlds)

    def draw(encounters: RandomEncounters) -> Encounter:
        return jax.vmap(lambda k, n: random_encounter(k, ship, encounters, n))(keys, counts)

    turn = jnp.arange(settings.worlds) % (1 + len(settings.beside))
    batch = draw(settings.encounters)
    for number, other in enumerate(settings.beside, 1):
        drawn = draw(dataclasses.replace(other, targets=settings.encounters.targets))
        batch = jax.tree.map(
            lambda a, b, n=number: jnp.where((turn == n).reshape(-1, *[1] * (a.ndim - 1)), b, a),
            batch,
            drawn,
        )
    return batch


def smooth_reward(
    bearing_rad: Float[Array, ""], margin: Float[Array, " n"], settings: AnalyticSettings
) -> Float[Array, ""]:
    """Eq. 17 minus a softplus of the danger (Eq. 13 before the clip), smooth where Eq. 16 jumps."""
    soft = settings.danger_softness
    depth = jax.nn.softplus((margin + settings.danger_margin) / soft) * soft
    return course_reward(bearing_rad) - settings.danger_weight * depth.sum()


class _Held(eqx.Module):
    reward: Float[Array, "*b"]
    worst: Float[Array, "*b"]  # largest margin (Eq. 13 unclipped)


def hold(
    encounter: Encounter,
    state: EnvState,
    action: Float[Array, ""],
    ship: ShipParams,
    settings: AnalyticSettings,
) -> tuple[EnvState, _Held]:
    """The state after holding one command, and what happened on the way."""

    def once(state: EnvState, _: None):
        out = step(encounter, state, action * ship.rudder_limit_rad, ship, EnvSettings())
        bearing = waypoint_bearing_rad(out.state.observation.waypoint[0])
        reward = smooth_reward(bearing, out.margin, settings)
        return out.state, _Held(reward, jnp.max(out.margin, initial=-jnp.inf))

    state, held = jax.lax.scan(once, state, None, length=settings.hold)
    return state, _Held(held.reward.sum(), held.worst.max())


def _rudder_cost(actions: Float[Array, "*b t"], settings: AnalyticSettings) -> Float[Array, "*b"]:
    swings = jnp.diff(actions, axis=-1)
    return settings.hold * (
        settings.rudder_cost * (actions**2).sum(-1) + settings.swing_cost * (swings**2).sum(-1)
    )


def voyage_return(
    encounter: Encounter,
    actions: Float[Array, " t"],
    ship: ShipParams,
    settings: AnalyticSettings,
) -> Float[Array, ""]:
    """Smooth return of one encounter under a fixed sequence of commands (open loop).

    The same sum as :func:`sail`'s, but of the ship and the targets alone: what
    she would see on the way is not needed, and is most of the work.
    """
    world = EnvSettings()

    def go(carry: tuple[ShipState, Int[Array, ""], Int[Array, ""]], action: Float[Array, ""]):
        own, leg, count = carry
        own, count = advance(own, action * ship.rudder_limit_rad, ship, world.step_s), count + 1
        leg, _ = next_leg(encounter, leg, own, world)
        waypoint = waypoint_of(encounter, leg)
        to_waypoint = Vector(waypoint.x - own.east_m, waypoint.y - own.north_m)
        bearing = wrap_angle(direction(to_waypoint) - own.heading_rad)
        margin = margins(own, targets_at(encounter, count * world.step_s), ship)
        return (own, leg, count), smooth_reward(bearing, margin, settings)

    commands, zero = jnp.repeat(actions, settings.hold), jnp.zeros((), jnp.int32)
    _, rewards = jax.lax.scan(go, (encounter.own, zero, zero), commands)
    return rewards.sum() - _rudder_cost(actions, settings)


class Voyages(eqx.Module):
    """A batch of voyages: smooth return, and the deepest margin (Eq. 13 unclipped) of each."""

    returns: Float[Array, " w"]
    worst: Float[Array, " w"]

    @property
    def intruded(self) -> Bool[Array, " w"]:
        return self.worst > 0


class Log(eqx.Module):
    """What happened on a batch of voyages, decision by decision [t, w]: seen and done."""

    observation: Observation
    actions: Float[Array, "*t w"]


def sail(
    actor: Actor, batch: Encounter, ship: ShipParams, settings: AnalyticSettings
) -> tuple[Log, Voyages]:
    """Sail a batch under the actor."""
    fleet = Packed(batch.present, settings.ships, settings.pairs)

    def go(state: EnvState, _: None):
        action = actor(state.observation, fleet)
        after, held = jax.vmap(lambda e, s, a: hold(e, s, a, ship, settings))(batch, state, action)
        return after, (Log(state.observation, action), held)

    start = jax.vmap(lambda e: reset(e, ship))(batch)
    _, (log, held) = jax.lax.scan(go, start, None, length=settings.decisions)
    returns = held.reward.sum(0) - _rudder_cost(log.actions.T, settings)
    return log, Voyages(returns, held.worst.max(0))


def policy_gradient(
    actor: Actor, batch: Encounter, ship: ShipParams, settings: AnalyticSettings
) -> tuple[Actor, Voyages]:
    """Gradient of the *negative* mean smooth return over the actor, and the voyages sailed."""
    if settings.feedback:
        return _exact_gradient(actor, batch, ship, settings)
    log, voyages = sail(actor, batch, ship, settings)
    adjoint = jax.vmap(jax.grad(lambda a, e: voyage_return(e, a, ship, settings)))(
        log.actions.T, batch
    )
    length = jnp.linalg.norm(adjoint, axis=-1, keepdims=True)
    pull = adjoint / (length + settings.adjoint_scale)
    fleet = Packed(batch.present, settings.ships, settings.pairs)

    def loss(actor: Actor, pull: Float[Array, " w"], observation: Observation) -> Float[Array, ""]:
        action = actor(observation, fleet)
        return jnp.mean(settings.rudder_pull * action**2 - pull * action)

    def add(gradient: Actor, decision: tuple[Float[Array, " w"], Observation]):
        return jax.tree.map(jnp.add, gradient, jax.grad(loss)(actor, *decision)), None

    # Decision by decision: the activations of one fit the cache, those of all do not.
    nothing = jax.tree.map(jnp.zeros_like, actor)
    gradient, _ = jax.lax.scan(add, nothing, (pull.T, log.observation))
    return gradient, voyages


def _exact_gradient(
    actor: Actor, batch: Encounter, ship: ShipParams, settings: AnalyticSettings
) -> tuple[Actor, Voyages]:
    fleet = Packed(batch.present, settings.ships, settings.pairs)

    def loss(actor: Actor) -> tuple[Float[Array, ""], Voyages]:
        @jax.checkpoint
        def go(state: EnvState, _: None):
            action = actor(state.observation, fleet)
            after, held = jax.vmap(lambda e, s, a: hold(e, s, a, ship, settings))(
                batch, state, action
            )
            return after, (action, held)

        start = jax.vmap(lambda e: reset(e, ship))(batch)
        _, (actions, held) = jax.lax.scan(go, start, None, length=settings.decisions)
        returns = held.reward.sum(0) - _rudder_cost(actions.T, settings)
        return -returns.mean(), Voyages(returns, held.worst.max(0))

    return jax.grad(loss, has_aux=True)(actor)


class AnalyticState(eqx.Module):
    """Everything that an iteration starts from; ``average`` is the pilot that is kept."""

    actor: Actor
    average: Actor
    optimiser: optax.OptState
    batch: Encounter
    iteration: Int[Array, ""]


def start_training(
    actor: Actor, key: PRNGKeyArray, ship: ShipParams, settings: AnalyticSettings
) -> AnalyticState:
    """The state before the first iteration."""
    return AnalyticState(
        actor,
        jax.tree.map(jnp.copy, actor),
        _optimiser(settings).init(eqx.filter(actor, eqx.is_array)),
        draw_batch(key, ship, settings),
        jnp.zeros((), jnp.int32),
    )


def iterate(
    state: AnalyticState, key: PRNGKeyArray, ship: ShipParams, settings: AnalyticSettings
) -> tuple[AnalyticState, Voyages]:
    """One iteration: sail, step the actor, draw the next encounters."""
    ship = ship_at(state.iteration, ship, settings)
    gradient, voyages = policy_gradient(state.actor, state.batch, ship, settings)
    descent = cast(optax.Updates, gradient)
    updates, optimiser = _optimiser(settings).update(descent, state.optimiser)
    actor = eqx.apply_updates(state.actor, updates)
    warm = 1.0 / (1.0 + state.iteration)  # the first iterations are averaged evenly
    rate = jnp.maximum(settings.average_rate, warm)
    average = polyak(state.average, actor, rate)
    batch = draw_batch(key, ship, settings)
    return AnalyticState(actor, average, optimiser, batch, state.iteration + 1), voyages


def ship_at(iteration: Int[Array, ""], ship: ShipParams, settings: AnalyticSettings) -> ShipParams:
    """The ship that an iteration sails: on her way from ``settings.from_ship`` to ``ship``."""
    if settings.from_ship is None:
        return ship
    first, (begin_at, end_at) = ship_named(settings.from_ship), settings.blend
    done = jnp.clip((iteration - begin_at) / max(end_at - begin_at, 1), 0.0, 1.0)

    def between(a: float | Float[Array, ""], b: float | Float[Array, ""]) -> Float[Array, ""]:
        return jnp.exp((1 - done) * jnp.log(a) + done * jnp.log(b))

    return dataclasses.replace(
        ship,
        gain_1_s=between(first.gain_1_s, ship.gain_1_s),
        time_constant_s=between(first.time_constant_s, ship.time_constant_s),
    )


def _optimiser(settings: AnalyticSettings) -> optax.GradientTransformation:
    schedule = optax.warmup_cosine_decay_schedule(
        0.1 * settings.learning_rate,
        settings.learning_rate,
        min(50, settings.iterations // 10 + 1),
        settings.iterations,
        0.02 * settings.learning_rate,
    )
    return optax.chain(optax.clip_by_global_norm(settings.gradient_norm), optax.adam(schedule))
