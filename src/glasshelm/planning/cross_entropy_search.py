"""The clairvoyant search: the best rudders for an encounter whose future is known.

Cross-entropy search (Rubinstein 1999) over alterations of the course of a voyage
that somebody has sailed: the alteration is a broken line over time, steered by
the autopilot on top of the rudders of that voyage. No alteration is that voyage
itself, so what is found is never worse. It knows every ship's true track and is
no pilot: it is the limit that pilots are measured against.
"""

import dataclasses
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from glasshelm.core.geometry import Vector, direction, norm, offset, wrap_angle
from glasshelm.encounters.types import Encounter, Motion
from glasshelm.env.rewards import step_reward
from glasshelm.env.step import EnvSettings, margins, next_leg, targets_at, waypoint_of
from glasshelm.ship.autopilot import autopilot_for
from glasshelm.ship.nomoto import ShipParams, ShipState, advance, with_drift

_WORLD = EnvSettings()


@dataclasses.dataclass(frozen=True)
class SearchSettings:
    """How hard is searched."""

    knots: int = 16
    samples: int = 64
    elites: int = 8
    iterations: int = 16
    #: Spread of the first alterations, and of the last (a share of the first).
    spread_rad: float = 0.7
    least_spread: float = 0.05
    #: How far outside the domain (Eq. 13, unclipped) counts as outside, for rounding.
    clear: float = 0.005


class KnownEncounter(eqx.Module):
    """All there is to know: the encounter, the true ship, the current (east, north) that carries
    her, and how many steps count. A batch has one more axis in front of every array.
    """

    encounter: Encounter
    ship: ShipParams
    steps: Int[Array, "*b"]
    current_m_s: Vector

    @staticmethod
    def still(encounters: Encounter, ship: ShipParams, steps: int) -> "KnownEncounter":
        """A batch of encounters for one ship without current, all equally long."""
        count = encounters.present.shape[0]
        each = jax.tree.map(lambda x: jnp.full(count, x, jnp.float32), ship)
        none = jnp.zeros(count)
        return KnownEncounter(encounters, each, jnp.full(count, steps), Vector(none, none))


class Rollout(eqx.Module):
    """One imagined voyage: its rudder commands [rad], its headings and rates of turn, its worth.

    ``margin`` is the worst Eq. 13 (unclipped), ``range_m`` the nearest ship,
    ``returned`` the undiscounted return (Eq. 16-18) of all steps.
    """

    rudder_rad: Float[Array, " t"]
    heading_rad: Float[Array, " t"]
    rate_rad_s: Float[Array, " t"]
    margin: Float[Array, ""]
    range_m: Float[Array, ""]
    returned: Float[Array, ""]

    def value(self, ship: ShipParams, settings: SearchSettings) -> Float[Array, ""]:
        """What is maximised: no collision first, then no intrusion, then the return."""
        collision = jnp.maximum(1.0 - self.range_m / ship.loa_m, 0.0)
        intrusion = jnp.maximum(self.margin + settings.clear, 0.0)
        return self.returned - 1e6 * collision - 1e5 * intrusion


class _Ship(eqx.Module):
    """An imagined own ship and what she has met so far."""

    own: ShipState
    leg: Int[Array, ""]
    bearing: Float[Array, ""]
    danger: Float[Array, " n"]
    margin: Float[Array, ""]
    range_m: Float[Array, ""]
    returned: Float[Array, ""]
    under_way: Bool[Array, ""]


def rollout_altered(
    known: KnownEncounter, base: Rollout, alteration_rad: Float[Array, " t"]
) -> Rollout:
    """The voyage ``base`` with its course altered, as the world would have it (Eq. 6-7, 13-18).

    It ends after ``known.steps``, or where the last waypoint is reached.
    """
    ship, autopilot = known.ship, autopilot_for(known.ship)
    number = jnp.arange(base.rudder_rad.shape[0])
    motions = jax.vmap(lambda n: targets_at(known.encounter, (n + 1) * _WORLD.step_s))(number)

    def go(at: _Ship, given: tuple[Float[Array, " 4"], Motion, Int[Array, ""]]):
        (rudder, heading, rate, alteration), motion, n = given
        error = alteration + heading - at.own.heading_rad
        change = autopilot.rudder_rad(error, at.own.rate_of_turn_rad_s - rate)
        command = jnp.clip(rudder + change, -ship.rudder_limit_rad, ship.rudder_limit_rad)
        out = (command, at.own.heading_rad, at.own.rate_of_turn_rad_s)
        own = advance(at.own, command, ship, _WORLD.step_s)
        met = _meet(known, at, with_drift(own, known.current_m_s, _WORLD.step_s), motion)
        counts = at.under_way & (n < known.steps)
        return jax.tree.map(lambda new, old: jnp.where(counts, new, old), met, at), out

    given = jnp.stack([base.rudder_rad, base.heading_rad, base.rate_rad_s, alteration_rad], -1)
    end, (rudders, headings, rates) = jax.lax.scan(go, _start(known), (given, motions, number))
    return Rollout(rudders, headings, rates, end.margin, end.range_m, end.returned)


