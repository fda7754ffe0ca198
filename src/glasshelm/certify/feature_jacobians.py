"""What the derivatives of Eq. 10-11 can be while every number of a plot is in an interval.

A plot m is (east, north, heading h, own speed, course c, speed s). Its place is at range R and
bearing β, its relative velocity of size V in direction χ. In these every entry of
∂f/∂m is a product of sines, cosines, lengths and 1/V, each of a narrow interval:

    p·x = R cos(β − x)                    a place along direction x
    ∂V/∂(h, own, c, s) = w(χ),  ∂χ/∂(…) = w(χ + 90°)/V,
    w(x) = (−own sin(x − h), −cos(x − h), s sin(x − c), cos(x − c))
    CPA = ½R [(sin β, cos β) − (sin, cos)(2χ − β)]   does not depend on V

TCPA is clipped to an hour and DCPA is an absolute value; where they bend f the derivative
is any between those of both sides (Clarke 1983).
"""

import dataclasses

import numpy as np
from jaxtyping import Float

from glasshelm.certify.interval_arithmetic import (
    QUARTER_TURN,
    Interval,
    Jet,
    ball,
    concatenate,
    hull,
    point,
    polar,
    stack,
    where,
)
from glasshelm.core.geometry import CPA_HORIZON_S
from glasshelm.env.observe import ANGLE_RAD, DISTANCE_M, FRAMES, LENGTH_M, SPEED_M_S, TIME_S

#: What is nearer to a kink than this counts as on it: float32 may have lost so much.
_NEAR_M, _NEAR_HOUR_S = 0.1, 1.0
_DCPA = 2  # of the four numbers of a meeting
_ANGLES = np.array([False, False, True, False, True, False])
_PLACE = [LENGTH_M, LENGTH_M, float(ANGLE_RAD)]
_UNITS = np.array(
    [*_PLACE, SPEED_M_S, SPEED_M_S, DISTANCE_M, LENGTH_M, LENGTH_M, DISTANCE_M, TIME_S]
)


@dataclasses.dataclass(frozen=True)
class FeatureJacobians:
    """∂f/∂m of each frame, and of the difference of neighbouring frames (newer − older).

    ``frames`` [..., 5, f, 6]; ``steps`` [..., 4, f, 6] is anything where a kink lies on the
    way; ``change`` [..., 4, f] holds the difference itself; ``values`` [..., 5, f] the features;
    ``circle`` [..., 2, 6] is of sine and cosine of the newest bearing.
    """

    frames: Interval
    steps: Interval
    change: Interval
    values: Interval
    circle: Interval


@dataclasses.dataclass(frozen=True)
class _Stretches:
    """Boxes of plots: around each frame, then around each path from one to the next.

    ``way`` is Δm along a path, 0 for a frame.
    """

    midpoint: Float[np.ndarray, "*b stretch 6"]
    radius: Float[np.ndarray, "*b stretch 6"]
    way: Float[np.ndarray, "*b stretch 6"]

    def number(self, i: int) -> Jet:
        return Jet(ball(self.midpoint[..., i], self.radius[..., i]), point(self.way[..., i]))


def _stretches(m: Float[np.ndarray, "*b frames 6"], box: Float[np.ndarray, "*b 6"]) -> _Stretches:
    way = m[..., :-1, :] - m[..., 1:, :]
    way = np.where(_ANGLES, (way + np.pi) % (2 * np.pi) - np.pi, way)
    midpoint = m[..., 1:, :] + 0.5 * way
    radius = np.abs(way) / 2 * (1 + 1e-9) + box[..., None, :]
    whole = np.concatenate([m, midpoint], -2)
    boxes = np.broadcast_to(box[..., None, :], (*radius.shape[:-2], FRAMES, 6))
    whole, still = np.broadcast_arrays(whole, np.zeros(6))
    way = np.concatenate([still[..., :FRAMES, :], way], -2)
    return _Stretches(whole, np.concatenate([boxes, radius], -2), way)


