"""Linear bounds of what manoeuvres are worth, in the errors of the measurements.

Own ship's place and heading come as slopes and slack (:mod:`glasshelm.certify.path_enclosure`), a
target's as its position and velocity. So at every step the target's place in own ship's body frame
is q + Σ_g q_g·φ_g within a slack η, φ_g ∈ [−1, 1] the eight errors of own ship and target.

Eq. 13 is 1 − g(q), and g, the gauge of the domain, is convex. Its tangent plane is below it, so the
danger has a linear upper bound without a second-order term; a lower bound takes
(Σ_axes (c·r)²)/2g more, with r how far q reaches along an axis and c the axis' scale. A smoothed
exposure has a chord above it and a tangent below; the worst moment is at least that of any one
step, and at most a merger of the steps' upper bounds. All are linear in the same errors, so they
add over steps, and over ships; in the difference of two manoeuvres, what both share cancels.
"""

from collections.abc import Callable
from functools import reduce
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from glasshelm.certify.measurements import N_OWN_ERRORS, N_TARGET_ERRORS
from glasshelm.certify.path_enclosure import PLACE_ROUNDING, PathEnclosure, PathErrors
from glasshelm.core.geometry import Vector, wrap_angle
from glasshelm.env.rewards import course_reward
from glasshelm.env.step import EnvSettings
from glasshelm.planning.manoeuvres import Manoeuvres
from glasshelm.planning.simulated_critic import ManoeuvreCosts
from glasshelm.ship.domain import AHEAD_LOA, ASTERN_LOA, PORT_LOA, STARBOARD_LOA

N_ERRORS = N_OWN_ERRORS + N_TARGET_ERRORS
#: What float32 may lose in a sum of costs, of its size.
SUM_ROUNDING = 4e-6
#: And in Eq. 13.
GAUGE_ROUNDING = 3e-7
#: Largest slope and curvature of Eq. 17, and its kinks ahead and astern, of radians.
_CURVATURE = 0.2 * 0.9 * (180.0 / np.pi / 60.0) ** 2
_KINK_AHEAD = 2 * 0.2 * 0.1 / np.pi
_KINK_ASTERN = _KINK_AHEAD + 2 * 0.2 * 0.9 * np.pi * (180 / np.pi / 60) ** 2 * np.exp(-4.5)
_MOST_REWARD = 0.2
#: Below this Eq. 13 does not matter, unclipped.
_FAR = -1.0
#: So much more must a constant bound of Eq. 13 say than a linear one to be preferred.
_WORTH = 0.1


class Linear(eqx.Module):
    """shift + slopes·φ: one number for each manoeuvre, ``slopes`` [g, *c] in so many errors."""

    shift: Float[Array, "*c"]
    slopes: Float[Array, "g *c"]

    @property
    def swing(self) -> Float[Array, "*c"]:
        return jnp.abs(self.slopes).sum(0)

    @property
    def least(self) -> Float[Array, "*c"]:
        return self.shift - self.swing

    @property
    def most(self) -> Float[Array, "*c"]:
        return self.shift + self.swing

    def __add__(self, other: "Linear") -> "Linear":
        return Linear(self.shift + other.shift, self.slopes + other.slopes)

    def __mul__(self, scale: Float[Array, "*c"] | float) -> "Linear":
        return Linear(self.shift * scale, self.slopes * scale)

    def __neg__(self) -> "Linear":
        return Linear(-self.shift, -self.slopes)

    def raised(self, by: Float[Array, "*c"] | float) -> "Linear":
        return Linear(self.shift + by, self.slopes)

    @staticmethod
    def constant(value: Float[Array, "*c"], errors: int = N_ERRORS) -> "Linear":
        return Linear(value, jnp.zeros((errors, *value.shape)))

    @staticmethod
    def where(test: Array, a: "Linear", b: "Linear") -> "Linear":
        return jax.tree.map(lambda x, y: jnp.where(test, x, y), a, b)


class Bounds(NamedTuple):
    """A number that is at least ``low`` and at most ``high`` for all errors."""

    low: Linear
    high: Linear


class ShipBounds(NamedTuple):
    """What one ship costs on each manoeuvre, and how near it comes.

    ``low_cost`` is never negative and may be better than the linear bound; ``margin`` and
    ``range_m`` are the deepest Eq. 13 (unclipped) and the least range that the errors allow.
    """

    cost: Bounds
    low_cost: Float[Array, "*c"]
    margin: Float[Array, "*c"]
    range_m: Float[Array, "*c"]


