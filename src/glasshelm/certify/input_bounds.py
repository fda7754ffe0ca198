"""Linear bounds of a network's inputs in the errors of the sensors.

With f a feature (Eq. 10-11) and the error θ in a box, f(m + θ) = f(m) + ∫₀¹ J(m + tθ)·θ dt:
the mean value theorem, with intervals of J = ∂f/∂m over boxes that grow with t.
The magnified differences of the input features ``fine`` need more: errors that both frames
share all but cancel in them. On the straight path from one plot to the next,
D(θ) − D(0) ∈ (∂²f/∂m² · Δm)·θ, with the second derivative over path and box.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Array, Float

from glasshelm.certify.feature_jacobians import (
    FeatureJacobians,
    target_jacobians,
    waypoint_jacobians,
)
from glasshelm.certify.interval_arithmetic import Interval
from glasshelm.certify.measurements import N_OWN_ERRORS, N_TARGET_ERRORS
from glasshelm.core.geometry import CPA_HORIZON_S
from glasshelm.env.observe import ANGLE_RAD, DISTANCE_M, LENGTH_M, SPEED_M_S, TIME_S
from glasshelm.networks.input_features import GAIN, LENGTHS, NEAR, Lens

_BEARING, _CPA_X = 2, 6
#: Boxes grow from the midpoint to the whole in so many steps.
SHELLS = 2
#: What evaluating a feature in float32 may lose, of its size or of 1.
_ROUNDING = 4e-7

Numbers = Float[np.ndarray | Array, "..."]


class AffineForm(NamedTuple):
    """Numbers known to lie within ``slack`` of centre + slope·φ for all symbols φ in [−1, 1].

    The symbols, on the last axis of ``slope``, are own ship's four errors, then this
    target's four.
    """

    centre: Numbers
    slope: Numbers
    slack: Numbers

    @property
    def radius(self) -> Numbers:
        return abs(self.slope).sum(-1) + self.slack

    def at(self, *place) -> "AffineForm":
        """Some of the numbers; ``place`` counts from the first axis."""
        return AffineForm(self.centre[place], self.slope[place], self.slack[place])


def waypoint_inputs(
    lens: Lens, plots: Float[np.ndarray, "*b frames 6"], own: Float[np.ndarray, "*b 4"]
) -> AffineForm:
    """The waypoint encoder's inputs as forms [..., d] in own ship's errors, of radii ``own``."""
    target = np.zeros_like(own)
    jacobians = waypoint_jacobians(_shells(plots), _boxes(own, target))
    observation = _features(plots)[..., : jacobians.frames.low.shape[-2]]
    rounding = _ROUNDING * np.maximum(1.0, np.abs(observation))
    return _inputs(lens, jacobians, observation, rounding, own, target)


def target_inputs(
    lens: Lens,
    plots: Float[np.ndarray, "*b frames 6"],
    own: Float[np.ndarray, "*b 4"],
    target: Float[np.ndarray, "*b 4"],
) -> AffineForm:
    """The target encoder's inputs, as forms [..., d] in own ship's and the target's errors."""
    with np.errstate(all="ignore"):  # what is not a number could be any
        jacobians = target_jacobians(_shells(plots), _boxes(own, target))
    observation = _features(plots)
    rounding = _ROUNDING * np.maximum(1.0, np.abs(observation))
    rounding[..., _CPA_X:] += _lost_in_cpa(plots)
    return _inputs(lens, jacobians, observation, rounding, own, target)


def _lost_in_cpa(m: np.ndarray) -> np.ndarray:
    """What the four numbers of the CPA may lose more: a rounded relative velocity turns.

    By δ = δv/V, which moves the CPA by R·δ and, with the rounding of V, TCPA by 2R/V·δ.
    """
    range_m = np.hypot(m[..., 0], m[..., 1])
    speed = np.maximum(np.hypot(*_relative_velocity(m)), 1e-3)
    turned = _ROUNDING * (np.abs(m[..., 3]) + np.abs(m[..., 5])) / speed
    moved = range_m * turned
    columns = [moved / LENGTH_M, moved / LENGTH_M, moved / DISTANCE_M, 2 * moved / speed / TIME_S]
    return np.stack(columns, -1)