def _start(known: KnownEncounter) -> _Ship:
    """Own ship before the first step, which is all that is counted."""
    encounter, own = known.encounter, known.encounter.own
    motion = targets_at(encounter, jnp.zeros(()))
    leg, far, yes = jnp.zeros((), jnp.int32), jnp.full((), jnp.inf), jnp.ones((), bool)
    danger = jnp.maximum(margins(own, motion, known.ship), 0.0)
    return _Ship(
        own, leg, _bearing(encounter, own, leg), danger, -far, far, jnp.zeros(()), yes
    )  # fmt: skip


def _meet(known: KnownEncounter, before: _Ship, own: ShipState, motion: Motion) -> _Ship:
    """Own ship a step later, at her new place."""
    depths = margins(own, motion, known.ship)
    dangers = jnp.maximum(depths, 0.0)
    apart = norm(offset(own, motion))
    nearest = jnp.where(motion.present, apart, jnp.inf).min(initial=jnp.inf)
    leg, arrived = next_leg(known.encounter, before.leg, own, _WORLD)
    bearing = _bearing(known.encounter, own, leg)
    last = jnp.where(leg == before.leg, before.bearing, bearing)
    reward = step_reward(bearing, last, dangers, before.danger)
    return _Ship(
        own,
        leg,
        bearing,
        dangers,
        jnp.maximum(before.margin, depths.max(initial=-jnp.inf)),
        jnp.minimum(before.range_m, nearest),
        before.returned + reward.total,
        ~arrived,
    )


def _bearing(encounter: Encounter, own: ShipState, leg: Int[Array, ""]) -> Float[Array, ""]:
    """Bearing of the waypoint off the bow."""
    waypoint = waypoint_of(encounter, leg)
    return wrap_angle(direction(offset(own, waypoint)) - own.heading_rad)


def rollout_rudders(known: KnownEncounter, rudder_rad: Float[Array, " t"]) -> Rollout:
    """The voyage of a row of rudder commands [rad]."""

    def go(own: ShipState, command: Float[Array, ""]):
        out = (own.heading_rad, own.rate_of_turn_rad_s)
        return advance(own, command, known.ship, _WORLD.step_s), out

    _, (heading, rate) = jax.lax.scan(go, known.encounter.own, rudder_rad)
    blank = jnp.zeros(())
    base = Rollout(rudder_rad, heading, rate, blank, blank, blank)
    return rollout_altered(known, base, jnp.zeros_like(rudder_rad))


def improve(
    known: KnownEncounter,
    base: Rollout,
    key: PRNGKeyArray,
    settings: SearchSettings = SearchSettings(),
) -> Rollout:
    """The best voyage found near ``base``, by value; ``base`` itself if there is no better."""
    lines = _lines(settings.knots, base.rudder_rad.shape[0], known.steps)

    def sail(knots: Float[Array, " k"]) -> Rollout:
        return rollout_altered(known, base, lines @ knots)

    def value(knots: Float[Array, " k"]) -> Float[Array, ""]:
        return sail(knots).value(known.ship, settings)

    def once(carry, key: PRNGKeyArray):
        mean, spread, best, best_value = carry
        noise = jax.random.normal(key, (settings.samples, settings.knots))
        tried = jnp.concatenate([mean + spread * noise, mean[None]])
        values = jax.vmap(value)(tried)
        top_values, top = jax.lax.top_k(values, settings.elites)
        elite = tried[top]
        better = top_values[0] > best_value
        best = jnp.where(better, elite[0], best)
        best_value = jnp.maximum(best_value, top_values[0])
        mean = 0.2 * mean + 0.8 * elite.mean(0)
        least = settings.least_spread * settings.spread_rad
        spread = 0.3 * spread + 0.7 * jnp.maximum(elite.std(0), least)
        return (mean, spread, best, best_value), None

    none = jnp.zeros(settings.knots)
    start = (none, none + settings.spread_rad, none, value(none))
    (_, _, best, _), _ = jax.lax.scan(once, start, jax.random.split(key, settings.iterations))
    return sail(best)


def best_of(sailed: Rollout, ship: ShipParams, settings: SearchSettings) -> Rollout:
    """The voyage of the greatest value along the first axis."""
    values = jax.vmap(lambda s: s.value(ship, settings))(sailed)
    return jax.tree.map(lambda x: x[jnp.argmax(values)], sailed)


@partial(jax.jit, static_argnames="settings")
def improve_all(
    known: KnownEncounter,
    bases: Rollout,
    key: PRNGKeyArray,
    settings: SearchSettings = SearchSettings(),
) -> Rollout:
    """:func:`improve` for a batch: ``bases`` [w].

    All are searched with the same draws: what is found in one does not depend on the others.
    """
    return jax.vmap(lambda k, b: improve(k, b, key, settings))(known, bases)


def _lines(knots: int, steps: int, counted: Int[Array, ""]) -> Float[Array, "t k"]:
    """The matrix from the knots of a broken line over the steps that count to its values."""
    at = jnp.arange(steps) * (knots - 1.0) / jnp.maximum(counted - 1, 1)
    return jnp.maximum(0.0, 1.0 - jnp.abs(at[:, None] - jnp.arange(knots)))
