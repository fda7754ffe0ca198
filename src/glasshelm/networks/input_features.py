"""How five frames become the input vector of a network.

``flat`` is the paper's: the frames side by side. ``fine`` shows the same frames
through a fixed change of variables, so that small things are not small
numbers: the current frame, the frame-to-frame differences magnified (a large
ship's rate of turn is 0.0005 in the units of Eq. 11), the lengths of the
current frame also on a scale of 2 km, and directions as sine and cosine.

:func:`encode_courses` is for critics of manoeuvres, whose courses are off the bearing of the
waypoint: the newest frame in the frame of that bearing, and how each ship would be passed on
each of a fan of courses.
"""

from typing import Literal

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from glasshelm.core.geometry import Vector, direction, norm, to_body, velocity, wrap_angle
from glasshelm.env.observe import (
    FRAMES,
    LENGTH_M,
    SPEED_M_S,
    TARGET_FEATURES,
    WAYPOINT_FEATURES,
    Observation,
    waypoint_bearing_rad,
)
from glasshelm.env.step import EnvSettings
from glasshelm.networks.mlp import softsign
from glasshelm.ship.domain import danger_unclipped
from glasshelm.ship.nomoto import ShipParams

Lens = Literal["flat", "fine"]

GAIN = 20.0  # magnification of differences
NEAR = 10.0  # lengths /20 km become lengths /2 km
_BEARING = 2  # column of the bearing, in both kinds of row
LENGTHS = tuple(
    i for i, name in enumerate(TARGET_FEATURES) if name in
    ("dx", "dy", "distance", "cpa_dx", "cpa_dy", "dcpa")
)  # fmt: skip


def encode(lens: Lens, frames: Float[Array, "*b frames f"]) -> Float[Array, "*b inputs"]:
    """The input vector of a waypoint (f = 3) or target (f = 10) history, newest frame first."""
    if lens == "flat":
        return _flat(frames)
    now = frames[..., 0, :]
    steps = frames[..., :-1, :] - frames[..., 1:, :]
    turn = steps[..., _BEARING]
    steps = steps.at[..., _BEARING].set(jnp.mod(turn + 1.0, 2.0) - 1.0)
    angle = jnp.pi * now[..., _BEARING : _BEARING + 1]
    parts = [
        now,
        GAIN * _flat(steps),
        jnp.sin(angle),
        jnp.cos(angle),
    ]
    if now.shape[-1] == len(TARGET_FEATURES):
        parts.append(softsign(NEAR * now[..., LENGTHS]))
    return jnp.concatenate(parts, axis=-1)


def _flat(frames: Float[Array, "*b frames f"]) -> Float[Array, "*b inputs"]:
    """The last two axes as one; the size is given, not left open, as there may be no ships."""
    return frames.reshape(*frames.shape[:-2], frames.shape[-2] * frames.shape[-1])


def input_size(lens: Lens, row: Literal["waypoint", "target"]) -> int:
    """Length of :func:`encode`'s vector."""
    features = len(WAYPOINT_FEATURES if row == "waypoint" else TARGET_FEATURES)
    extra = 0 if lens == "flat" else 2 + (len(LENGTHS) if row == "target" else 0)
    return FRAMES * features + extra


#: The fan of courses off the waypoint's bearing on which ships are passed in thought [rad].
_SIDE = (10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 75.0, 90.0, 110.0)
FAN_RAD = np.radians([*(-a for a in reversed(_SIDE)), 0.0, *_SIDE])
#: Passing is sought so far ahead [s].
_AHEAD_S = 2400.0
#: Length of :func:`encode_courses`' vector.
COURSE_INPUTS = 15 + 24 + 5 * (len(FAN_RAD) + 1)


