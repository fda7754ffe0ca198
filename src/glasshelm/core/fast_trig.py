"""Sine, cosine and direction as polynomials: a CPU computes them in vectors.

XLA's own on a CPU are scalar calls (arctan2 50 ns, sine 12 ns, the float modulo
7 ns an element on the machine of docs/results/speed.md; these about 1 ns), and a
world is mostly angles. Least-squares fits at Chebyshev nodes, their error
below a float32's own; derivatives are the exact ones, not the polynomials'.
"""

import functools
import math

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

# π in two parts: k·PI_HIGH is exact for small whole k, so that little is lost in x − k·π.
_PI_HIGH = 3.140625
_PI_LOW = math.pi - _PI_HIGH

_SINE = (1.0, -0.1666666662, 0.008333330977, -1.984086155e-4, 2.752528709e-6, -2.388949783e-8)
_COSINE = (
    1.0, -0.5, 0.04166666647, -0.001388888418, 2.480104033e-5, -2.752468497e-7, 1.990770211e-9,
)  # fmt: skip
_ARCTANGENT = (
    0.9999999842, -0.3333306678, 0.1999248358, -0.1420257051, 0.106367541, -0.07495445443,
    0.04258760747, -0.0160050305, 0.002834064299,
)  # fmt: skip


def _polynomial(x: Float[Array, "..."], coefficients: tuple[float, ...]) -> Float[Array, "..."]:
    """c_0 + c_1·x + c_2·x² + … by Horner's rule."""
    return functools.reduce(
        lambda sum_, c: sum_ * x + c, coefficients[-2::-1], jnp.full_like(x, coefficients[-1])
    )


@jax.custom_jvp
def sincos(
    angle_rad: Float[Array, "..."],
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """Sine and cosine of an angle [rad]."""
    x = jnp.asarray(angle_rad)
    half_turns = jnp.floor(x * (1.0 / math.pi) + 0.5)
    rest = (x - half_turns * _PI_HIGH) - half_turns * _PI_LOW  # in [−π/2, π/2]
    sign = 1.0 - 2.0 * (half_turns - 2.0 * jnp.floor(0.5 * half_turns))
    square = rest * rest
    return sign * rest * _polynomial(square, _SINE), sign * _polynomial(square, _COSINE)


@sincos.defjvp
def _(primals, tangents):
    (angle,), (d_angle,) = primals, tangents
    sine, cosine = sincos(angle)
    return (sine, cosine), (cosine * d_angle, -sine * d_angle)


@jax.custom_jvp
def arctan2(y: Float[Array, "..."], x: Float[Array, "..."]) -> Float[Array, "..."]:
    """The angle in [−π, π] whose sine and cosine are as y to x; 0 for (0, 0)."""
    wide, high = jnp.abs(x), jnp.abs(y)
    long = jnp.maximum(wide, high)
    slope = jnp.minimum(wide, high) / jnp.where(long > 0, long, 1.0)
    angle = slope * _polynomial(slope * slope, _ARCTANGENT)
    angle = jnp.where(high > wide, 0.5 * math.pi - angle, angle)
    angle = jnp.where(x < 0, math.pi - angle, angle)
    return jnp.where(y < 0, -angle, angle)


@arctan2.defjvp
def _(primals, tangents):
    (y, x), (d_y, d_x) = primals, tangents
    square = x * x + y * y
    slope = (x * d_y - y * d_x) / jnp.where(square > 0, square, 1.0)
    return arctan2(y, x), slope
