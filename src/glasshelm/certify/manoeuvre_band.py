"""The certified band of a choice among manoeuvres, while the sensors err within known bounds.

For every manoeuvre each part of its value lies between two bounds that are linear in the errors
(:mod:`glasshelm.certify.manoeuvre_costs`). They say what the chosen manoeuvre is worth at least and
at most, and how near each ship can come. Another manoeuvre can be chosen only if it is not surely
surpassed, by the chosen one or by one of those that are worth most at least: if no lower bound of
a *difference* of two values is above 0. In the difference, errors that touch both manoeuvres
alike cancel.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from glasshelm.certify.manoeuvre_costs import (
    N_ERRORS,
    Bounds,
    Linear,
    ShipBounds,
    TargetErrors,
    helm_bounds,
    target_bounds,
    waypoint_bounds,
)
from glasshelm.certify.measurements import N_OWN_ERRORS, RawPlots, SensorErrors, observe_plots
from glasshelm.certify.path_enclosure import (
    HEADING_ROUNDING,
    RATE_ROUNDING,
    PathEnclosure,
    PathErrors,
    enclose_paths,
)
from glasshelm.core.errors import InputError
from glasshelm.core.geometry import wrap_angle
from glasshelm.env.step import EnvSettings
from glasshelm.explanation.manoeuvre_explanation import SAME_COURSE_RAD, alternatives, choose
from glasshelm.pilots.glassbox import GlassboxPilot
from glasshelm.planning.simulated_critic import SimulatedCritic
from glasshelm.planning.situation import Situation, rudder_towards, situation_of
from glasshelm.ship.autopilot import autopilot_for
from glasshelm.ship.nomoto import ShipParams

#: Between frames that are nearer than this [m, rad], own ship may count as at rest or not.
_AT_REST_M, _AT_REST_RAD = 1.0, 1e-4
#: So many manoeuvres, those worth most at least, are tried as surpassing others.
_RIVALS = 16


class ValueBounds(eqx.Module):
    """A value by sub-task, at least or at most."""

    waypoint: Float[Array, "*b"]
    by_ship: Float[Array, "*b n"]
    helm: Float[Array, "*b"]
    total: Float[Array, "*b"]


class ManoeuvreBand(eqx.Module):
    """What is certain of a choice among manoeuvres.

    Attributes:
        chosen: The row of the manoeuvre that is chosen of what is measured.
        course_rad: The course off own heading that each manoeuvre begins with.
        low: What each manoeuvre is worth at least, by sub-task.
        high: The same at most.
        margin: The deepest that each ship can come into the domain on each manoeuvre (Eq. 13,
            unclipped: above 0 inside).
        range_m: The least range of each ship on each manoeuvre.
        gain_low: What the chosen manoeuvre is worth more than each, at least.
        gain_high: The same at most.
        possible: Which manoeuvres can be the best of all for some errors.
        rudder_low: The least rudder with which one of the possible manoeuvres begins, as a fraction
            of the limit, starboard positive.
        rudder_high: The largest.
        rows: The manoeuvres that a frame compares with the chosen one.
        compared: Whether there is such a manoeuvre.
        rudder: The rudder of what is measured.
    """

    chosen: Int[Array, ""]
    course_rad: Float[Array, " c"]
    low: ValueBounds
    high: ValueBounds
    margin: Float[Array, "c n"]
    range_m: Float[Array, "c n"]
    gain_low: Float[Array, " c"]
    gain_high: Float[Array, " c"]
    possible: Bool[Array, " c"]
    rudder_low: Float[Array, ""]
    rudder_high: Float[Array, ""]
    rows: Int[Array, " a"]
    compared: Bool[Array, " a"]
    rudder: Float[Array, ""]

    @property
    def possible_courses_rad(self) -> list[float]:
        """The courses off own heading with which the best manoeuvre can begin, port to starboard.

        They may go past half a turn from the heading: they are counted from the chosen one, and of
        those that are the same within a degree as the chosen one, only that is given.
        """
        chosen = float(self.course_rad[self.chosen])
        off = np.asarray(self.course_rad, np.float64)[np.asarray(self.possible)] - chosen
        off = (off + np.pi) % (2 * np.pi) - np.pi
        others = np.unique(np.round(off[np.abs(off) > SAME_COURSE_RAD], 6))
        return (chosen + np.unique(np.append(others, 0.0))).tolist()


def certified_choice(pilot: GlassboxPilot, scene: RawPlots, errors: SensorErrors) -> ManoeuvreBand:
    """Bounds on the values of all manoeuvres, for every scene within ``errors`` of this one.

    Args:
        pilot: A pilot whose critic simulates.
        scene: What is measured.
        errors: The largest errors.

    Returns:
        What is certain of the choice.

    Raises:
        InputError: The pilot has been given no ship, or its critic does not simulate.
    """
    critic = require_simulated_critic(pilot)
    if pilot.ship is None:
        raise InputError(f"pilot {pilot.name!r} is for any ship: for_ship(ship) gives it one")
    # Own ship's numbers are constants of the program: the closed loop is analysed before it runs.
    ship = jax.tree.map(float, pilot.ship)
    return _certified(critic, ship, scene, errors)


def require_simulated_critic(pilot: GlassboxPilot) -> SimulatedCritic:
    """The pilot's critic. InputError if it does not simulate: there are no bounds for others."""
    if not isinstance(pilot.critic, SimulatedCritic):
        raise InputError(
            f"{pilot.name} has a learned critic; only a simulated one can be certified"
        )
    return pilot.critic