def larger(a: Linear, b: Linear) -> Linear:
    """An upper bound of the larger of two: the chord of max(0, b − a) over the errors."""
    difference = b + -a
    low, high = difference.least, difference.most
    share = jnp.clip(high / jnp.maximum(high - low, 1e-12), 0.0, 1.0)
    share = jnp.where(high <= 0.0, 0.0, jnp.where(low >= 0.0, 1.0, share))
    mixed = (high > 0.0) & (low < 0.0)
    return (a + difference * share).raised(jnp.where(mixed, -share * low, 0.0))


class _Scales(NamedTuple):
    """Of a gauge, on each side of own ship [1/m]."""

    starboard: float
    port: float
    ahead: float
    astern: float


class _Gauge(NamedTuple):
    """Upper and lower linear bounds of 1 − g, and their own ends."""

    high: Linear
    low: Linear
    most: Float[Array, " c"]
    least: Float[Array, " c"]


def gauge_bounds(
    place: Vector,
    across: Float[Array, "g c"],
    along: Float[Array, "g c"],
    slack: Float[Array, " c"],
    scales: _Scales,
    centre_slack: Float[Array, " c"],
) -> _Gauge:
    """Bounds of 1 − √((c·x)² + (c'·y)²), the scales c on each side of own ship.

    Args:
        place: The nominal place: starboard and ahead [m].
        across: What each error adds to starboard [m].
        along: What each error adds ahead [m].
        slack: What else the place may be off [m].
        scales: Of the gauge.
        centre_slack: What the range alone may be off [m], however own ship is turned.
    """
    starboard, port, ahead, astern = scales
    x, y = place
    c_x, c_y = jnp.where(x >= 0, starboard, port), jnp.where(y >= 0, ahead, astern)
    gauge = jnp.sqrt((x * c_x) ** 2 + (y * c_y) ** 2)
    safe = jnp.maximum(gauge, 1e-6)
    toward_x, toward_y = x * c_x * c_x / safe, y * c_y * c_y / safe
    slopes = -(toward_x * across + toward_y * along)
    swing = jnp.abs(slopes).sum(0)
    off = jnp.sqrt(toward_x**2 + toward_y**2) * slack + GAUGE_ROUNDING * (1.0 + gauge)
    reach_x, reach_y = jnp.abs(across).sum(0) + slack, jnp.abs(along).sum(0) + slack
    both_x, both_y = reach_x >= jnp.abs(x), reach_y >= jnp.abs(y)
    w_x = jnp.where(both_x, max(starboard, port), c_x) * reach_x
    w_y = jnp.where(both_y, max(ahead, astern), c_y) * reach_y
    square = w_x * w_x + w_y * w_y
    range_m = jnp.sqrt(x * x + y * y)
    finest, coarsest = max(scales), min(scales)
    spread = swing + off
    farthest = jnp.sqrt(gauge * gauge + 2 * gauge * spread + square)
    farthest = jnp.minimum(farthest, (range_m + centre_slack) * finest)
    nearest = jnp.maximum(gauge - spread, (range_m - centre_slack) * coarsest)
    nearest = jnp.maximum(nearest, 0.0)
    most, least = 1.0 - nearest, 1.0 - farthest
    upper = Linear(1.0 - gauge + off, slopes)
    upper = Linear.where(upper.most > most + _WORTH, Linear.constant(most), upper)
    lower = Linear(1.0 - gauge - off - 0.5 * square / safe, slopes)
    lower = Linear.where(lower.least < least - _WORTH, Linear.constant(least), lower)
    return _Gauge(upper, lower, most, least)


class _Worst(NamedTuple):
    """The worst moment so far: linear bounds, and its largest value."""

    high: Linear
    low: Linear
    most: Float[Array, " c"]

    @staticmethod
    def nothing(like: Float[Array, " c"]) -> "_Worst":
        none = Linear.constant(like + _FAR)
        return _Worst(none, none, like - 1e6)

    def and_then(self, now: _Gauge) -> "_Worst":
        nearer = now.low.shift > self.low.shift
        return _Worst(
            larger(self.high, now.high),
            Linear.where(nearer, now.low, self.low),
            jnp.maximum(self.most, now.most),
        )

    def positive(self) -> Bounds:
        """Bounds of its part above 0."""
        none = Linear.constant(jnp.zeros_like(self.most))
        high = larger(none, self.high)
        high = Linear.where(self.most <= 0.0, none, high)
        return Bounds(Linear.where(self.low.shift > 0.0, self.low, none), high)


