"""The clairvoyant search: the best rudders for an encounter whose future is known.

Cross-entropy search (Rubinstein 1999) over alterations of the course of a voyage
that somebody has sailed: the alteration is a broken line over time, steered by
the helmsman on top of the rudders of that voyage. No alteration is that voyage
itself, so what is found is never worse. It knows every ship's true track and is
no pilot: it is the limit that pilots are measured against.
"""

import dataclasses
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, PRNGKeyArray

from glasshelm.encounters.types import Encounter, Motion
from glasshelm.geometry import Vector, direction, norm, to_body, wrap_angle
from glasshelm.planning.helm import helm_of
from glasshelm.ships import ShipParams, ShipState, advance
from glasshelm.world.domain import danger_unclipped
from glasshelm.world.rewards import step_reward
from glasshelm.world.step import FAR_M, WorldSettings, targets_at, waypoint_of


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


class Sailed(eqx.Module):
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


def sail_altered(
    encounter: Encounter,
    ship: ShipParams,
    base: Sailed,
    alteration_rad: Float[Array, " t"],
    settings: WorldSettings = WorldSettings(),
) -> Sailed:
    """The voyage ``base`` with its course altered, as the world would have it (Eq. 6-7, 13-18)."""
    helm = helm_of(ship)
    steps = base.rudder_rad.shape[0]
    times = jnp.arange(1, steps + 1) * settings.step_s
    motions = jax.vmap(lambda t: targets_at(encounter, t))(times)

    def go(at: _Ship, given: tuple[Float[Array, " 4"], Motion]):
        (rudder, heading, rate, alteration), motion = given
        error = alteration + heading - at.own.heading_rad
        change = helm.rudder_rad(error, at.own.rate_of_turn_rad_s - rate)
        command = jnp.clip(rudder + change, -ship.rudder_limit_rad, ship.rudder_limit_rad)
        out = (command, at.own.heading_rad, at.own.rate_of_turn_rad_s)
        own = advance(at.own, command, ship, settings.step_s)
        return _meet(encounter, at, own, motion, ship, settings), out

    given = jnp.stack([base.rudder_rad, base.heading_rad, base.rate_rad_s, alteration_rad], -1)
    start = _meet(
        encounter, None, encounter.own, targets_at(encounter, jnp.zeros(())), ship, settings
    )
    end, (rudders, headings, rates) = jax.lax.scan(go, start, (given, motions))
    return Sailed(rudders, headings, rates, end.margin, end.range_m, end.returned)


def _meet(
    encounter: Encounter,
    before: _Ship | None,
    own: ShipState,
    motion: Motion,
    ship: ShipParams,
    settings: WorldSettings,
) -> _Ship:
    """Own ship at her new place; without ``before`` the start, which is not counted."""
    offset = Vector(motion.east_m - own.east_m, motion.north_m - own.north_m)
    body = to_body(offset, own.heading_rad)
    body = Vector(jnp.where(motion.present, body.x, 0.0), jnp.where(motion.present, body.y, FAR_M))
    margins = danger_unclipped(body, ship.loa_m)
    dangers = jnp.maximum(margins, 0.0)
    leg = jnp.zeros((), jnp.int32) if before is None else before.leg
    waypoint = waypoint_of(encounter, leg)
    away = norm(Vector(waypoint.x - own.east_m, waypoint.y - own.north_m))
    more = leg < encounter.route.x.shape[-1] - 1
    changed = (away < settings.arrival_m) & more
    if before is None:
        changed = jnp.zeros((), bool)
    leg = jnp.where(changed, leg + 1, leg)
    waypoint = waypoint_of(encounter, leg)
    way = direction(Vector(waypoint.x - own.east_m, waypoint.y - own.north_m))
    bearing = wrap_angle(way - own.heading_rad)
    if before is None:
        far, zero = jnp.full((), -jnp.inf), jnp.zeros(())
        return _Ship(own, leg, bearing, dangers, far, -far, zero)
    last = jnp.where(changed, bearing, before.bearing)
    reward = step_reward(bearing, last, dangers, before.danger)
    return _Ship(
        own,
        leg,
        bearing,
        dangers,
        jnp.maximum(before.margin, margins.max(initial=-jnp.inf)),
        jnp.minimum(before.range_m, norm(body).min(initial=jnp.inf)),
        before.returned + reward.total,
    )


def as_sailed(encounter: Encounter, ship: ShipParams, rudder_rad: Float[Array, " t"]) -> Sailed:
    """The voyage of a row of rudder commands [rad]."""
    zero = jnp.zeros_like(rudder_rad)

    def go(own: ShipState, command: Float[Array, ""]):
        out = (own.heading_rad, own.rate_of_turn_rad_s)
        return advance(own, command, ship, WorldSettings().step_s), out

    _, (heading, rate) = jax.lax.scan(go, encounter.own, rudder_rad)
    blank = jnp.zeros(())
    base = Sailed(rudder_rad, heading, rate, blank, blank, blank)
    return sail_altered(encounter, ship, base, zero)


def improve(
    encounter: Encounter,
    ship: ShipParams,
    base: Sailed,
    key: PRNGKeyArray,
    settings: SearchSettings = SearchSettings(),
) -> Sailed:
    """The best voyage found near ``base``, by value; ``base`` itself if there is no better."""
    broken = jnp.asarray(_lines(settings.knots, base.rudder_rad.shape[0]))

    def sail(knots: Float[Array, " k"]) -> Sailed:
        return sail_altered(encounter, ship, base, broken @ knots)

    def value(knots: Float[Array, " k"]) -> Float[Array, ""]:
        return sail(knots).value(ship, settings)

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


def best_of(sailed: Sailed, ship: ShipParams, settings: SearchSettings) -> Sailed:
    """The voyage of the greatest value along the first axis."""
    values = jax.vmap(lambda s: s.value(ship, settings))(sailed)
    return jax.tree.map(lambda x: x[jnp.argmax(values)], sailed)


@partial(jax.jit, static_argnames=("ship", "settings"))
def improve_all(
    encounters: Encounter,
    ship: ShipParams,
    bases: Sailed,
    key: PRNGKeyArray,
    settings: SearchSettings = SearchSettings(),
) -> Sailed:
    """:func:`improve` for a batch: ``bases`` [w]."""
    keys = jax.random.split(key, bases.margin.shape[0])
    return jax.vmap(lambda e, b, k: improve(e, ship, b, k, settings))(encounters, bases, keys)


def _lines(knots: int, steps: int) -> Float[np.ndarray, "t k"]:
    """The matrix from the knots of a broken line to its values at every step."""
    at = np.linspace(0.0, knots - 1.0, steps)
    return np.maximum(0.0, 1.0 - np.abs(at[:, None] - np.arange(knots))).astype(np.float32)
