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
exact, dearer, and chaotic over long voyages (docs/algorithms/fast.md).
"""

import dataclasses

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from glasshelm.encounters.random import WIDE, RandomEncounters, random_encounter
from glasshelm.encounters.types import Encounter
from glasshelm.networks.actors import Actor
from glasshelm.networks.fleet import Packed
from glasshelm.ships import ShipParams
from glasshelm.world.observe import Observation, waypoint_bearing_rad
from glasshelm.world.rewards import course_reward
from glasshelm.world.step import WorldSettings, WorldState, begin, step


@dataclasses.dataclass(frozen=True)
class AnalyticSettings:
    """One iteration: which encounters, how long, what is good."""

    #: Worlds with 0, 1, 2, ... ships in every batch.
    worlds_by_count: tuple[int, ...] = (4, 10, 16, 20, 24, 26, 28)
    encounters: RandomEncounters = WIDE
    decisions: int = 120
    #: A command is held for this many steps while training.
    hold: int = 3
    #: Weight, margin and softness of the penalty on Eq. 13 unclipped.
    danger_weight: float = 3.0
    danger_margin: float = 0.08
    danger_softness: float = 0.04
    #: Cost of the rudder's square and of its change, as fractions of the limit.
    rudder_cost: float = 0.002
    swing_cost: float = 0.01
    feedback: bool = False

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
    return jax.vmap(lambda k, n: random_encounter(k, ship, settings.encounters, n))(keys, counts)


def smooth_reward(
    bearing_rad: Float[Array, ""], margin: Float[Array, " n"], settings: AnalyticSettings
) -> Float[Array, ""]:
    """Eq. 17 minus a softplus of the danger (Eq. 13 before the clip), smooth where Eq. 16 jumps."""
    soft = settings.danger_softness
    depth = jax.nn.softplus((margin + settings.danger_margin) / soft) * soft
    return course_reward(bearing_rad) - settings.danger_weight * depth.sum()


def _hold(
    encounter: Encounter,
    state: WorldState,
    action: Float[Array, ""],
    ship: ShipParams,
    settings: AnalyticSettings,
) -> tuple[WorldState, Float[Array, ""]]:
    """The state after holding one command, and the smooth reward on the way."""

    def once(state: WorldState, _: None):
        out = step(encounter, state, action * ship.rudder_limit_rad, ship, WorldSettings())
        bearing = waypoint_bearing_rad(out.state.observation.waypoint[0])
        return out.state, smooth_reward(bearing, out.margin, settings)

    state, rewards = jax.lax.scan(once, state, None, length=settings.hold)
    return state, rewards.sum()


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
    """Smooth return of one encounter under a fixed sequence of commands (open loop)."""

    def go(state: WorldState, action: Float[Array, ""]):
        return _hold(encounter, state, action, ship, settings)

    _, rewards = jax.lax.scan(go, begin(encounter, ship), actions)
    return rewards.sum() - _rudder_cost(actions, settings)


def sail(
    actor: Actor, batch: Encounter, ship: ShipParams, settings: AnalyticSettings
) -> tuple[Observation, Float[Array, "w t"], Float[Array, " w"]]:
    """Sail a batch under the actor: what it saw, what it did [w, t], the smooth returns."""
    fleet = Packed(batch.present, settings.ships, settings.pairs)

    def go(state: WorldState, _: None):
        action = actor(state.observation, fleet)
        after, reward = jax.vmap(lambda e, s, a: _hold(e, s, a, ship, settings))(
            batch, state, action
        )
        return after, (state.observation, action, reward)

    start = jax.vmap(lambda e: begin(e, ship))(batch)
    _, (seen, actions, rewards) = jax.lax.scan(go, start, None, length=settings.decisions)
    actions = actions.T
    return seen, actions, rewards.sum(0) - _rudder_cost(actions, settings)


def policy_gradient(
    actor: Actor, batch: Encounter, ship: ShipParams, settings: AnalyticSettings
) -> tuple[Actor, Float[Array, ""]]:
    """Gradient of the *negative* mean smooth return over the actor, and that return."""
    if settings.feedback:
        return _exact_gradient(actor, batch, ship, settings)
    seen, actions, returns = sail(actor, batch, ship, settings)
    adjoint = jax.vmap(jax.grad(lambda a, e: voyage_return(e, a, ship, settings)))(actions, batch)
    adjoint = jax.lax.stop_gradient(adjoint / settings.worlds).T  # [t, w], as `seen` is

    def pull(actor: Actor) -> Float[Array, ""]:
        flat = jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), seen)
        fleet = Packed(
            flat.present,
            settings.ships * settings.decisions,
            settings.pairs * settings.decisions,
        )
        return -jnp.sum(adjoint.reshape(-1) * actor(flat, fleet))

    return jax.grad(pull)(actor), returns.mean()


def _exact_gradient(
    actor: Actor, batch: Encounter, ship: ShipParams, settings: AnalyticSettings
) -> tuple[Actor, Float[Array, ""]]:
    fleet = Packed(batch.present, settings.ships, settings.pairs)

    def loss(actor: Actor) -> Float[Array, ""]:
        @jax.checkpoint
        def go(carry: tuple[WorldState, Float[Array, " w"]], _: None):
            state, before = carry
            action = actor(state.observation, fleet)
            after, reward = jax.vmap(lambda e, s, a: _hold(e, s, a, ship, settings))(
                batch, state, action
            )
            cost = settings.hold * (
                settings.rudder_cost * action**2 + settings.swing_cost * (action - before) ** 2
            )
            return (after, action), reward - cost

        start = jax.vmap(lambda e: begin(e, ship))(batch)
        first = jax.lax.stop_gradient(actor(start.observation, fleet))
        _, rewards = jax.lax.scan(go, (start, first), None, length=settings.decisions)
        return -rewards.sum(0).mean()

    value, gradient = jax.value_and_grad(loss)(actor)
    return gradient, -value