def _shells(plots: np.ndarray) -> np.ndarray:
    return np.broadcast_to(plots, (SHELLS, *plots.shape))


def _boxes(own: np.ndarray, target: np.ndarray) -> np.ndarray:
    """The largest error of each number of a plot, in growing shells [shell, ..., 6]."""
    box = np.concatenate([own[..., :2] + target[..., :2], own[..., 2:], target[..., 2:]], -1)
    share = np.arange(1, SHELLS + 1) / SHELLS
    return share.reshape(-1, *(1,) * box.ndim) * box * (1 + 1e-12)


def _relative_velocity(m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    h, own, course, speed = (m[..., i] for i in range(2, 6))
    return (
        speed * np.sin(course) - own * np.sin(h),
        speed * np.cos(course) - own * np.cos(h),
    )


def _features(m: np.ndarray) -> np.ndarray:
    """Eq. 11 in double precision; its first three columns are Eq. 10."""
    e, n, h = m[..., 0], m[..., 1], m[..., 2]
    sine, cosine = np.sin(h), np.cos(h)

    def body(east: np.ndarray, north: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return east * cosine - north * sine, east * sine + north * cosine

    east, north = _relative_velocity(m)
    square = east**2 + north**2
    moving = square > 1e-12
    tcpa = np.where(moving, -(e * east + n * north) / np.where(moving, square, 1.0), 0.0)
    tcpa = np.clip(tcpa, -CPA_HORIZON_S, CPA_HORIZON_S)
    nearest = e + tcpa * east, n + tcpa * north
    bearing = (np.arctan2(e, n) - h + np.pi) % (2 * np.pi) - np.pi
    columns = [
        *(x / LENGTH_M for x in body(e, n)),
        bearing / float(ANGLE_RAD),
        *(x / SPEED_M_S for x in body(east, north)),
        np.hypot(e, n) / DISTANCE_M,
        *(x / LENGTH_M for x in body(*nearest)),
        np.hypot(*nearest) / DISTANCE_M,
        tcpa / TIME_S,
    ]
    return np.stack(columns, -1)


def _inputs(
    lens: Lens,
    jacobians: FeatureJacobians,
    observation: np.ndarray,
    rounding: np.ndarray,
    own: np.ndarray,
    target: np.ndarray,
) -> AffineForm:
    """The inputs of a network (networks/input_features.py)."""
    widest = -1  # the shell that is the whole box
    frames = _form(observation, jacobians.frames, own, target, rounding)
    frames = _limited(frames, jacobians.values[widest], rounding, skip=_BEARING)
    frames = _round_the_compass(frames)
    if lens == "flat":
        lead = observation.ndim - 2
        return AffineForm(*(x.reshape(*x.shape[:lead], -1, *x.shape[lead + 2 :]) for x in frames))
    lead = (slice(None),) * (observation.ndim - 2)
    newer, older = frames.at(*lead, slice(None, -1)), frames.at(*lead, slice(1, None))
    difference = AffineForm(
        newer.centre - older.centre, newer.slope - older.slope, newer.slack + older.slack
    )
    change = np.diff(observation, axis=-2) * -1.0
    steps = _narrowest(_form(change, jacobians.steps, own, target, 0.0), difference)
    steps = _limited(steps, jacobians.change[widest], 0.0, skip=_BEARING)
    # Differences of bearings are taken the short way round.
    steps.centre[..., _BEARING] = (steps.centre[..., _BEARING] + 1.0) % 2.0 - 1.0
    steps = _round_the_compass(steps)
    lost = rounding[..., :-1, :] + rounding[..., 1:, :]
    flat = (*observation.shape[:-2], -1)
    now = frames.at(*lead, 0)
    slope, slack = _linear(jacobians.circle, own, target)
    angle = np.pi * observation[..., 0, _BEARING]
    sides = AffineForm(np.stack([np.sin(angle), np.cos(angle)], -1), slope, slack + 2 * _ROUNDING)
    parts = [
        now,
        AffineForm(
            (GAIN * steps.centre).reshape(flat),
            (GAIN * steps.slope).reshape(*flat, N_OWN_ERRORS + N_TARGET_ERRORS),
            (GAIN * (steps.slack + lost)).reshape(flat),
        ),
        _limited(sides, Interval(-np.ones(2), np.ones(2)), 0.0),
    ]
    if observation.shape[-1] > max(LENGTHS):
        lengths = np.array(LENGTHS)
        parts.append(_near(now.at(*lead, lengths)))
    axis = observation.ndim - 2
    return AffineForm(*(np.concatenate(x, axis) for x in zip(*parts, strict=True)))


def _form(
    centre: np.ndarray,
    j: Interval,
    own: np.ndarray,
    target: np.ndarray,
    rounding: np.ndarray | float,
) -> AffineForm:
    slope, slack = _linear(j, own, target)
    return AffineForm(centre, slope, slack + rounding)


def _linear(j: Interval, own: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slopes in the eight symbols and slack of J·θ, J [shell, ..., f, 6] averaged over shells."""
    j = Interval(j.low.mean(0), j.high.mean(0))
    missing = [(0, 0)] * (j.low.ndim - 1) + [(0, 6 - j.low.shape[-1])]
    with np.errstate(invalid="ignore"):
        midpoint, radius = j.midpoint, j.radius
    midpoint, radius = np.pad(midpoint, missing), np.pad(radius, missing)
    finite = np.isfinite(midpoint) & np.isfinite(radius)
    midpoint, radius = np.where(finite, midpoint, 0.0), np.where(finite, radius, np.inf)
    axes = tuple(range(own.ndim - 1, midpoint.ndim - 1))
    own, target = np.expand_dims(own, axes), np.expand_dims(target, axes)
    box = np.concatenate([own[..., :2] + target[..., :2], own[..., 2:], target[..., 2:]], -1)
    mine = np.concatenate([-midpoint[..., :2], midpoint[..., 2:4]], -1) * own
    theirs = np.concatenate([midpoint[..., :2], midpoint[..., 4:6]], -1) * target
    with np.errstate(invalid="ignore"):
        slack = np.where(box > 0, radius * box, 0.0).sum(-1) * (1 + 1e-6)
    return np.concatenate([mine, theirs], -1), slack


def _limited(
    form: AffineForm, reach: Interval, rounding: np.ndarray | float, skip: int | None = None
) -> AffineForm:
    """The form, or what the number can be at all where that says more.

    A form knows which error is to blame, so it is kept unless it is mostly slack.
    """
    with np.errstate(invalid="ignore"):
        midpoint, radius = reach.midpoint, reach.radius + rounding
    known = np.isfinite(midpoint) & np.isfinite(radius)
    narrow = (form.slack <= 0.5 * radius) | (form.radius <= radius) | ~known
    if skip is not None:
        narrow |= np.arange(narrow.shape[-1]) == skip
    return AffineForm(
        np.where(narrow, form.centre, midpoint),
        np.where(narrow[..., None], form.slope, 0.0),
        np.where(narrow, form.slack, radius),
    )


def _narrowest(a: AffineForm, b: AffineForm) -> AffineForm:
    narrow = a.radius <= b.radius
    return AffineForm(
        np.where(narrow, a.centre, b.centre),
        np.where(narrow[..., None], a.slope, b.slope),
        np.where(narrow, a.slack, b.slack),
    )


def _round_the_compass(form: AffineForm) -> AffineForm:
    """Bearings whose form crosses ±180° are unbounded."""
    whole = ~(np.abs(form.centre) + form.radius < 1.0)
    whole &= np.arange(form.centre.shape[-1]) == _BEARING
    return AffineForm(
        np.where(whole, 0.0, form.centre),
        np.where(whole[..., None], 0.0, form.slope),
        np.where(whole, 1.0 + 1e-5, form.slack),
    )


def _near(form: AffineForm) -> AffineForm:
    """softsign(10·x) of lengths: the mean value form with 10/(1 + 10·|x|)² over x's range."""
    x, radius = form.centre, form.radius
    nearest = np.maximum(np.abs(x) - radius, 0.0)
    steep, shallow = (NEAR / (1.0 + NEAR * y) ** 2 for y in (nearest, np.abs(x) + radius))
    midpoint, half = 0.5 * (steep + shallow), 0.5 * (steep - shallow) + 1e-6 * steep
    value = NEAR * x / (1.0 + NEAR * np.abs(x))
    return AffineForm(
        value,
        midpoint[..., None] * form.slope,
        midpoint * form.slack + half * radius + 2 * _ROUNDING,
    )
