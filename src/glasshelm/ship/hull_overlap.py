"""Whether two hulls touch: convex outlines and the axes that separate them.

A hull is a rectangle whose foremost part narrows to the bow, as figures draw
it. Two convex shapes are apart if and only if some edge of one of them has the
other wholly on its outer side (the separating axis theorem).
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.core.geometry import Vector, to_world

#: From the middle, the bow begins to narrow at this share of half the length.
SHOULDER = 0.55

Size = float | Float[Array, ""]


def hull(length_m: Size, beam_m: Size) -> Vector:
    """Corners (starboard, ahead) [m] of a ship seen from above, clockwise from the port quarter."""
    half, bow = 0.5 * jnp.asarray(beam_m), 0.5 * jnp.asarray(length_m)
    return Vector(
        jnp.stack([-half, -half, jnp.zeros_like(half), half, half]),
        jnp.stack([-bow, SHOULDER * bow, bow, SHOULDER * bow, -bow]),
    )


def hull_gap_m(
    own: Vector, own_heading_rad: Size, other: Vector, offset: Vector, other_heading_rad: Size
) -> Float[Array, ""]:
    """The widest gap [m] between two hulls along any of their edges' normals.

    Negative: they overlap, by so much along the shallowest normal. Positive:
    they are apart, by at least so much. ``offset`` is the other ship's middle
    from own ship's (east, north).
    """
    a = to_world(own, jnp.asarray(own_heading_rad))
    b = to_world(other, jnp.asarray(other_heading_rad))
    b = Vector(b.x + offset.x, b.y + offset.y)
    gaps = []
    for one, two in ((a, b), (b, a)):
        # Clockwise corners: the outer normal of an edge points to its left.
        edge = Vector(jnp.roll(one.x, -1) - one.x, jnp.roll(one.y, -1) - one.y)
        length = jnp.sqrt(edge.x**2 + edge.y**2)
        out = Vector(-edge.y / length, edge.x / length)
        face = out.x * one.x + out.y * one.y
        reach = (out.x[:, None] * two.x + out.y[:, None] * two.y).min(-1)
        gaps.append((reach - face).max())
    return jnp.maximum(*gaps)
