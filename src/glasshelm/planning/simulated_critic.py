"""The simulated critic: what every manoeuvre brings, by sub-task and by ship, simulated ahead.

    Q(s, m) = Q_wp(s_wp, m) + Q_helm(m) + Σ_i Q_ca(s_i, m)

Own ship is advanced by Eq. 6-7 under each manoeuvre; every other ship keeps course and speed
(scenario-based MPC in the manner of Johansen et al. 2016, with costs that no two ships share).
It needs no training and takes any ship.
"""

import dataclasses
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.core.geometry import Vector, wrap_angle
from glasshelm.env.observe import Observation
from glasshelm.env.rewards import course_reward
from glasshelm.env.step import EnvSettings
from glasshelm.networks.critics import QValues
from glasshelm.planning.manoeuvres import (
    Manoeuvres,
    ManoeuvreTable,
    PredictedOwn,
    predict_manoeuvres,
)
from glasshelm.planning.situation import Situation, situation_of
from glasshelm.ship.autopilot import Autopilot
from glasshelm.ship.domain import danger_unclipped
from glasshelm.ship.nomoto import ShipParams


@dataclasses.dataclass(frozen=True)
class ManoeuvreCosts:
    """What counts as good, in points of return, and how far ahead. SI units."""

    horizon_s: float = 2400.0
    step_s: float = 20.0
    #: Weight of the danger, and how near the domain (in Eq. 13, unclipped) it begins to count.
    danger_weight: float = 10.0
    danger_margin: float = 0.25
    danger_softness: float = 0.08
    #: Of each ship's worst moment: of Eq. 13 there, and of the square of how far it comes within
    #: ``near_loa`` lengths (1 at own ship). A sum alone would rather go quickly through a ship than
    #: slowly round it; without the square, a collision would cost little more than a near miss,
    #: and be chosen where that spares an intrusion of another ship.
    worst_weight: float = 300.0
    near_weight: float = 4000.0
    near_loa: float = 2.0
    #: Of one radian of altering, over the whole manoeuvre: of two that are nearly as good, the
    #: one being steered is kept. Without it the ship weaves.
    alter_cost: float = 5.0


class Encountered(eqx.Module):
    """What has been met of one ship so far on each manoeuvre.

    Attributes:
        exposure: Σ of the smoothed danger over the steps.
        margin: The worst Eq. 13, unclipped.
        range_m2: The least range² [m²].
    """

    exposure: Float[Array, "*c"]
    margin: Float[Array, "*c"]
    range_m2: Float[Array, "*c"]

    @staticmethod
    def nothing(like: Float[Array, "*c"]) -> "Encountered":
        zero = jnp.zeros_like(like)
        return Encountered(zero, zero - 1.0, zero + jnp.inf)

    def and_then(self, body: Vector, loa_m: float | Array, costs: ManoeuvreCosts) -> "Encountered":
        """With one more step, the ship being at a place relative to own ship."""
        margin, soft = danger_unclipped(body, loa_m), costs.danger_softness
        depth = jnp.maximum(margin + costs.danger_margin, 0.0)
        depth = jnp.where(depth < 2 * soft, depth**2 * (1 / (4 * soft)), depth - soft)
        return Encountered(
            self.exposure + depth,
            jnp.maximum(self.margin, margin),
            jnp.minimum(self.range_m2, body.x**2 + body.y**2),
        )

    def followed_by(self, later: "Encountered") -> "Encountered":
        """Both together: what is met on this way and then on another."""
        return Encountered(
            self.exposure + later.exposure,
            jnp.maximum(self.margin, later.margin),
            jnp.minimum(self.range_m2, later.range_m2),
        )

    def value(self, loa_m: float | Array, costs: ManoeuvreCosts) -> Float[Array, "*c"]:
        """Q_ca: what all that costs."""
        near = jnp.maximum(1.0 - jnp.sqrt(self.range_m2) / (costs.near_loa * loa_m), 0.0)
        cost = costs.step_s / EnvSettings().step_s * costs.danger_weight * self.exposure
        cost += costs.worst_weight * jnp.maximum(self.margin, 0.0)
        return -(cost + costs.near_weight * near**2)


