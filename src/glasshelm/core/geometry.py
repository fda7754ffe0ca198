"""Plane geometry of moving points: angles, frames, closest point of approach.

Angles are radians clockwise from north. A *body* frame has its origin at own
ship, x to starboard and y ahead. Nothing here knows what a ship is; every
function broadcasts over leading axes.
"""

from typing import Any, NamedTuple, Protocol, runtime_checkable

import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.core.fast_trig import arctan2, sincos

#: CPA is sought within one hour before or after now. Two ships on nearly the
#: same course and speed have no meaningful CPA; the horizon keeps it finite.
CPA_HORIZON_S = 3600.0

_TINY = 1e-12


class Vector(NamedTuple):
    """A plane vector: (east, north) in the world, (starboard, ahead) in a body frame."""

    x: Float[Array, "..."]
    y: Float[Array, "..."]


@runtime_checkable
class Located(Protocol):
    """Anything with a place in the plane."""

    @property
    def east_m(self) -> Any: ...

    @property
    def north_m(self) -> Any: ...


class Cpa(NamedTuple):
    """Closest point of approach of two points that keep course and speed.

    ``position`` is where the other point is then, relative to own ship [m];
    ``dcpa_m`` its distance; ``tcpa_s`` the time from now, negative if past.
    """

    position: Vector
    dcpa_m: Float[Array, "..."]
    tcpa_s: Float[Array, "..."]


def wrap_angle(angle_rad: Float[Array, "..."]) -> Float[Array, "..."]:
    """The same direction in [−π, π)."""
    return angle_rad - 2 * jnp.pi * jnp.floor(angle_rad / (2 * jnp.pi) + 0.5)


def offset(start: Located, end: Located | Vector) -> Vector:
    """The way (east, north) [m] from one place to another."""
    east, north = end if isinstance(end, Vector) else (end.east_m, end.north_m)
    return Vector(east - start.east_m, north - start.north_m)


def norm(v: Vector) -> Float[Array, "..."]:
    """Length of a vector, with a finite gradient (0) at the zero vector."""
    square = v.x**2 + v.y**2
    return jnp.where(square > _TINY, jnp.sqrt(jnp.maximum(square, _TINY)), 0.0)


def direction(v: Vector) -> Float[Array, "..."]:
    """Direction of a vector, clockwise from its y axis, in [−π, π]; 0 for the zero vector."""
    zero = (v.x == 0) & (v.y == 0)
    return arctan2(jnp.where(zero, 0.0, v.x), jnp.where(zero, 1.0, v.y))


def velocity(course_rad: Float[Array, "..."], speed: float | Float[Array, "..."]) -> Vector:
    """Velocity over ground (east, north) of a course and a speed (Eq. 7)."""
    sine, cosine = sincos(course_rad)
    return Vector(speed * sine, speed * cosine)


def to_body(v: Vector, heading_rad: Float[Array, "..."]) -> Vector:
    """An (east, north) vector as (starboard, ahead) of a ship with that heading."""
    s, c = sincos(heading_rad)
    return Vector(v.x * c - v.y * s, v.x * s + v.y * c)


def to_world(v: Vector, heading_rad: Float[Array, "..."]) -> Vector:
    """A (starboard, ahead) vector as (east, north): the inverse of :func:`to_body`."""
    return to_body(v, -heading_rad)


def closest_approach(position: Vector, velocity: Vector, horizon_s: float = CPA_HORIZON_S) -> Cpa:
    """CPA of a point at a relative position moving with a constant relative velocity.

    TCPA = −p·v / |v|², limited to ±``horizon_s``; the CPA position and DCPA are
    those at that time. At zero relative speed TCPA is 0 and DCPA the distance
    now. Any frame will do, as long as both vectors are in the same one.
    """
    dot = position.x * velocity.x + position.y * velocity.y
    square = velocity.x**2 + velocity.y**2
    moving = square > 1e-8  # slower than 0.1 mm/s is standing still
    tcpa = jnp.where(moving, -dot / jnp.where(moving, square, 1.0), 0.0)
    tcpa = jnp.clip(tcpa, -horizon_s, horizon_s)
    at_cpa = Vector(position.x + tcpa * velocity.x, position.y + tcpa * velocity.y)
    return Cpa(at_cpa, norm(at_cpa), tcpa)
