"""A critic of manoeuvres that learns from its own experience alone: no model, no teacher.

    Q(s, m) = Q_wp(s_wp, m) + Q_helm(m) + Σ_i Q_ca(s_wp, s_i, m)

A manoeuvre here is one course, held for a time, and then the way to the waypoint. It fixes own
ship's future, so a head that sees one ship has seen all that matters to that ship, and the sum is
exact. The manoeuvre is an *input* of both networks: each ship is shown as it would lie and move
on the first course and on the way to the waypoint after it, in the terms of Eq. 11. So one
network serves every course and duration. How own ship turns, what its domain is and what nearness
costs, it must learn from rewards (:mod:`glasshelm.training.course_learning`).
"""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from glasshelm.core.geometry import Vector, direction, norm, to_body, velocity, wrap_angle
from glasshelm.env.observe import LENGTH_M, Observation
from glasshelm.networks.critics import QValues
from glasshelm.networks.mlp import Mlp, relu, softsign
from glasshelm.planning.manoeuvres import Manoeuvres, ManoeuvreTable
from glasshelm.planning.simulated_critic import ManoeuvreCosts
from glasshelm.planning.situation import Situation, situation_of
from glasshelm.ship.nomoto import ShipParams

#: Lengths of the input vectors of the two networks.
WAYPOINT_INPUTS, TARGET_INPUTS = 11, 27
#: No cost is larger than exp of this [points].
MAX_LOG_COST = 9.0
#: One course and its duration; none has a second.
ONE_COURSE = ManoeuvreTable(
    offsets_deg=(
        *(-120.0, -90.0, -60.0, -45.0, -30.0, -20.0, -10.0),
        *(10.0, 20.0, 30.0, 45.0, 60.0, 90.0, 120.0),
    ),
    durations_s=(200.0, 500.0, 900.0, 1500.0),
    first_deg=(),
    keep_s=(200.0, 500.0, 900.0, 1500.0),
)
#: The paper's rewards are content with shallow intrusions; these count nearness, step by step.
STEP_COSTS = ManoeuvreCosts(step_s=5.0)


@dataclasses.dataclass(frozen=True)
class CourseCriticSizes:
    """Layer widths of both heads, the manoeuvres among which is chosen, and what they cost."""

    of_waypoint: tuple[int, ...] = (32, 32)
    of_target: tuple[int, ...] = (64, 64)
    norm: bool = True
    table: ManoeuvreTable = ONE_COURSE
    costs: ManoeuvreCosts = STEP_COSTS


class CourseCritic(eqx.Module):
    """Values manoeuvres of one course by two networks.

    Attributes:
        of_waypoint: From (s_wp, m) to log(1 + cost), the cost being the points of Eq. 17 that are
            lost against the straight way; below 0 counts as 0.
        of_target: The same of one ship, from (s_wp, s_i, m).
        table: The manoeuvres among which is chosen; any other can be valued too.
        costs: What was learned to predict.
    """

    of_waypoint: Mlp
    of_target: Mlp
    table: ManoeuvreTable = eqx.field(static=True)
    costs: ManoeuvreCosts = eqx.field(static=True)

    def __init__(self, sizes: CourseCriticSizes, key: PRNGKeyArray):
        waypoint_key, target_key = jax.random.split(key)
        widths = (WAYPOINT_INPUTS, *sizes.of_waypoint, 1)
        self.of_waypoint = Mlp(widths, relu, waypoint_key, sizes.norm)
        widths = (TARGET_INPUTS, *sizes.of_target, 1)
        self.of_target = Mlp(widths, relu, target_key, sizes.norm)
        self.table, self.costs = sizes.table, sizes.costs

    def __call__(self, observation: Observation, ship: ShipParams) -> tuple[Manoeuvres, QValues]:
        """The manoeuvres that there are in one observation, and what each is worth.

        Args:
            observation: Eq. 10-12.
            ship: Own ship; only its speed is used.

        Returns:
            The manoeuvres [c] and their values [c] by sub-task, none above 0: Q_wp what is lost
            of Eq. 17 against the straight way, Q_helm what altering costs, Q_ca what each ship
            costs.
        """
        manoeuvres = self.table.at(situation_of(observation, ship).bearing_rad)
        return manoeuvres, self.value(manoeuvres, observation, ship)

    def value(self, manoeuvres: Manoeuvres, observation: Observation, ship: ShipParams) -> QValues:
        """The same of any manoeuvres of one course, be they in the table or not."""
        at = situation_of(observation, ship)
        waypoint, targets = encode_manoeuvres(manoeuvres, at, ship)
        return QValues(
            -_points(self.of_waypoint(waypoint)[..., 0]),
            -jnp.where(observation.present, _points(self.of_target(targets)[..., 0]), 0.0),
            -self.costs.alter_cost * manoeuvres.altered_rad(at.bearing_rad),
        )

    def along(
        self, course_rad: Float[Array, ""], observation: Observation, ship: ShipParams
    ) -> tuple[Manoeuvres, QValues]:
        """One course, relative to own heading, held for each of the table's durations."""
        bearing = situation_of(observation, ship).bearing_rad
        manoeuvres = self.table.along(course_rad, bearing)
        return manoeuvres, self.value(manoeuvres, observation, ship)