def encode_courses(observation: Observation, ship: ShipParams) -> Float[Array, "*b n inputs"]:
    """The input vector of every ship with own ship and its way, turned into the waypoint's bearing.

    y is towards the waypoint, x to starboard of it. Lengths are shown at several scales.

    Args:
        observation: Eq. 10-12.
        ship: Own ship; of it speed and length are used.
    """
    bearings = waypoint_bearing_rad(observation.waypoint)
    bearing = bearings[..., :1]
    own = _own_columns(bearings, observation.waypoint[..., 0, :2] * LENGTH_M)
    now, oldest = observation.targets[..., 0, :], observation.targets[..., -1, :]

    def turned(columns: Float[Array, "*b n f"], first: int, scale: float) -> Vector:
        pair = Vector(columns[..., first] * scale, columns[..., first + 1] * scale)
        return to_body(pair, bearing)

    place, relative = turned(now, 0, LENGTH_M), turned(now, 3, SPEED_M_S)
    mine = velocity(-bearing, ship.speed_m_s)
    way = Vector(relative.x + mine.x, relative.y + mine.y)
    before = turned(oldest, 3, SPEED_M_S)
    columns = [
        *_target_columns(place, way, Vector(relative.x - before.x, relative.y - before.y)),
        *_passing_columns(place, way, bearing, ship),
    ]
    columns = jnp.stack(jnp.broadcast_arrays(*columns), axis=-1)
    own = jnp.broadcast_to(own[..., None, :], (*columns.shape[:-1], own.shape[-1]))
    return jnp.concatenate([own, columns], axis=-1)


def _own_columns(
    bearings: Float[Array, "*b frames"], waypoint_m: Float[Array, "*b 2"]
) -> Float[Array, "*b 15"]:
    """Own heading off the bearing, its rate of turn, and how far the waypoint is."""
    b = bearings[..., 0]
    step_s = EnvSettings().step_s
    rate = wrap_angle(bearings[..., 0] - bearings[..., 1]) / step_s
    mean = wrap_angle(bearings[..., 0] - bearings[..., -1]) / (step_s * (FRAMES - 1))
    far = norm(Vector(waypoint_m[..., 0], waypoint_m[..., 1]))
    rates = [jnp.tanh(gain * r) for r in (rate, mean) for gain in (60.0, 400.0)]
    angles = [jnp.sin(b), jnp.cos(b), b / jnp.pi, jnp.tanh(3.0 * b), jnp.tanh(12.0 * b)]
    near = [jnp.exp(-far / scale) for scale in (1e3, 2e3, 4e3, 8e3, 16e3)]
    return jnp.stack([*angles, *rates, *near, far / LENGTH_M], axis=-1)


def _target_columns(place: Vector, way: Vector, change: Vector) -> list[Float[Array, "*b n"]]:
    """A ship's place, velocity and change of velocity (of the newest frame against the oldest)."""
    far, speed = norm(place), norm(way)
    seen, course = direction(place), direction(way)
    aspect = seen - course
    return [
        *(x / LENGTH_M for x in place),
        *(softsign(x / scale) for x in place for scale in (800.0, 3000.0)),
        far / LENGTH_M,
        *(jnp.exp(-far / scale) for scale in (1e3, 3e3, 8e3)),
        *(f(x) for x in (seen, course, aspect) for f in (jnp.sin, jnp.cos)),
        *(x / 5.0 for x in way),
        speed / 5.0,
        jnp.log(0.2 + speed / 5.0),
        *(jnp.tanh(x) for x in change),
        *(jnp.tanh(5.0 * x) for x in change),
    ]


def _passing_columns(
    place: Vector, way: Vector, bearing: Float[Array, "*b 1"], ship: ShipParams
) -> list[Float[Array, "*b n"]]:
    """Where a ship would be at the CPA, when, and how deep in own ship's domain.

    On each course of the fan, and with own ship's present heading.
    """
    columns = []
    for course in (*FAN_RAD, -bearing):
        mine = velocity(jnp.asarray(course), ship.speed_m_s)
        x, y = way.x - mine.x, way.y - mine.y
        time = -(place.x * x + place.y * y) / jnp.maximum(x * x + y * y, 0.01)
        time = jnp.clip(time, 0.0, _AHEAD_S)
        body = to_body(Vector(place.x + x * time, place.y + y * time), jnp.asarray(course))
        columns += [softsign(body.x / 1000.0), softsign(body.y / 1000.0), time / 1000.0]
        columns += [jnp.exp(-time / 300.0), softsign(danger_unclipped(body, ship.loa_m))]
    return columns
