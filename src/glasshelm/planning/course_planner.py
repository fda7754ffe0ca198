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
import numpy as np
from jaxtyping import Array, Bool, Float

from glasshelm.core.geometry import Vector, direction, norm, velocity, wrap_angle
from glasshelm.env.observe import LENGTH_M, SPEED_M_S, Observation, waypoint_bearing_rad
from glasshelm.env.rewards import course_reward
from glasshelm.env.step import EnvSettings
from glasshelm.ship.autopilot import Autopilot, autopilot_for
from glasshelm.ship.domain import danger_unclipped
from glasshelm.ship.nomoto import ShipParams

#: A beginning that is kept for so long counts as another choice (:func:`action_gap`).
_LASTS_S = 200.0

#: Rudders farther apart than this share of the limit are another choice (:func:`action_gap`).
_ANOTHER = 0.5

_SIDE = (10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 75.0, 90.0, 120.0)


@dataclasses.dataclass(frozen=True)
class CourseSettings:
    """Which manoeuvres are tried, how far ahead, and what counts as good. SI units, degrees.

    One alteration: each of ``offsets_deg`` for each of ``durations_s``. Two:
    each of ``first_deg`` for ``first_s``, then ``second_deg`` for ``second_s``.
    And the present heading, kept for each of ``keep_s``. After it the ship
    steers for the waypoint.
    """

    offsets_deg: tuple[float, ...] = (*(-a for a in reversed(_SIDE)), *_SIDE)
    durations_s: tuple[float, ...] = (200.0, 400.0, 700.0, 1000.0, 1400.0, 1900.0)
    first_deg: tuple[float, ...] = (-90.0, -60.0, -40.0, -20.0, 0.0, 20.0, 40.0, 60.0, 90.0)
    first_s: tuple[float, ...] = (100.0, 250.0, 500.0, 900.0)
    second_deg: tuple[float, ...] = (-110.0, -70.0, -30.0, 30.0, 70.0, 110.0)
    second_s: tuple[float, ...] = (150.0, 400.0, 1000.0)
    keep_s: tuple[float, ...] = (150.0, 400.0, 700.0, 1000.0, 1400.0, 1900.0)
    horizon_s: float = 2400.0
    step_s: float = 20.0
    #: Weight of the danger, and how near the domain (in Eq. 13, unclipped) it begins to count.
    danger_weight: float = 10.0
    danger_margin: float = 0.25
    danger_softness: float = 0.08
    #: Weights (in return) of the worst moment: of Eq. 13 there, and of being nearer than
    #: ``near_loa`` lengths (all of it in the other's midst). A sum alone would rather go quickly
    #: through a ship than slowly round her.
    worst_weight: float = 300.0
    near_weight: float = 1000.0
    near_loa: float = 2.0
    #: Cost (in return) of one radian of altering, over the whole manoeuvre: of two that are
    #: nearly as good, the one being steered is kept. Without it the ship weaves.
    alter_cost: float = 5.0

    def manoeuvres(self) -> Float[np.ndarray, "c 4"]:
        """Those off the waypoint: offset [rad], duration [s], second offset [rad], duration [s]."""
        one = [(a, s, 0, 0) for a in self.offsets_deg for s in self.durations_s if a]
        two = [
            (a, s, b, t)
            for a in self.first_deg
            for s in self.first_s
            for b in self.second_deg
            for t in self.second_s
            if a != b
        ]
        table = np.array([(0.0, 0.0, 0.0, 0.0), *one, *two], np.float32)
        table[:, [0, 2]] = np.radians(table[:, [0, 2]])
        return table


class Plan(eqx.Module):
    """The best course now, and what steering otherwise would cost.

    ``offset_rad`` is the course off the bearing of the waypoint. ``values`` holds the return of
    every manoeuvre; each begins with ``first_offsets_rad`` for ``first_durations_s``.
    """

    offset_rad: Float[Array, "*b"]
    values: Float[Array, "*b c"]
    first_offsets_rad: Float[Array, "*b c"]
    first_durations_s: Float[Array, "*b c"]


class Situation(eqx.Module):
    """Own ship's surroundings in the frame of her position and heading now [m, m/s, rad]."""

    waypoint: Vector
    bearing_rad: Float[Array, ""]
    rate_of_turn_rad_s: Float[Array, ""]
    position: Vector
    velocity: Vector


def situation_of(observation: Observation, ship: ShipParams) -> Situation:
    """What one observation says of own ship's motion and of the targets'.

    The rate of turn is that of the waypoint's bearing over the last step, less
    what own ship's way makes of it. Absent targets are put far away.
    """
    now, before = (waypoint_bearing_rad(observation.waypoint[i]) for i in (0, 1))
    waypoint = Vector(observation.waypoint[0, 0] * LENGTH_M, observation.waypoint[0, 1] * LENGTH_M)
    passing = ship.speed_m_s * velocity(now, 1.0).x / jnp.maximum(norm(waypoint), 1.0)
    moved = jnp.any(
        observation.waypoint[0] != observation.waypoint[1]
    )  # else this is the first frame
    rate = jnp.where(moved, passing - wrap_angle(now - before) / EnvSettings().step_s, 0.0)
    first = observation.targets[:, 0]
    absent = ~observation.present
    return Situation(
        waypoint,
        now,
        rate,
        Vector(jnp.where(absent, -1e6, first[:, 0] * LENGTH_M), first[:, 1] * LENGTH_M),
        Vector(first[:, 3] * SPEED_M_S, first[:, 4] * SPEED_M_S + ship.speed_m_s),
    )