class _Place:
    """A point (east, north) in polar coordinates."""

    def __init__(self, at: _Stretches):
        east, north = at.midpoint[..., 0], at.midpoint[..., 1]
        self.at, centre = at, np.arctan2(east, north)
        ahead, aside = self.spread(centre)
        range_m = np.hypot(east, north)
        length, turn = polar(ball(range_m, ahead), ball(np.zeros_like(range_m), aside))
        bearing = turn + centre
        self.speed = np.hypot(at.way[..., 0], at.way[..., 1])
        self.track = np.arctan2(at.way[..., 0], at.way[..., 1])
        self.range = Jet(length, self.going(bearing))
        self.bearing = Jet(bearing, self.going(bearing + QUARTER_TURN) / length)

    def spread(self, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How far it may be off, along a direction and across."""
        east, north = self.at.radius[..., 0], self.at.radius[..., 1]
        sine, cosine = np.abs(np.sin(direction)), np.abs(np.cos(direction))
        room = 1 + 1e-12
        return (east * sine + north * cosine) * room, (east * cosine + north * sine) * room

    def going(self, direction: Interval) -> Interval:
        """The rate's component."""
        return (-direction + self.track).cosine() * self.speed

    def along(self, direction: Jet) -> Jet:
        """Its component."""
        angle = self.bearing.value - direction.value
        turning = self.range.value * angle.sine() * direction.rate
        return Jet(self.range.value * angle.cosine(), self.going(direction.value) + turning)


def _sway(numbers: list, x) -> list:
    """w(x), of intervals or of jets: the velocity's derivatives in (h, own, c, s), along x."""
    h, own, c, s = numbers
    mine, theirs = x - h, x - c
    return [-(own * mine.sine()), -mine.cosine(), s * theirs.sine(), theirs.cosine()]


def _towards(numbers: list[Jet], x: np.ndarray) -> tuple[Interval, Interval]:
    """The relative velocity along a direction and across, to starboard of it."""
    h, own, c, s = (jet.value for jet in numbers)
    mine, theirs = h - x, c - x
    return s * theirs.cosine() - own * mine.cosine(), s * theirs.sine() - own * mine.sine()


def _total(parts: list[Interval], way: np.ndarray) -> Interval:
    first, *others = (part * way[..., i] for i, part in enumerate(parts))
    for other in others:
        first = first + other
    return first


def _velocity(at: _Stretches, numbers: list[Jet]) -> tuple[Jet, Jet]:
    """Size and direction of the relative velocity."""
    h, own, c, s = (at.midpoint[..., i] for i in range(2, 6))
    east, north = s * np.sin(c) - own * np.sin(h), s * np.cos(c) - own * np.cos(h)
    centre = np.arctan2(east, north)
    size, turn = polar(*_towards(numbers, centre))
    direction, values = turn + centre, [jet.value for jet in numbers]
    way = at.way[..., 2:]
    faster = _total(_sway(values, direction), way)
    turning = _total(_sway(values, direction + QUARTER_TURN), way) / size
    return Jet(size, faster), Jet(direction, turning)


def _later(at: _Stretches, place: _Place, numbers: list[Jet], time: np.ndarray) -> tuple[Jet, Jet]:
    """Distance and direction of where the target will be after ``time``."""
    h, own, c, s = (at.midpoint[..., i] for i in range(2, 6))
    east = at.midpoint[..., 0] + time * (s * np.sin(c) - own * np.sin(h))
    north = at.midpoint[..., 1] + time * (s * np.cos(c) - own * np.cos(h))
    centre = np.arctan2(east, north)
    off = at.midpoint[..., :2]
    here = (
        off[..., 0] * np.sin(centre) + off[..., 1] * np.cos(centre),
        off[..., 0] * np.cos(centre) - off[..., 1] * np.sin(centre),
    )
    both = [
        ball(x, spread + 1e-9 * (1 + np.abs(x))) + moved * time
        for x, spread, moved in zip(
            here, place.spread(centre), _towards(numbers, centre), strict=True
        )
    ]
    length, turn = polar(*both)
    direction, values = turn + centre, [jet.value for jet in numbers]

    def going(x: Interval) -> Interval:
        return place.going(x) + _total(_sway(values, x), at.way[..., 2:]) * time

    return (
        Jet(length, going(direction)),
        Jet(direction, going(direction + QUARTER_TURN) / length),
    )


def _matrix(rows: list[list[Jet | None]], like: np.ndarray) -> Jet:
    """Rows of jets as one [..., rows, 6]; None is 0."""
    zero = point(np.zeros_like(like))
    flat = [[Jet(zero, zero) if x is None else x for x in row] for row in rows]
    return Jet(
        stack([stack([x.value for x in row]) for row in flat], -2),
        stack([stack([x.rate for x in row]) for row in flat], -2),
    )


def _placed(place: _Place, h: Jet) -> tuple[list, list, list]:
    """Rows dx, dy, bearing and distance; rows of the bearing's sine and cosine; values."""
    dx, dy = place.along(h + QUARTER_TURN), place.along(h)
    sine, cosine = place.bearing.sine(), place.bearing.cosine()
    away = place.range.reciprocal()
    none, one = None, Jet(point(np.ones_like(dx.value.low)), dx.rate * 0.0)
    rows = [
        [h.cosine(), -h.sine(), -dy, none, none, none],
        [h.sine(), h.cosine(), dx, none, none, none],
        [cosine * away, -(sine * away), -one, none, none, none],
        [sine, cosine, none, none, none, none],
    ]
    relative = place.bearing - h
    ahead, aside = relative.cosine(), relative.sine()
    circle = [
        [ahead * cosine * away, -(ahead * sine * away), -ahead, none, none, none],
        [-(aside * cosine * away), aside * sine * away, aside, none, none, none],
    ]
    return rows, circle, [dx.value, dy.value, relative.value, place.range.value]


def target_jacobians(
    m: Float[np.ndarray, "*b frames 6"], box: Float[np.ndarray, "*b 6"]
) -> FeatureJacobians:
    """Of Eq. 11 in all six numbers of a plot."""
    at = _stretches(m, box)
    place, numbers = _Place(at), [at.number(i) for i in range(2, 6)]
    h, own, c, s = numbers
    observation, circle, (dx, dy, bearing, range_) = _placed(place, h)
    none = None
    minus = Jet(point(np.full_like(dx.low, -1.0)), dx * 0.0)
    aspect = c - h
    to_side, to_ahead = s * aspect.sine(), s * aspect.cosine()
    moving = [
        [none, none, -to_ahead, none, to_ahead, aspect.sine()],
        [none, none, to_side, minus, -to_side, aspect.cosine()],
    ]
    speeds = [to_side.value, to_ahead.value - own.value]
    # The CPA on an endless course.
    size, way = _velocity(at, numbers)
    slow = size.reciprocal()
    across = way + QUARTER_TURN
    miss, ahead = place.along(across), place.along(way)
    faster, turning = _sway(numbers, way), [x * slow for x in _sway(numbers, across)]
    off = way - h
    side, front = off.cosine(), off.sine()
    cpa_dx, cpa_dy = miss * side, -(miss * front)
    mirror = way * 2.0 - h
    swing = -place.along(mirror), -place.along(mirror + QUARTER_TURN)
    east, north = across.sine(), across.cosine()
    free = [
        [side * east, side * north, *(swing[0] * x for x in turning)],
        [-(front * east), -(front * north), *(swing[1] * x for x in turning)],
        [east, north, *(-(ahead * x) for x in turning)],
        [
            -(way.sine() * slow),
            -(way.cosine() * slow),
            *((ahead * slow * x - miss * y) * slow for x, y in zip(faster, turning, strict=True)),
        ],
    ]
    free[0][2], free[1][2] = free[0][2] - cpa_dy, free[1][2] + cpa_dx
    tcpa = -(ahead.value / size.value)
    # And where the clip holds the time.
    time = np.where(tcpa.low + tcpa.high < 0, -CPA_HORIZON_S, CPA_HORIZON_S)
    time = np.where(np.isnan(time), CPA_HORIZON_S, time)
    distance, whither = _later(at, place, numbers, time)
    held = [
        [_sum(a, b, time) for a, b in zip(observation[i], moving[i], strict=True)] for i in (0, 1)
    ]
    held.append(
        [whither.sine(), whither.cosine(), *(_scaled(x, time) for x in _sway(numbers, whither))]
    )
    held.append([none] * 6)
    values = [
        [cpa_dx.value, dx + speeds[0] * time],
        [cpa_dy.value, dy + speeds[1] * time],
        [miss.value.absolute(), distance.value],
        [tcpa, point(time)],
    ]
    like = dx.low
    bent, meeting = _bent(
        _matrix(free, like), _matrix(held, like), miss.value, tcpa, values, range_
    )
    rows = _matrix([*observation[:3], *moving, observation[3]], like)
    unit = _UNITS[:, None]
    value = concatenate([rows.value, bent.value], -2)
    rate = concatenate([rows.rate, bent.rate], -2)
    features = stack([dx, dy, bearing, *speeds, range_, *meeting])
    return _gathered(at, _over(value, unit), _over(rate, unit), _over(features, _UNITS), circle)


def waypoint_jacobians(
    m: Float[np.ndarray, "*b frames 6"], box: Float[np.ndarray, "*b 6"]
) -> FeatureJacobians:
    """Of Eq. 10."""
    at = _stretches(m, box)
    place, h = _Place(at), at.number(2)
    observation, circle, (dx, dy, bearing, _) = _placed(place, h)
    rows = _matrix(observation[:3], dx.low)
    unit = _UNITS[:3, None]
    features = _over(stack([dx, dy, bearing]), _UNITS[:3])
    return _gathered(at, _over(rows.value, unit), _over(rows.rate, unit), features, circle)


def _over(x: Interval, unit: np.ndarray) -> Interval:
    return x * (1.0 / unit)


def _scaled(x: Jet, time: np.ndarray) -> Jet:
    return x * point(time)


def _sum(a: Jet | None, b: Jet | None, time: np.ndarray) -> Jet | None:
    """a + time·b."""
    if b is None:
        return a
    b = _scaled(b, time)
    return b if a is None else a + b


def _bent(
    free: Jet,
    held: Jet,
    miss: Interval,
    tcpa: Interval,
    values: list[list[Interval]],
    range_: Interval,
) -> tuple[Jet, list[Interval]]:
    """Derivatives of cpa_dx, cpa_dy, dcpa and tcpa with clip and absolute value; the values.

    The rate is anything where a kink lies in the box.
    """
    starboard, port = miss.low > _NEAR_M, miss.high < -_NEAR_M
    column = np.arange(4) == _DCPA
    flip = np.where(port[..., None] & column, -1.0, 1.0)[..., None]
    of_miss = free.value[..., _DCPA, :]
    either = Interval(-of_miss.magnitude, of_miss.magnitude)
    value = free.value * flip
    known = (starboard | port)[..., None]
    dcpa = where(known, value[..., _DCPA, :], either)
    value = where(column[:, None], dcpa[..., None, :], value)
    most, least = CPA_HORIZON_S - _NEAR_HOUR_S, CPA_HORIZON_S + _NEAR_HOUR_S
    inside = tcpa.magnitude < most
    beyond = (tcpa.low > least) | (tcpa.high < -least)
    astride = (tcpa.high >= most) & (tcpa.low <= -most)
    anything = Interval(np.full_like(value.low, -np.inf), np.full_like(value.low, np.inf))

    def choose(a: Interval, b: Interval, both: Interval) -> Interval:
        extra = (None,) * (a.low.ndim - inside.ndim)
        one, other = inside[(..., *extra)], beyond[(..., *extra)]
        return where(one, a, where(other, b, both))

    both = hull(value, held.value)
    whole = choose(value, held.value, where(astride[..., None, None], anything, both))
    rate = free.rate * flip
    smooth = known[..., None] | ~column[:, None]
    rate = choose(where(smooth, rate, anything), held.rate, anything)
    farthest = range_.high
    limits = [(-farthest, farthest)] * 2 + [(0.0 * farthest, farthest)]
    limits.append((-CPA_HORIZON_S + 0.0 * farthest, CPA_HORIZON_S + 0.0 * farthest))
    limited = []
    for (a, b), limit in zip(values, limits, strict=True):
        wide = Interval(*limit)
        limited.append(choose(a, b, where(astride, wide, hull(a, b))).within(*limit))
    return Jet(whole, rate), limited


def _gathered(
    at: _Stretches, value: Interval, rate: Interval, features: Interval, circle: list[list]
) -> FeatureJacobians:
    """Split into frames and the paths between them."""
    axis = at.midpoint.ndim - 2
    every = (slice(None),) * axis
    way = at.way[..., None, :]
    moved = where(way == 0, point(0.0), value * way)  # ∞·0 is 0 here: what does not move
    moved = Interval(moved.low.sum(-1), moved.high.sum(-1))
    frames, newest = (*every, slice(0, FRAMES)), (*every, slice(0, 1))
    paths = (*every, slice(FRAMES, None))
    flat = [
        [None if x is None else Jet(x.value[newest], x.rate[newest]) for x in row] for row in circle
    ]
    sides = _matrix(flat, at.midpoint[..., 0][newest]).value[(*every, 0)]
    return FeatureJacobians(value[frames], rate[paths], moved[paths], features[frames], sides)
