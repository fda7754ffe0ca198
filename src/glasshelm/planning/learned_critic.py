"""The learned critic: what every manoeuvre costs with each ship, as it was in much traffic.

    Q(s, m) = Q_wp(s_wp, m) + Q_helm(m) + Σ_i Q_ca(s_wp, s_i)[m]

The first two terms depend on own ship alone, whose model is known: they are simulated, as in the
simulated critic. Q_ca is a network that was shown what each manoeuvre led to when ships err,
alter course and are seen through poor instruments (:mod:`glasshelm.training.manoeuvre_regression`).
"""

import dataclasses

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from glasshelm.core.geometry import Vector, wrap_angle
from glasshelm.env.observe import Observation
from glasshelm.networks.critics import QValues
from glasshelm.networks.input_features import COURSE_INPUTS, encode_courses
from glasshelm.networks.mlp import Mlp, relu
from glasshelm.planning.manoeuvres import Manoeuvres, ManoeuvreTable
from glasshelm.planning.simulated_critic import ManoeuvreCosts, simulate_manoeuvres
from glasshelm.planning.situation import situation_of
from glasshelm.ship.nomoto import ShipParams

#: No cost is larger than exp of this [points].
MAX_LOG_COST = 8.0


@dataclasses.dataclass(frozen=True)
class ManoeuvreCriticSizes:
    """Layer widths of Q_ca; the defaults are Tables A.1-A.2. And the rows of its output."""

    hidden: tuple[int, ...] = (256, 256, 128)
    norm: bool = True
    table: ManoeuvreTable = dataclasses.field(default_factory=ManoeuvreTable)
    costs: ManoeuvreCosts = dataclasses.field(default_factory=ManoeuvreCosts)


class LearnedCritic(eqx.Module):
    """Values the manoeuvres of a table: what is known by simulation, ships by a network.

    Attributes:
        network: From (s_wp, s_i) to ``log(1 + cost)`` of every manoeuvre; below 0 counts as 0.
        table: The manoeuvres.
        costs: What the network has learned to predict, and how Q_wp and Q_helm are counted.
    """

    network: Mlp
    table: ManoeuvreTable = eqx.field(static=True)
    costs: ManoeuvreCosts = eqx.field(static=True)

    def __init__(self, sizes: ManoeuvreCriticSizes, key: PRNGKeyArray):
        widths = (COURSE_INPUTS, *sizes.hidden, sizes.table.size)
        self.network = Mlp(widths, relu, key, sizes.norm)
        self.table, self.costs = sizes.table, sizes.costs

    def __call__(self, observation: Observation, ship: ShipParams) -> tuple[Manoeuvres, QValues]:
        """The manoeuvres that there are in one observation, and what each is worth.

        Args:
            observation: Eq. 10-12.
            ship: Own ship.

        Returns:
            The manoeuvres [c], and their values [c] by sub-task. Q_helm and Q_ca are never
            above 0.
        """
        at = situation_of(observation, ship)
        manoeuvres = self.table.at(at.bearing_rad)
        nobody = Vector(jnp.zeros(0), jnp.zeros(0))
        alone = dataclasses.replace(at, position=nobody, velocity=nobody)
        waypoint, _ = simulate_manoeuvres(manoeuvres, alone, ship, self.costs)
        cost = jnp.where(observation.present[:, None], self.cost(observation, ship), 0.0)
        return manoeuvres, QValues(
            waypoint, -cost.T, -self.costs.alter_cost * manoeuvres.altered_rad(at.bearing_rad)
        )

    def cost(self, observation: Observation, ship: ShipParams) -> Float[Array, "*b n c"]:
        """−Q_ca of every slot, whether a ship is there or not: exp(f) − 1, never below 0."""
        log_cost = self.network(encode_courses(observation, ship))
        return jnp.expm1(jnp.clip(log_cost, 0.0, MAX_LOG_COST))

    def along(
        self, course_rad: Float[Array, ""], observation: Observation, ship: ShipParams
    ) -> tuple[Manoeuvres, QValues]:
        """The manoeuvres of the table whose first course is the nearest to the one given.

        Args:
            course_rad: A course relative to own heading.
            observation: Eq. 10-12.
            ship: Own ship.

        Returns:
            All manoeuvres and their values; Q_wp is −inf of those along other courses.
        """
        manoeuvres, values = self(observation, ship)
        course = situation_of(observation, ship).bearing_rad + manoeuvres.offset_rad
        off = jnp.abs(wrap_angle(course - course_rad))
        along = off <= off.min() + _SAME_RAD
        waypoint = jnp.where(along, values.waypoint, -jnp.inf)
        return manoeuvres, dataclasses.replace(values, waypoint=waypoint)


#: Courses of the table this near to each other are one [rad].
_SAME_RAD = 1e-3