@eqx.filter_jit
def _certified(
    critic: SimulatedCritic, ship: ShipParams, scene: RawPlots, errors: SensorErrors
) -> ManoeuvreBand:
    observation = observe_plots(scene)
    at = situation_of(observation, ship)
    manoeuvres, values = critic(observation, ship)
    keep = np.arange(manoeuvres.offset_rad.size) >= len(critic.table.off_waypoint())
    own = errors.own()
    path_errors = _path_errors(scene, at, own, ship)
    path = enclose_paths(manoeuvres, at, keep, path_errors, ship, critic.costs)
    here = PathEnclosure.here(at, path_errors, 1)
    bearing, slopes, slack, _ = here.bearing_of(at.waypoint, path_errors)
    off_bow = bearing[0], slopes[:, 0] - here.heading[:, 0], slack[0]
    waypoint = waypoint_bounds(path, at.waypoint, path_errors, critic.costs)
    helm = helm_bounds(manoeuvres, keep, off_bow, critic.costs)

    def one(plot: Array, position: Array, velocity: Array) -> ShipBounds:
        target = _target_errors(plot, position, velocity, own, errors.target(), ship)
        return target_bounds(path, target, float(ship.loa_m), critic.costs)

    where = jnp.stack(at.position, -1), jnp.stack(at.velocity, -1)
    ships = jax.lax.map(lambda x: one(*x), (scene.targets[:, 0], *where))
    ships = _without_absent(ships, scene.present)
    chosen = choose(values)
    gains, low = _Gains(waypoint, helm, ships), _values(waypoint, helm, ships, low=True)
    gain_low, gain_high = gains.at_least(chosen), gains.at_most(chosen)
    # What any other surely surpasses is never the best.
    surest = jax.lax.top_k(low.total, _RIVALS)[1]
    surpassed = (jax.lax.map(gains.at_least, surest) > 0.0).any(0)
    course = wrap_angle(at.bearing_rad + manoeuvres.offset_rad)
    swing = jnp.where(keep, 0.0, jnp.abs(off_bow[1]).sum() + off_bow[2]) + HEADING_ROUNDING
    possible = (gain_low <= 0.0) & ~surpassed | (jnp.arange(course.size) == chosen)
    rudder_low, rudder_high = _rudders(course, swing, at, path_errors, ship)
    rows, compared = alternatives(values, course, jnp.array(course.size - 1))
    return ManoeuvreBand(
        chosen,
        course,
        low,
        _values(waypoint, helm, ships, low=False),
        ships.margin.T,
        ships.range_m.T,
        gain_low,
        gain_high,
        possible,
        jnp.where(possible, rudder_low, 1.0).min(),
        jnp.where(possible, rudder_high, -1.0).max(),
        rows,
        compared,
        rudder_towards(manoeuvres.offset_rad[chosen], observation, ship),
    )


