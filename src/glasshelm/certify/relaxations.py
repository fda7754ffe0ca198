"""Straight lines below and above an activation over an interval."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.networks.mlp import LEAK, softsign


class LinearRelaxation(eqx.Module):
    """low_slope·x + low_shift ≤ f(x) ≤ high_slope·x + high_shift for l ≤ x ≤ u."""

    low_slope: Float[Array, "*b"]
    low_shift: Float[Array, "*b"]
    high_slope: Float[Array, "*b"]
    high_shift: Float[Array, "*b"]


def relax_leaky_relu(low: Float[Array, "*b"], high: Float[Array, "*b"]) -> LinearRelaxation:
    """Leaky ReLU: the chord above, below the arm that leaves the smaller area (Zhang et al. 2018).

    It is convex, so the chord is above it and both of its arms are below.
    """
    wide = (low < 0) & (high > 0)
    span = jnp.where(wide, high - low, 1.0)
    chord = (high - LEAK * low) / span
    arm = jnp.where(low >= 0, 1.0, LEAK)
    slope = jnp.where(wide, chord, arm)
    shift = jnp.where(wide, (LEAK - chord) * low, 0.0)
    below = jnp.where(wide, jnp.where(high > -low, 1.0, LEAK), arm)
    return LinearRelaxation(below, jnp.zeros_like(low), slope, shift)


def relax_softsign(low: Float[Array, "*b"], high: Float[Array, "*b"]) -> LinearRelaxation:
    """x/(1 + |x|): chords and tangents; the function is odd, convex below 0, concave above."""
    slope, shift = _above(low, high)
    mirrored, offset = _above(-high, -low)
    return LinearRelaxation(mirrored, -offset, slope, shift)


def _above(low: Float[Array, "*b"], high: Float[Array, "*b"]) -> tuple[Array, Array]:
    """Slope and shift of a line above softsign.

    The tangent that passes through the lower end (−q, s(−q)) touches at
    t = q/(1 + √(2 + 2q)); any tangent further right lies above the function too.
    If there is no room for one the chord does.
    """
    q = jnp.maximum(-low, 0.0)
    first = q / (1.0 + jnp.sqrt(2.0 + 2.0 * q))
    tangent = high > first
    touch = jnp.maximum(first, 0.5 * (low + high))
    touch = jnp.where(tangent, jnp.maximum(touch, 0.0), 0.0)
    at_tangent = 1.0 / (1.0 + touch) ** 2
    span = high - low
    steepest = 1.0 / (1.0 + jnp.minimum(jnp.abs(low), jnp.abs(high))) ** 2
    chord = jnp.where(
        span > 1e-6, (softsign(high) - softsign(low)) / jnp.maximum(span, 1e-6), steepest
    )
    slope = jnp.where(tangent, at_tangent, chord)
    shift = jnp.where(
        tangent,
        softsign(touch) - at_tangent * touch,
        jnp.maximum(softsign(low) - chord * low, softsign(high) - chord * high),
    )
    return slope, shift + 4e-7  # what float32 may have lost