class PredictedOwn(eqx.Module):
    """The imagined own ships, one a manoeuvre; ``way`` is where their bows point, a unit vector."""

    x: Float[Array, " c"]
    y: Float[Array, " c"]
    heading: Float[Array, " c"]
    rate: Float[Array, " c"]
    way: Vector

    @staticmethod
    def here(rate_of_turn_rad_s: Float[Array, ""], manoeuvres: int) -> "PredictedOwn":
        """All of them where own ship is, with her rate of turn."""
        zero = jnp.zeros(manoeuvres)
        return PredictedOwn(zero, zero, zero, zero + rate_of_turn_rad_s, Vector(zero, zero + 1.0))


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
    keep = jnp.array([(0.0, seconds, 0.0, 0.0) for seconds in settings.keep_s]).reshape(-1, 4)
    keep = keep.at[:, 0].set(-at.bearing_rad)  # in her frame the present heading is 0
    table = jnp.concatenate([jnp.asarray(settings.manoeuvres()), keep])
    values = _worth(table, at, ship, settings)
    begins = jnp.where(table[:, 1] > 0, table[:, 0], 0.0)
    return Plan(begins[jnp.argmax(values)], values, begins, table[:, 1])


def _worth(
    table: Float[Array, "c 4"], at: Situation, ship: ShipParams, settings: CourseSettings
) -> Float[Array, " c"]:
    """The return of every manoeuvre, less its costs.

    Targets are taken one by one, not as an axis: the whole step is then one
    loop over the manoeuvres for the compiler, four times as fast.
    """
    offset, until, offset2, duration2 = table.T
    helm, tau = autopilot_for(ship), settings.step_s

    def go(
        carry: tuple[PredictedOwn, ManoeuvreCost], time: Float[Array, ""]
    ) -> tuple[tuple[PredictedOwn, ManoeuvreCost], None]:
        ahead, met = carry
        altered = jnp.where(time < until, offset, jnp.where(time < until + duration2, offset2, 0.0))
        course = jnp.where(altered == 0.0, met.bearing, at.bearing_rad + altered)
        moved = sail_ahead(ahead, course, helm, ship, tau)
        return (moved, _meet(moved, met, time + tau, at, ship, settings)), None

    zero = jnp.zeros_like(offset)
    met = ManoeuvreCost(zero + at.bearing_rad, zero, zero - 1.0, zero + jnp.inf)
    start = (PredictedOwn.here(at.rate_of_turn_rad_s, offset.size), met)
    times = jnp.arange(round(settings.horizon_s / tau), dtype=jnp.float32) * tau
    (_, met), _ = jax.lax.scan(go, start, times)
    begins = jnp.where(until > 0, offset, 0.0)
    last = jnp.where(duration2 > 0, offset2, begins)
    altered = jnp.abs(wrap_angle(at.bearing_rad + begins)) + jnp.abs(last - begins) + jnp.abs(last)
    near_m = settings.near_loa * ship.loa_m
    near = jnp.maximum(1.0 - jnp.sqrt(met.nearest_m2) / near_m, 0.0)
    worst = jnp.maximum(met.worst, 0.0)
    costs = settings.alter_cost * altered + settings.worst_weight * worst
    return met.value - costs - settings.near_weight * near


def sail_ahead(
    ahead: PredictedOwn, course: Float[Array, " c"], helm: Autopilot, ship: ShipParams, tau: float
) -> PredictedOwn:
    """One step towards a course: Eq. 6 exactly for a constant rudder, Eq. 7 along the arc.

    The run over ground is the mean of both ways, lengthened from that of a chord's ends
    to the chord's (by Δψ²/12): one sine a step instead of two.
    """
    rudder = helm.rudder_rad(wrap_angle(course - ahead.heading), ahead.rate)
    lag = ship.time_constant_s
    decay = jnp.exp(-tau / lag)
    steady = ship.gain_1_s * rudder
    transient = ahead.rate - steady
    turned = steady * tau + transient * (lag * (1.0 - decay))
    heading = ahead.heading + turned
    way = velocity(heading, 1.0)
    run = (0.5 * ship.speed_m_s * tau) * (1.0 + turned * turned * (1.0 / 12.0))
    return PredictedOwn(
        ahead.x + run * (ahead.way.x + way.x),
        ahead.y + run * (ahead.way.y + way.y),
        heading,
        steady + transient * decay,
        way,
    )


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


def rudder_towards(
    offset_rad: Float[Array, ""], observation: Observation, ship: ShipParams
) -> Float[Array, ""]:
    """The rudder, as a fraction of the limit, that steers a course off the waypoint's bearing."""
    at = situation_of(observation, ship)
    error = wrap_angle(at.bearing_rad + offset_rad)
    return autopilot_for(ship).rudder_rad(error, at.rate_of_turn_rad_s) / ship.rudder_limit_rad


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