def _path_errors(
    scene: RawPlots, at: Situation, own: Float[Array, "4"], ship: ShipParams
) -> PathErrors:
    """Own ship's errors, in the frame of its measured heading.

    The rate of turn is that of the waypoint's bearing over two frames. An error of the place is the
    same in both, so only what their distance makes of it remains.
    """
    sine, cosine = jnp.sin(scene.waypoint[0, 2]), jnp.cos(scene.waypoint[0, 2])
    place = jnp.array([[cosine, -sine], [sine, cosine]]) * own[:2]
    off = jnp.sqrt((own[:2] ** 2).sum())
    now, before = scene.waypoint[0], scene.waypoint[1]
    way = jnp.sqrt(((now[:2] - before[:2]) ** 2).sum())
    range_m = jnp.sqrt((now[:2] ** 2).sum())
    rest = jnp.maximum(range_m - way - off, 1.0)
    step_s, speed = EnvSettings().step_s, ship.speed_m_s
    rate = off * way / rest**2 / step_s + speed * (2 * off / rest + own[2]) / rest
    turned = jnp.abs(wrap_angle(now[2] - before[2]))
    uncertain = (way < _AT_REST_M) & (turned < _AT_REST_RAD) & jnp.any(now != before)
    rate += jnp.where(uncertain, speed / rest + (turned + way / rest) / step_s, 0.0)
    unmoved = jnp.all(now == before)
    return PathErrors(place, own[2], jnp.where(unmoved, 0.0, rate + RATE_ROUNDING))


def _target_errors(
    plot: Float[Array, "6"],
    position: Float[Array, "2"],
    velocity: Float[Array, "2"],
    own: Float[Array, "4"],
    target: Float[Array, "4"],
    ship: ShipParams,
) -> TargetErrors:
    """One target in the frame of own ship's measured heading, and what errors make of it.

    Own ship sails at its model's speed, so the critic takes the target's velocity relative to the
    measured one and adds that.
    """
    heading, own_speed, course, speed = plot[2], plot[3], plot[4], plot[5]
    sine, cosine = jnp.sin(heading), jnp.cos(heading)
    east, north = jnp.array([cosine, sine]), jnp.array([-sine, cosine])
    way = jnp.array([jnp.sin(course - heading), jnp.cos(course - heading)])
    side = jnp.array([way[1], -way[0]])
    starboard, ahead, none = jnp.array([1.0, 0.0]), jnp.array([0.0, 1.0]), jnp.zeros(2)
    slower = ship.speed_m_s - own_speed
    # An own ship shown too far east sees everything too far west.
    fixed = [-east * own[0], -north * own[1], none, none,
             east * target[0], north * target[1], none, none]  # fmt: skip
    moving = [none, none, starboard * slower * own[2], -ahead * own[3],
              none, none, side * speed * target[2], way * target[3]]  # fmt: skip
    slack = 0.5 * speed * target[2] ** 2 + target[3] * target[2]
    slack += 0.5 * jnp.abs(slower) * own[2] ** 2 + own[3] * own[2]
    return TargetErrors(position, velocity, jnp.stack(fixed, -1), jnp.stack(moving, -1), slack)


