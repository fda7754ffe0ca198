"""Linear bounds of a network's inputs in the errors of the sensors.

An input is a smooth function f of one plot m (Eq. 10-11), but for the clip of TCPA and
the absolute value in DCPA. With the error θ in a box, the mean value theorem gives
f(m + θ) ∈ f(m) + J·θ with J an interval that holds ∂f/∂m over the box. The magnified
differences of ``lens.fine`` need more: errors that both frames share all but cancel
in them. On the straight path from one plot to the next,
D(θ) − D(0) ∈ (∂²f/∂m² · Δm)·θ, with the second derivative over path and box.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from glasshelm.certify.intervals import Interval, around, exactly, extension, hull, multiply
from glasshelm.certify.scene import EACH, NUMBERS, OWN, Scene, observed
from glasshelm.geometry import CPA_HORIZON_S, wrap_angle
from glasshelm.networks.lens import GAIN, LENGTHS, NEAR, Lens, through
from glasshelm.world.observe import ANGLE_RAD, DISTANCE_M, LENGTH_M, SPEED_M_S, TIME_S

_BEARING, _CPA_X, _CPA_Y, _DCPA, _TCPA = 2, 6, 7, 8, 9
_SMOOTH = 10  # columns of Eq. 11; behind them sine and cosine of the bearing
_HORIZON = CPA_HORIZON_S / TIME_S
#: What evaluating a feature in float32 may lose, of its size or of 1.
_ROUNDING = 4e-7


class Form(eqx.Module):
    """Numbers known to lie within ``slack`` of centre + slope·φ for all symbols φ in [−1, 1].

    The symbols are own ship's four errors, then this target's four.
    """

    centre: Float[Array, "*b d"]
    slope: Float[Array, "*b d 8"]
    slack: Float[Array, "*b d"]

    @property
    def radius(self) -> Float[Array, "*b d"]:
        return jnp.abs(self.slope).sum(-1) + self.slack


def _target(e, n, h, own_speed, course, speed):
    """Eq. 11 without clip and with a sign on DCPA, then sine and cosine of the bearing."""
    sine, cosine = jnp.sin(h), jnp.cos(h)
    dx, dy = e * cosine - n * sine, e * sine + n * cosine
    vx, vy = speed * jnp.sin(course - h), speed * jnp.cos(course - h) - own_speed
    east = speed * jnp.sin(course) - own_speed * sine
    north = speed * jnp.cos(course) - own_speed * cosine
    square = east * east + north * north
    distance = jnp.sqrt(e * e + n * n)
    miss = (e * north - n * east) / jnp.sqrt(square)
    fast = jnp.sqrt(square)
    return (
        dx / LENGTH_M,
        dy / LENGTH_M,
        (jnp.arctan2(e, n) - h) / ANGLE_RAD,
        vx / SPEED_M_S,
        vy / SPEED_M_S,
        distance / DISTANCE_M,
        miss * (vy / fast) / LENGTH_M,
        -miss * (vx / fast) / LENGTH_M,
        miss / DISTANCE_M,
        -(e * east + n * north) / square / TIME_S,
        dx / distance,
        dy / distance,
    )


def _at_horizon(e, n, h, own_speed, course, speed, time):
    """The columns cpa_dx, cpa_dy, dcpa of Eq. 11 where TCPA is clipped to ``time``."""
    east = e + time * (speed * jnp.sin(course) - own_speed * jnp.sin(h))
    north = n + time * (speed * jnp.cos(course) - own_speed * jnp.cos(h))
    sine, cosine = jnp.sin(h), jnp.cos(h)
    return (
        (east * cosine - north * sine) / LENGTH_M,
        (east * sine + north * cosine) / LENGTH_M,
        jnp.sqrt(east * east + north * north) / DISTANCE_M,
    )


def _waypoint(e, n, h):
    """Eq. 10, then sine and cosine of the bearing."""
    sine, cosine = jnp.sin(h), jnp.cos(h)
    dx, dy = e * cosine - n * sine, e * sine + n * cosine
    distance = jnp.sqrt(e * e + n * n)
    return (
        dx / LENGTH_M,
        dy / LENGTH_M,
        (jnp.arctan2(e, n) - h) / ANGLE_RAD,
        dx / distance,
        dy / distance,
    )


def _jacobian(f, count):
    """∂f_j/∂m_i of the first ``count`` arguments, as a flat tuple, j slowest."""

    def derivative(*args):
        columns = []
        for i in range(count):
            unit = [np.float32(i == k) for k in range(len(args))]
            columns.append(jax.jvp(f, args, tuple(unit))[1])
        return tuple(column[j] for j in range(len(columns[0])) for column in columns)

    return derivative


def _along(f, count):
    """The Jacobian and its derivative along a direction, given behind the arguments."""

    def derivative(*args):
        first, second = jax.jvp(_jacobian(f, count), args[:count], args[count:])
        return (*first, *second)

    return derivative


_TARGET_JACOBIAN = extension(_jacobian(_target, 6), 6)
_TARGET_ALONG = extension(_along(_target, 6), 12)
_HORIZON_JACOBIAN = extension(_jacobian(_at_horizon, 6), 7)
_WAYPOINT_JACOBIAN = extension(_jacobian(_waypoint, 3), 3)
_WAYPOINT_ALONG = extension(_along(_waypoint, 3), 6)


def _matrix(flat: list[Interval], inputs: int) -> Interval:
    """Flat derivatives as [..., outputs, inputs]."""
    low, high = (jnp.stack(list(side), -1) for side in zip(*flat, strict=True))
    shape = (*low.shape[:-1], -1, inputs)
    return Interval(low.reshape(shape), high.reshape(shape))


def _part(x: Interval, *place) -> Interval:
    return Interval(x.low[place], x.high[place])


def _where(test: Array, a: Interval, b: Interval) -> Interval:
    return Interval(jnp.where(test, a.low, b.low), jnp.where(test, a.high, b.high))


def _times(j: Interval, box: Float[Array, "i"]) -> Float[Array, "..."]:
    """The largest |J·θ| for θ within ±box."""
    return jnp.where(box > 0, j.size * box, 0.0).sum(-1) * (1 + 1e-6)


def _along_path(j: Interval, step: Float[Array, "... i"]) -> Interval:
    """J·Δm."""
    found = multiply(j, exactly(step[..., None, :]))
    return around(found.middle.sum(-1), found.radius.sum(-1) * (1 + 1e-6))


def _boxed(plots: Float[Array, "*b m"], box: Float[Array, "m"]) -> list[Interval]:
    return [around(plots[..., i], box[i]) for i in range(plots.shape[-1])]


def _path(plots: Float[Array, "frames m"]) -> Float[Array, "steps m"]:
    """From each plot to the next newer one, angles the short way."""
    step = plots[:-1] - plots[1:]
    angles = np.array([name.endswith("_rad") for name in NUMBERS])[: plots.shape[-1]]
    return jnp.where(angles, wrap_angle(step), step)


def _boxed_path(plots, step, box) -> list[Interval]:
    """The box around the whole of each path that ends at a newer plot."""
    newer = plots[:-1]
    return [
        hull(around(newer[:, i], box[i]), around(newer[:, i] - step[:, i], box[i]))
        for i in range(plots.shape[-1])
    ]


def _linear(j: Interval, own: Array, each: Array) -> tuple[Array, Array]:
    """Slopes in the eight symbols and slack of J·θ; J [..., 6] or, of a waypoint, [..., 3]."""
    middle, radius = j.middle, j.radius
    missing = [(0, 0)] * (middle.ndim - 1) + [(0, 6 - middle.shape[-1])]
    middle, radius = jnp.pad(middle, missing), jnp.pad(radius, missing)
    finite = jnp.isfinite(middle) & jnp.isfinite(radius)
    middle = jnp.where(finite, middle, 0.0)
    mine = jnp.concatenate([-middle[..., :2], middle[..., 2:4]], -1) * own
    theirs = jnp.concatenate([middle[..., :2], middle[..., 4:6]], -1) * each
    box = _box(own, each)
    lost = jnp.where(finite, radius, jnp.inf) + 1e-6 * jnp.abs(middle)
    return jnp.concatenate([mine, theirs], -1), jnp.where(box > 0, lost * box, 0.0).sum(-1)


def _box(own: Array, each: Array) -> Float[Array, "6"]:
    """How far each number of a plot may be off."""
    return jnp.concatenate([own[:2] + each[:2], own[2:], each[2:]]) * (1 + 1e-6)


def _limited(form: Form, reach: Interval) -> Form:
    """The form, or the range that the feature cannot leave where the form is wider."""
    narrow = form.radius <= reach.radius
    return Form(
        jnp.where(narrow, form.centre, reach.middle),
        jnp.where(narrow[..., None], form.slope, 0.0),
        jnp.where(narrow, form.slack, reach.radius),
    )


def waypoint_inputs(lens: Lens, scene: Scene, own: Float[Array, "4"]) -> Form:
    """The waypoint encoder's inputs as forms [d] in own ship's errors, of radii ``own``."""
    nobody = jnp.zeros(EACH)
    box, m = _box(own, nobody)[:3], scene.waypoint[:, :3]
    jacobian = _matrix(_WAYPOINT_JACOBIAN(*_boxed(m, box)), 3)
    step = _path(m)
    flat = _WAYPOINT_ALONG(*_boxed_path(m, step, box), *map(exactly, step.T))
    along = _matrix(flat[len(flat) // 2 :], 3)
    seen = observed(scene).waypoint
    reach = _reach(jnp.hypot(m[:, 0], m[:, 1]), box)
    rounding = _ROUNDING * jnp.maximum(1.0, jnp.abs(seen))
    frames = _limited(
        _form(seen, _part(jacobian, slice(None), slice(3)), own, nobody, rounding),
        jax.tree.map(lambda x: x[:, :3], reach),
    )
    steps = _form(seen[:-1] - seen[1:], _part(along, slice(None), slice(3)), own, nobody)
    circle = _linear(_part(jacobian, 0, slice(3, 5)), own, nobody)
    return _seen_through(lens, frames, steps, circle, through(lens, seen), seen, rounding)


def target_inputs(
    lens: Lens, scene: Scene, own: Float[Array, "4"], each: Float[Array, "n 4"]
) -> Form:
    """The target encoder's inputs of every target, as forms [n, d] in own ship's and her errors."""
    seen = observed(scene).targets
    # Of a slot that nobody is in any ship will do: its bounds are not used.
    harmless = jnp.array([3000.0, 4000.0, 0.0, 5.0, 3.0, 5.0])
    plots = jnp.where(scene.present[:, None, None], scene.targets, harmless)
    return jax.vmap(lambda m, s, e: _one_target(lens, m, s, own, e))(plots, seen, each)


def _one_target(lens: Lens, m: Array, seen: Array, own: Array, each: Array) -> Form:
    box = _box(own, each)
    smooth = _matrix(_TARGET_JACOBIAN(*_boxed(m, box)), 6)
    jacobian, inside, sided = _with_kinks(m, box, smooth)
    reach = _reach(jnp.hypot(m[:, 0], m[:, 1]), box, targets=True)
    rounding = _ROUNDING * jnp.maximum(1.0, jnp.abs(seen))
    rounding = rounding.at[:, _CPA_X:].multiply(1.0 + 10.0 / _relative_speed(m)[:, None])
    frames = _limited(_form(seen, jacobian, own, each, rounding), reach)
    steps = _steps(m, box, seen, own, each, frames, inside, sided)
    circle = _linear(_part(smooth, 0, slice(_SMOOTH, None)), own, each)
    return _seen_through(lens, frames, steps, circle, through(lens, seen), seen, rounding)


def _form(
    centre: Array, j: Interval, own: Array, each: Array, rounding: Array | float = 0.0
) -> Form:
    slope, slack = _linear(j, own, each)
    return Form(centre, slope, slack + rounding)


def _relative_velocity(m: Array) -> tuple[Array, Array]:
    h, own, course, speed = (m[..., i] for i in range(2, 6))
    return (
        speed * jnp.sin(course) - own * jnp.sin(h),
        speed * jnp.cos(course) - own * jnp.cos(h),
    )


def _relative_speed(m: Array) -> Array:
    return jnp.maximum(jnp.hypot(*_relative_velocity(m)), 1e-3)


def _signed(m: Array) -> tuple[Array, Array]:
    """TCPA before the clip and DCPA with its sign, both normalised."""
    east, north = _relative_velocity(m)
    speed = _relative_speed(m)
    tcpa = -(m[..., 0] * east + m[..., 1] * north) / speed**2 / TIME_S
    return tcpa, (m[..., 0] * north - m[..., 1] * east) / speed / DISTANCE_M


def _with_kinks(
    m: Array, box: Array, smooth: Interval
) -> tuple[Interval, Bool[Array, " f"], Bool[Array, " f"]]:
    """∂f/∂m [frames, 10, 6] with clip and absolute value; where neither bends f over the box."""
    tcpa, miss = _signed(m)
    late = _times(_part(smooth, slice(None), _TCPA), box)
    aside = _times(_part(smooth, slice(None), _DCPA), box)
    inside = jnp.abs(tcpa) + late < _HORIZON - 1e-3
    beyond = (jnp.abs(tcpa) - late > _HORIZON + 1e-3) & jnp.isfinite(late)
    either = late - jnp.abs(tcpa) >= _HORIZON - 1e-3  # both ends of the horizon
    sided = jnp.abs(miss) > aside + 1e-6
    of_miss = _part(smooth, slice(None), _DCPA)
    sign = jnp.sign(miss)[:, None]
    one_side = _where(sign > 0, of_miss, Interval(-of_miss.high, -of_miss.low))
    both_sides = Interval(-of_miss.size, of_miss.size)
    dcpa = _where(sided[:, None], one_side, both_sides)
    free = [
        _part(smooth, slice(None), _CPA_X),
        _part(smooth, slice(None), _CPA_Y),
        dcpa,
        _part(smooth, slice(None), _TCPA),
    ]
    time = jnp.where(tcpa < 0, -CPA_HORIZON_S, CPA_HORIZON_S)
    clipped = _matrix(_HORIZON_JACOBIAN(*_boxed(m, box), exactly(time)), 6)
    held = [_part(clipped, slice(None), i) for i in range(3)]
    held.append(exactly(jnp.zeros_like(held[0].low)))
    bent = []
    for a, b in zip(free, held, strict=True):
        one = _where(inside[:, None], a, _where(beyond[:, None], b, hull(a, b)))
        unknown = Interval(jnp.full_like(one.low, -jnp.inf), jnp.full_like(one.low, jnp.inf))
        bent.append(_where(either[:, None], unknown, one))
    first = _part(smooth, slice(None), slice(_CPA_X))
    low = jnp.concatenate([first.low, jnp.stack([b.low for b in bent], 1)], 1)
    high = jnp.concatenate([first.high, jnp.stack([b.high for b in bent], 1)], 1)
    return Interval(low, high), inside, sided


def _reach(range_m: Array, box: Array, targets: bool = False) -> Interval:
    """What the features of a plot at this range can be at all [frames, features]."""
    most = range_m + jnp.hypot(box[0], box[1]) + 1.0
    least = jnp.maximum(range_m - jnp.hypot(box[0], box[1]) - 1.0, 0.0)
    length, one = most / LENGTH_M, jnp.ones_like(most)
    sides = [(-length, length), (-length, length), (-one, one)]
    if targets:
        speed, distance = 1e3 * one, most / DISTANCE_M
        sides += [
            (-speed, speed), (-speed, speed), (least / DISTANCE_M, distance),
            (-length, length), (-length, length), (0.0 * one, distance),
            (-_HORIZON * one, _HORIZON * one),
        ]  # fmt: skip
    low, high = (jnp.stack(side, -1) for side in zip(*sides, strict=True))
    return Interval(low, high)


def _difference(frames: Form) -> Form:
    """Newer minus older frame, term by term."""
    return Form(
        frames.centre[:-1] - frames.centre[1:],
        frames.slope[:-1] - frames.slope[1:],
        frames.slack[:-1] + frames.slack[1:],
    )


def _steps(m, box, seen, own, each, frames, inside, sided) -> Form:
    """The differences of frames as forms: the narrowest of three enclosures of each."""
    path = _path(m)
    flat = _TARGET_ALONG(*_boxed_path(m, path, box), *map(exactly, path.T))
    half = len(flat) // 2
    first, second = _matrix(flat[:half], 6), _matrix(flat[half:], 6)
    moved = _along_path(first, path)
    change = seen[:-1] - seen[1:]
    # Where the whole path is free of kinks, by the second derivative.
    tcpa, miss = _signed(m)
    late, aside = (
        _times(_part(first, slice(None), j), box) + _part(moved, slice(None), j).size
        for j in (_TCPA, _DCPA)
    )
    unclipped = inside[:-1] & (jnp.abs(tcpa[:-1]) + late < _HORIZON - 1e-3)
    one_side = sided[:-1] & (jnp.abs(miss[:-1]) > aside + 1e-6)
    curved = _part(second, slice(None), slice(_SMOOTH))
    mirrored = Interval(-curved.high, -curved.low)
    flip = (jnp.arange(_SMOOTH) == _DCPA) & (miss[:-1, None] < 0)
    curved = _where(flip[..., None], mirrored, curved)
    column = jnp.arange(_SMOOTH)
    valid = (column < _CPA_X) | unclipped[:, None]
    valid &= (column != _DCPA) | one_side[:, None]
    smooth = _form(change, curved, own, each)
    smooth = eqx.tree_at(lambda f: f.slack, smooth, jnp.where(valid, smooth.slack, jnp.inf))
    # By the first derivative along the path, which a clip or a change of sign only shortens.
    most = _part(moved, slice(None), slice(_SMOOTH)).size
    known = (column == _TCPA) | ((column == _DCPA) & unclipped[:, None])
    short = Form(
        jnp.zeros_like(change), jnp.zeros_like(smooth.slope), jnp.where(known, most, jnp.inf)
    )
    return _narrowest(smooth, _narrowest(_difference(frames), short))


def _narrowest(a: Form, b: Form) -> Form:
    narrow = a.radius <= b.radius
    return Form(
        jnp.where(narrow, a.centre, b.centre),
        jnp.where(narrow[..., None], a.slope, b.slope),
        jnp.where(narrow, a.slack, b.slack),
    )


def _seen_through(
    lens: Lens,
    frames: Form,
    steps: Form,
    circle: tuple[Array, Array],
    inputs: Array,
    seen: Array,
    rounding: Array,
) -> Form:
    """The inputs of a network through its lens (networks/lens.py) from forms of the frames."""
    frames = _round_the_compass(frames)
    if lens == "flat":
        return jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), frames)
    turned = _narrowest(steps, _difference(frames))
    # Differences of bearings are taken the short way round.
    short = jnp.mod(turned.centre[:, _BEARING] + 1.0, 2.0) - 1.0
    turned = eqx.tree_at(lambda f: f.centre, turned, turned.centre.at[:, _BEARING].set(short))
    turned = _round_the_compass(turned)
    lost = rounding[:-1] + rounding[1:]
    parts = [
        jax.tree.map(lambda x: x[0], frames),
        Form(
            (GAIN * turned.centre).reshape(-1),
            (GAIN * turned.slope).reshape(-1, OWN + EACH),
            (GAIN * (turned.slack + lost)).reshape(-1),
        ),
    ]
    angles = parts[1].centre.shape[0] + seen.shape[-1]
    slope, slack = circle
    sides = Form(inputs[angles : angles + 2], slope, slack + 2 * _ROUNDING)
    one = jnp.ones(2)
    parts.append(_limited(sides, Interval(-one, one)))
    if inputs.shape[-1] > angles + 2:
        parts.append(_near(jax.tree.map(lambda x: x[0, jnp.array(LENGTHS)], frames)))
    return jax.tree.map(lambda *x: jnp.concatenate(x), *parts)


def _round_the_compass(form: Form) -> Form:
    """Bearings whose form crosses ±180° can be any."""
    whole = jnp.abs(form.centre) + form.radius >= 1.0
    whole &= jnp.arange(form.centre.shape[-1]) == _BEARING
    return Form(
        jnp.where(whole, 0.0, form.centre),
        jnp.where(whole[..., None], 0.0, form.slope),
        jnp.where(whole, 1.0 + 1e-5, form.slack),
    )


def _near(form: Form) -> Form:
    """softsign(10·x) of lengths: the mean value form with 10/(1 + 10·|x|)² over x's range."""
    x, radius = form.centre, form.radius
    nearest = jnp.maximum(jnp.abs(x) - radius, 0.0)
    steep, shallow = (NEAR / (1.0 + NEAR * y) ** 2 for y in (nearest, jnp.abs(x) + radius))
    middle, half = 0.5 * (steep + shallow), 0.5 * (steep - shallow) + 1e-6 * steep
    value = NEAR * x / (1.0 + NEAR * jnp.abs(x))
    return Form(
        value,
        middle[:, None] * form.slope,
        middle * form.slack + half * radius + 2 * _ROUNDING,
    )