def _points(log_cost: Float[Array, "*b"]) -> Float[Array, "*b"]:
    """A cost from log(1 + cost)."""
    return jnp.expm1(jnp.clip(log_cost, 0.0, MAX_LOG_COST))


def encode_manoeuvres(
    manoeuvres: Manoeuvres, at: Situation, ship: ShipParams
) -> tuple[Float[Array, "c d"], Float[Array, "c n e"]]:
    """The input vectors of both networks for every manoeuvre and every ship.

    Args:
        manoeuvres: Of one course each.
        at: Own ship's surroundings.
        ship: Own ship; only its speed is used.

    Returns:
        Those of the waypoint and those of the targets.
    """
    first = at.bearing_rad + manoeuvres.offset_rad
    held_s = manoeuvres.duration_s
    run = velocity(first, ship.speed_m_s * held_s)
    second = direction(Vector(at.waypoint.x - run.x, at.waypoint.y - run.y))
    turns = wrap_angle(first), wrap_angle(second - first)
    helm = [
        *(f(turn) for turn in turns for f in (jnp.sin, jnp.cos)),
        held_s / 1000.0,
        softsign(held_s / 300.0),
        50.0 * at.rate_of_turn_rad_s,
    ]
    off = manoeuvres.offset_rad
    way = [*helm, turns[0], jnp.sin(off), jnp.cos(off), norm(at.waypoint) / LENGTH_M]
    place, motion = at.position, at.velocity
    first, second, held_s = first[:, None], second[:, None], held_s[:, None]
    mine = velocity(first, ship.speed_m_s)
    relative = Vector(motion.x - mine.x, motion.y - mine.y)
    later = Vector(place.x + relative.x * held_s, place.y + relative.y * held_s)
    then = velocity(second, ship.speed_m_s)
    targets = [
        *_as_seen(place, relative, first, held_s),
        *_as_seen(later, Vector(motion.x - then.x, motion.y - then.y), second, _AHEAD_S),
        *(jnp.asarray(x)[..., None] for x in helm),
    ]
    return (
        jnp.stack(jnp.broadcast_arrays(*way), axis=-1),
        jnp.stack(jnp.broadcast_arrays(*targets), axis=-1),
    )


#: A closest approach is sought so far ahead [s].
_AHEAD_S = 3600.0


def _as_seen(
    place: Vector,
    relative: Vector,
    course_rad: Float[Array, "c 1"],
    until_s: float | Float[Array, "c 1"],
) -> list[Float[Array, "c n"]]:
    """Place, motion and closest approach of ships from own ship on a course (as Eq. 11)."""
    square = relative.x**2 + relative.y**2
    time = -(place.x * relative.x + place.y * relative.y) / jnp.maximum(square, 0.01)
    time = jnp.clip(time, 0.0, until_s)
    nearest = Vector(place.x + relative.x * time, place.y + relative.y * time)
    here, there, motion = (to_body(v, course_rad) for v in (place, nearest, relative))
    return [
        *(softsign(x / scale) for x in here for scale in (1000.0, 6000.0)),
        *(x / 5.0 for x in motion),
        *(softsign(x / 1000.0) for x in there),
        softsign(norm(nearest) / 1000.0),
        softsign(time / 500.0),
    ]