def _without_absent(ships: ShipBounds, present: Bool[Array, " n"]) -> ShipBounds:
    """Bounds of absent ships are those of ships far off; slopes [g, n, c] in one array."""
    ships = jax.tree.map(
        lambda x: jnp.where(present.reshape(-1, *(1,) * (x.ndim - 1)), x, 0.0), ships
    )
    off = ~present[:, None]
    return ships._replace(
        cost=jax.tree.map(lambda x: jnp.moveaxis(x, 0, -2), ships.cost),
        margin=jnp.where(off, -jnp.inf, ships.margin),
        range_m=jnp.where(off, jnp.inf, ships.range_m),
    )


def _values(waypoint: Bounds, helm: Bounds, ships: ShipBounds, low: bool) -> ValueBounds:
    """What every manoeuvre is worth at least, or at most."""
    way, altering = (part.low.least if low else part.high.most for part in (waypoint, helm))
    cost = jnp.maximum(ships.cost.high.most, 0.0) if low else ships.low_cost
    return ValueBounds(way, -cost.T, jnp.minimum(altering, 0.0), way + altering - cost.sum(0))


class _Gains:
    """Bounds of the differences of two manoeuvres, of which one is given and the other is each."""

    def __init__(self, waypoint: Bounds, helm: Bounds, ships: ShipBounds):
        self._low, self._high = waypoint.low + helm.low, waypoint.high + helm.high
        self._dear, self._cheap = ships.cost.high, _best_of(ships.cost.low, ships.low_cost)

    def at_least(self, row: Int[Array, ""]) -> Float[Array, " c"]:
        """What one manoeuvre is worth more than each, at least; nothing more than itself."""
        low = _least(_row(self._low, row), _row(self._dear, row), self._high, self._cheap)
        return jnp.where(jnp.arange(low.size) == row, 0.0, low)

    def at_most(self, row: Int[Array, ""]) -> Float[Array, " c"]:
        """The same at most."""
        high = -_least(self._low, self._dear, _row(self._high, row), _row(self._cheap, row))
        return jnp.where(jnp.arange(high.size) == row, 0.0, high)


def _least(a: Linear, cost_a: Linear, b: Linear, cost_b: Linear) -> Float[Array, " c"]:
    """The least of (a − cost_a) − (b − cost_b): own ship's errors are shared by all."""
    own, each = a + -b, cost_b + -cost_a
    shift = own.shift + each.shift.sum(0)
    slopes = own.slopes + each.slopes[:N_OWN_ERRORS].sum(1)
    swing = jnp.abs(slopes).sum(0) + jnp.abs(each.slopes[N_OWN_ERRORS:]).sum((0, 1))
    return shift - swing - 1e-6 * (jnp.abs(own.shift) + jnp.abs(each.shift).sum(0) + swing)


def _row(part: Linear, row: Int[Array, ""]) -> Linear:
    """One manoeuvre, beside which all others can stand."""
    return jax.tree.map(lambda x: jnp.take(x, row, -1)[..., None], part)


def _best_of(linear: Linear, least: Float[Array, "n c"]) -> Linear:
    """A lower bound of costs: the linear one, or the constant where that says much more."""
    return Linear.where(least > linear.least, Linear.constant(least, N_ERRORS), linear)


def _rudders(
    course: Float[Array, " c"],
    swing: Float[Array, " c"],
    at: Situation,
    errors: PathErrors,
    ship: ShipParams,
) -> tuple[Float[Array, " c"], Float[Array, " c"]]:
    """The least and the largest rudder with which each manoeuvre begins."""
    pilot, limit = autopilot_for(ship), ship.rudder_limit_rad
    rate = jnp.zeros_like(course) + at.rate_of_turn_rad_s
    around = jnp.abs(course) + swing >= jnp.pi
    low = pilot.rudder_rad(course - swing, rate + errors.rate_rad_s) / limit
    high = pilot.rudder_rad(course + swing, rate - errors.rate_rad_s) / limit
    return jnp.where(around, -1.0, low), jnp.where(around, 1.0, high)
