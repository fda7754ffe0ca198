"""How five frames become the input vector of a network.

``flat`` is the paper's: the frames side by side. ``fine`` shows the same frames
through a fixed change of variables, so that small things are not small
numbers: the current frame, the frame-to-frame differences magnified (a large
ship's rate of turn is 0.0005 in the units of Eq. 11), the lengths of the
current frame also on a scale of 2 km, and directions as sine and cosine.
"""

from typing import Literal

import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.env.observe import FRAMES, TARGET_FEATURES, WAYPOINT_FEATURES
from glasshelm.networks.mlp import softsign

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