def _soft(depth: Float[Array, " c"], costs: ManoeuvreCosts) -> Float[Array, " c"]:
    depth, soft = jnp.maximum(depth + costs.danger_margin, 0.0), costs.danger_softness
    return jnp.where(depth < 2 * soft, depth**2 * (1 / (4 * soft)), depth - soft)


def _soft_slope(depth: Float[Array, " c"], costs: ManoeuvreCosts) -> Float[Array, " c"]:
    return jnp.clip((depth + costs.danger_margin) * (1 / (2 * costs.danger_softness)), 0.0, 1.0)


def _exposure(now: _Gauge, costs: ManoeuvreCosts) -> Bounds:
    """Bounds of the smoothed danger: a tangent below, the chord above."""
    at = now.low.shift
    slope = _soft_slope(at, costs)
    low = (now.low.raised(-at) * slope).raised(_soft(at, costs))
    least, most = now.high.least, now.high.most
    bottom, top, span = _soft(least, costs), _soft(most, costs), most - least
    chord = jnp.where(span > 1e-4, (top - bottom) / jnp.maximum(span, 1e-4), 0.0)
    return Bounds(low, (now.high.raised(-most) * chord).raised(top))


def _squared(part: Bounds) -> Bounds:
    """Bounds of the square of what is never negative: a tangent below, the chord above."""
    at = jnp.maximum(part.low.shift, 0.0)
    low = (part.low.raised(-at) * (2.0 * at)).raised(at**2)
    least, most = part.high.least, part.high.most
    return Bounds(low, (part.high.raised(-most) * (least + most)).raised(most**2))


class TargetErrors(NamedTuple):
    """A target as measured, and its errors, in the frame of own ship's position and heading.

    Attributes:
        position: Its place [m].
        velocity: Its velocity as own ship's critic understands it [m/s].
        fixed: What each of the eight errors adds to its place at once, [2, 8] [m].
        moving: What each adds to its velocity, [2, 8] [m/s].
        slack_m_s: What the velocity may be off besides.
    """

    position: Float[Array, "2"]
    velocity: Float[Array, "2"]
    fixed: Float[Array, "2 8"]
    moving: Float[Array, "2 8"]
    slack_m_s: Float[Array, ""]


def target_bounds(
    path: PathEnclosure, target: TargetErrors, loa_m: float, costs: ManoeuvreCosts
) -> ShipBounds:
    """Bounds of −Q_ca of one ship on each manoeuvre.

    Args:
        path: Own ship at every step [k, c].
        target: The ship.
        loa_m: Own ship's length.
        costs: The critic's.
    """
    domain = _Scales(*(1.0 / (a * loa_m) for a in (STARBOARD_LOA, PORT_LOA, AHEAD_LOA, ASTERN_LOA)))
    circle = _Scales(*(1.0 / (costs.near_loa * loa_m),) * 4)
    zero = jnp.zeros_like(path.place_slack[0])
    idle = ((0, N_ERRORS - path.x.shape[1]), (0, 0))

    def step(carry: tuple, now: tuple[PathEnclosure, Array]) -> tuple[tuple, None]:
        exposure, lowest, domain_worst, near_worst = carry
        own, time = now
        place = target.position + time * target.velocity
        off = target.fixed + time * target.moving
        body = own.ahead.body(Vector(*place))
        # In the frame of the beginning, then turned into own ship's.
        east, north = off[0][:, None] - jnp.pad(own.x, idle), off[1][:, None] - jnp.pad(own.y, idle)
        way, turn = own.ahead.way, jnp.pad(own.heading, idle)
        across = east * way.y - north * way.x - body.y * turn
        along = east * way.x + north * way.y + body.x * turn
        rounding = PLACE_ROUNDING * (jnp.abs(place).sum() + time * jnp.abs(target.velocity).sum())
        still = own.place_slack + time * target.slack_m_s + rounding
        moved = jnp.sqrt(east**2 + north**2).sum(0) + still
        range_m, turned = jnp.sqrt(body.x**2 + body.y**2), own.heading_radius
        twisted = range_m * (own.heading_slack + 0.5 * turned**2) + moved * turned
        danger = gauge_bounds(body, across, along, still + twisted, domain, moved)
        near = gauge_bounds(body, across, along, still, circle, moved)
        low, high = _exposure(danger, costs)
        carry = (
            Bounds(exposure.low + low, exposure.high + high),
            lowest + _soft(danger.least, costs),
            domain_worst.and_then(danger),
            near_worst.and_then(near),
        )
        return carry, None

    none = Linear.constant(zero)
    start = (Bounds(none, none), zero, _Worst.nothing(zero), _Worst.nothing(zero))
    times = costs.step_s * (1.0 + jnp.arange(path.lost.shape[0], dtype=jnp.float32))
    carry, _ = jax.lax.scan(step, start, (path, times))
    exposure, lowest, worst, nearest = carry
    deep, near = worst.positive(), _squared(nearest.positive())
    weight = costs.step_s / EnvSettings().step_s * costs.danger_weight

    def total(of: Callable[[Bounds], Linear]) -> Linear:
        return of(exposure) * weight + of(deep) * costs.worst_weight + of(near) * costs.near_weight

    high, low = total(lambda b: b.high), total(lambda b: b.low)
    margin, range_m = worst.most, costs.near_loa * loa_m * jnp.maximum(1.0 - nearest.most, 0.0)
    surely = weight * lowest
    rounding = SUM_ROUNDING * (jnp.abs(high.shift) + high.swing + 10.0 * (high.most > 0.0))
    low = low.raised(-rounding)
    return ShipBounds(
        Bounds(low, high.raised(rounding)),
        jnp.maximum(jnp.maximum(low.least, surely - rounding), 0.0),
        margin,
        range_m,
    )


