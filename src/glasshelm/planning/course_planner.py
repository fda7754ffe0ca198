"""Which course to steer now: many manoeuvres simulated, the best one taken.

Scenario-based model-predictive control in the manner of Johansen et al. (2016):
a manoeuvre is a short list of course alterations off the way to the waypoint;
each is sailed ahead with own ship's dynamics (Eq. 6-7) against targets that
keep course and speed, and valued by the paper's rewards made smooth. Nothing
but one observation is needed, so it is also the expert that networks imitate which see
no more (:mod:`glasshelm.training.dagger`).
"""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from glasshelm.core.geometry import Vector, direction, wrap_angle
from glasshelm.env.observe import Observation
from glasshelm.env.rewards import course_reward
from glasshelm.env.step import EnvSettings
from glasshelm.planning.manoeuvres import (
    Manoeuvres,
    ManoeuvreTable,
    PredictedOwn,
    predict_manoeuvres,
)
from glasshelm.planning.simulated_critic import ManoeuvreCosts
from glasshelm.planning.situation import Situation, rudder_towards, situation_of
from glasshelm.ship.domain import danger_unclipped
from glasshelm.ship.nomoto import ShipParams

#: A beginning that is kept for so long counts as another choice (:func:`action_gap`).
_LASTS_S = 200.0

#: Rudders farther apart than this share of the limit are another choice (:func:`action_gap`).
_ANOTHER = 0.5


@dataclasses.dataclass(frozen=True)
class CourseSettings(ManoeuvreCosts, ManoeuvreTable):
    """Which manoeuvres are tried, how far ahead, and what counts as good."""


class Plan(eqx.Module):
    """The best course now, and what steering otherwise would cost.

    ``offset_rad`` is the course off the bearing of the waypoint. ``values`` holds the return of
    every manoeuvre; each begins with ``first_offsets_rad`` for ``first_durations_s``.
    """

    offset_rad: Float[Array, "*b"]
    values: Float[Array, "*b c"]
    first_offsets_rad: Float[Array, "*b c"]
    first_durations_s: Float[Array, "*b c"]


class ManoeuvreCost(eqx.Module):
    """What each of them has earned (or cost) so far, her worst Eq. 13 and nearest range² [m²].

    ``bearing`` is that of the waypoint from where she is.
    """

    bearing: Float[Array, " c"]
    value: Float[Array, " c"]
    worst: Float[Array, " c"]
    nearest_m2: Float[Array, " c"]


def plan_course(
    observation: Observation, ship: ShipParams, settings: CourseSettings = CourseSettings()
) -> Plan:
    """The best of all manoeuvres from one observation, and the value of each."""
    at = situation_of(observation, ship)
    manoeuvres = settings.at(at.bearing_rad)
    values = _worth(manoeuvres, at, ship, settings)
    begins = manoeuvres.offset_rad
    return Plan(begins[jnp.argmax(values)], values, begins, manoeuvres.duration_s)


def _worth(
    manoeuvres: Manoeuvres, at: Situation, ship: ShipParams, settings: CourseSettings
) -> Float[Array, " c"]:
    """The return of every manoeuvre, less its costs, of which the worst of all ships counts.

    Targets are taken one by one, not as an axis: the whole step is then one
    loop over the manoeuvres for the compiler, four times as fast.
    """
    tau = settings.step_s

    def go(
        carry: tuple[PredictedOwn, ManoeuvreCost], time: Float[Array, ""]
    ) -> tuple[tuple[PredictedOwn, ManoeuvreCost], None]:
        ahead, met = carry
        moved = predict_manoeuvres(ahead, met.bearing, manoeuvres, time, at, ship, tau)
        return (moved, _meet(moved, met, time + tau, at, ship, settings)), None

    zero = jnp.zeros_like(manoeuvres.offset_rad)
    met = ManoeuvreCost(zero + at.bearing_rad, zero, zero - 1.0, zero + jnp.inf)
    start = (PredictedOwn.here(at.rate_of_turn_rad_s, zero.size), met)
    times = jnp.arange(round(settings.horizon_s / tau), dtype=jnp.float32) * tau
    (_, met), _ = jax.lax.scan(go, start, times)
    near_m = settings.near_loa * ship.loa_m
    near = jnp.maximum(1.0 - jnp.sqrt(met.nearest_m2) / near_m, 0.0)
    worst = jnp.maximum(met.worst, 0.0)
    altered = manoeuvres.altered_rad(at.bearing_rad)
    costs = settings.alter_cost * altered + settings.worst_weight * worst
    return met.value - costs - settings.near_weight * near


def _meet(
    ahead: PredictedOwn,
    met: ManoeuvreCost,
    time: Float[Array, ""],
    at: Situation,
    ship: ShipParams,
    settings: CourseSettings,
) -> ManoeuvreCost:
    """What was met, with this step's reward (Eq. 17, and the danger smoothed) and ranges added."""
    bearing = direction(Vector(at.waypoint.x - ahead.x, at.waypoint.y - ahead.y))
    reward = course_reward(wrap_angle(bearing - ahead.heading))
    soft, worst, nearest = settings.danger_softness, met.worst, met.nearest_m2
    for i in range(at.position.x.shape[0]):
        there = Vector(
            at.position.x[i] + at.velocity.x[i] * time - ahead.x,
            at.position.y[i] + at.velocity.y[i] * time - ahead.y,
        )
        body = Vector(
            there.x * ahead.way.y - there.y * ahead.way.x,
            there.x * ahead.way.x + there.y * ahead.way.y,
        )
        margin = danger_unclipped(body, ship.loa_m)
        worst = jnp.maximum(worst, margin)
        nearest = jnp.minimum(nearest, there.x**2 + there.y**2)
        depth = jnp.maximum(margin + settings.danger_margin, 0.0)
        depth = jnp.where(depth < 2 * soft, depth**2 * (1 / (4 * soft)), depth - soft)
        reward = reward - settings.danger_weight * depth
    steps = settings.step_s / EnvSettings().step_s
    return ManoeuvreCost(bearing, met.value + steps * reward, worst, nearest)


def action_gap(plan: Plan, observation: Observation, ship: ShipParams) -> Float[Array, ""]:
    """What is lost (in return) by the best manoeuvre that begins with quite another rudder.

    Another by half of the limit or more, for 200 s or more: what lasts a moment can be
    mended. Where the best one begins with much rudder, also about amidships, if that costs
    more: between two ways out the other one costs nothing, but none of them much. 0 if
    there is no other.
    """
    rudders = _rudders(plan, observation, ship)
    first = rudder_towards(plan.offset_rad, observation, ship)
    best, lasts = plan.values.max(), _lasts(plan)

    def lost(those: Bool[Array, " c"]) -> Float[Array, ""]:
        value = jnp.where(those & lasts, plan.values, -jnp.inf).max()
        return jnp.where(jnp.isfinite(value), best - value, 0.0)

    amidships = (jnp.abs(rudders) < 0.25) & (jnp.abs(first) > 0.5)
    return jnp.maximum(lost(jnp.abs(rudders - first) > _ANOTHER), lost(amidships))


def _rudders(plan: Plan, observation: Observation, ship: ShipParams) -> Float[Array, " c"]:
    """What each manoeuvre begins with, as a fraction of the limit."""
    return jax.vmap(lambda offset: rudder_towards(offset, observation, ship))(
        plan.first_offsets_rad
    )


def _lasts(plan: Plan) -> Bool[Array, " c"]:
    return (plan.first_durations_s == 0.0) | (plan.first_durations_s >= _LASTS_S)