class SimulatedCritic(eqx.Module):
    """Values manoeuvres by simulating them."""

    table: ManoeuvreTable = eqx.field(static=True, default=ManoeuvreTable())
    costs: ManoeuvreCosts = eqx.field(static=True, default=ManoeuvreCosts())

    def __call__(self, observation: Observation, ship: ShipParams) -> tuple[Manoeuvres, QValues]:
        """The manoeuvres that there are in one observation, and what each is worth.

        Args:
            observation: Eq. 10-12; only the newest frame is used, and own ship's rate of turn.
            ship: Own ship.

        Returns:
            The manoeuvres [c], and their values [c] by sub-task: Q_wp the reward for the way to
            the waypoint (Eq. 17) until the horizon, Q_helm what altering course costs, Q_ca what
            each ship costs, whatever the others do. The last two are never above 0.
        """
        manoeuvres = self.table.at(situation_of(observation, ship).bearing_rad)
        return manoeuvres, self.value(manoeuvres, observation, ship)

    def value(self, manoeuvres: Manoeuvres, observation: Observation, ship: ShipParams) -> QValues:
        """The same of any manoeuvres, be they in the table or not."""
        at = situation_of(observation, ship)
        waypoint, met = simulate_manoeuvres(manoeuvres, at, ship, self.costs)
        by_ship = [m.value(ship.loa_m, self.costs) for m in met]
        values = jnp.stack(by_ship, -1) if by_ship else jnp.zeros((waypoint.size, 0))
        return QValues(
            waypoint,
            jnp.where(observation.present, values, 0.0),
            -self.costs.alter_cost * manoeuvres.altered_rad(at.bearing_rad),
        )

    def along(
        self, course_rad: Float[Array, ""], observation: Observation, ship: ShipParams
    ) -> tuple[Manoeuvres, QValues]:
        """One course, relative to own heading, held for each of the table's durations."""
        bearing = situation_of(observation, ship).bearing_rad
        manoeuvres = self.table.along(course_rad, bearing)
        return manoeuvres, self.value(manoeuvres, observation, ship)


#: The waypoint and the other ships at a time [s] from now, in the frame of a situation [m].
Surroundings = Callable[[Float[Array, ""]], tuple[Vector, Vector]]


def straight_on(at: Situation) -> Surroundings:
    """Every ship keeps course and speed."""

    def surroundings(time: Float[Array, ""]) -> tuple[Vector, Vector]:
        x, y = (p + v * time for p, v in zip(at.position, at.velocity, strict=True))
        return at.waypoint, Vector(x, y)

    return surroundings


def simulate_manoeuvres(
    manoeuvres: Manoeuvres,
    at: Situation,
    ship: ShipParams,
    costs: ManoeuvreCosts,
    surroundings: Surroundings | None = None,
    autopilot: Autopilot | None = None,
) -> tuple[Float[Array, " c"], tuple[Encountered, ...]]:
    """Simulate every manoeuvre: Q_wp (Eq. 17), and what is met of each ship.

    Targets are taken one by one, not as an axis: a step is then one loop over the manoeuvres
    for the compiler, several times as fast.

    Args:
        manoeuvres: What is sailed.
        at: Where own ship is, and from where courses are counted.
        ship: Own ship as it moves.
        costs: How far ahead, in which steps, and what counts.
        surroundings: Where waypoint and ships will be; by default every ship keeps straight on.
        autopilot: What steers the courses; by default the ship's own.
    """
    tau, zero = costs.step_s, jnp.zeros_like(manoeuvres.offset_rad)
    ships = range(at.position.x.shape[0])
    surroundings = surroundings or straight_on(at)

    def step(carry, time: Float[Array, ""]):
        ahead, bearing, total, met = carry
        ahead = predict_manoeuvres(ahead, bearing, manoeuvres, time, at, ship, tau, autopilot)
        waypoint, place = surroundings(time + tau)
        bearing = ahead.bearing_of(waypoint)
        total = total + course_reward(wrap_angle(bearing - ahead.heading))
        met = tuple(
            met[i].and_then(ahead.body(Vector(place.x[i], place.y[i])), ship.loa_m, costs)
            for i in ships
        )
        return (ahead, bearing, total, met), None

    start = (
        PredictedOwn.here(at.rate_of_turn_rad_s, zero.size),
        zero + at.bearing_rad,
        zero,
        tuple(Encountered.nothing(zero) for _ in ships),
    )
    times = jnp.arange(round(costs.horizon_s / tau), dtype=jnp.float32) * tau
    (_, _, waypoint, met), _ = jax.lax.scan(step, start, times)
    return costs.step_s / EnvSettings().step_s * waypoint, met