def waypoint_bounds(
    path: PathEnclosure, waypoint: Vector, errors: PathErrors, costs: ManoeuvreCosts
) -> Bounds:
    """Bounds of Q_wp (Eq. 17, summed) of each manoeuvre, linear in own ship's errors."""

    def one(own: PathEnclosure) -> Bounds:
        bearing, slopes, slack, in_doubt = own.bearing_of(waypoint, errors)
        angle = wrap_angle(bearing - own.ahead.heading)
        slopes = slopes - own.heading
        slack = slack + own.heading_slack
        radius = jnp.abs(slopes).sum(0) + slack
        value = course_reward(angle)
        steep = jax.vmap(jax.grad(course_reward))(angle)
        ahead = _KINK_AHEAD * jnp.maximum(radius - jnp.abs(angle), 0.0)
        astern = _KINK_ASTERN * jnp.maximum(radius - (jnp.pi - jnp.abs(angle)), 0.0)
        rest = jnp.abs(steep) * slack + 0.5 * _CURVATURE * radius**2 + ahead + astern + 1e-6
        unknown = in_doubt | own.lost | (jnp.abs(slopes * steep).sum(0) + rest > _MOST_REWARD)
        form = Linear(value, jnp.where(unknown, 0.0, slopes * steep))
        low = Linear.where(unknown, Linear.constant(0.0 * value, 3), form.raised(-rest))
        most = Linear.constant(0.0 * value + _MOST_REWARD + 1e-6, 3)
        return Bounds(low, Linear.where(unknown, most, form.raised(rest)))

    every = jax.vmap(one)(path)
    weight = costs.step_s / EnvSettings().step_s

    def own_errors(part: Linear) -> Linear:
        slopes = jnp.pad(weight * part.slopes.sum(0), ((0, N_OWN_ERRORS - 3), (0, 0)))
        return Linear(weight * part.shift.sum(0), slopes)

    return Bounds(own_errors(every.low), own_errors(every.high))


def helm_bounds(
    manoeuvres: Manoeuvres,
    keep: Bool[np.ndarray, " c"],
    bearing: tuple[Float[Array, ""], Float[Array, "3"], Float[Array, ""]],
    costs: ManoeuvreCosts,
) -> Bounds:
    """Bounds of Q_helm: what altering course costs, linear in own ship's errors.

    ``bearing`` is that of the waypoint off the bow: nominal, slopes and slack.
    """
    angle, slopes, slack = bearing
    # From the heading to the first course, or from the last one back to the waypoint.
    first = wrap_angle(jnp.where(keep, angle, angle + manoeuvres.offset_rad))
    radius = jnp.abs(slopes).sum() + slack
    low_side = jnp.maximum(radius - jnp.abs(first), 0.0)
    high_side = jnp.maximum(radius - (jnp.pi - jnp.abs(first)), 0.0)
    rest = slack + 2.0 * (low_side + high_side) + 1e-6
    form = Linear(
        -costs.alter_cost * manoeuvres.altered_rad(angle),
        -costs.alter_cost * jnp.pad(jnp.sign(first) * slopes[:, None], ((0, 1), (0, 0))),
    )
    return Bounds(form.raised(-costs.alter_cost * rest), form.raised(costs.alter_cost * rest))


def summed(parts: list[Linear]) -> Linear:
    return reduce(lambda a, b: a + b, parts)
