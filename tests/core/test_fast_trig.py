"""The polynomials are as good as float32, and their derivatives are exact."""

import jax
import jax.numpy as jnp
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from glasshelm.core.fast_trig import arctan2, sincos

ANGLES = jnp.linspace(-40.0, 40.0, 400_001)


def test_sine_and_cosine_are_those_of_numpy():
    sine, cosine = sincos(ANGLES)
    exact = np.asarray(ANGLES, np.float64)
    np.testing.assert_allclose(sine, np.sin(exact), atol=2e-7)
    np.testing.assert_allclose(cosine, np.cos(exact), atol=2e-7)


def test_direction_is_that_of_numpy_in_all_quadrants():
    x, y = jax.random.normal(jax.random.key(0), (2, 200_000)) * jnp.array([[1e3], [1.0]])
    exact = np.arctan2(np.asarray(y, np.float64), np.asarray(x, np.float64))
    np.testing.assert_allclose(arctan2(y, x), exact, atol=4e-7)


def test_direction_on_the_axes():
    y, x = jnp.array([0.0, 1.0, 0.0, -1.0, 0.0]), jnp.array([1.0, 0.0, -1.0, 0.0, 0.0])
    expected = [0.0, np.pi / 2, np.pi, -np.pi / 2, 0.0]
    np.testing.assert_allclose(arctan2(y, x), expected, atol=1e-6)


@given(st.floats(-30.0, 30.0))
def test_derivatives_of_sine_and_cosine(angle):
    d_sine, d_cosine = jax.jacfwd(sincos)(jnp.float32(angle))
    np.testing.assert_allclose(d_sine, np.cos(angle), atol=2e-6)
    np.testing.assert_allclose(d_cosine, -np.sin(angle), atol=2e-6)


def test_derivative_of_the_direction_and_none_at_the_origin():
    gradient = jax.grad(arctan2, argnums=(0, 1))
    np.testing.assert_allclose(
        gradient(jnp.float32(3.0), jnp.float32(4.0)), (4 / 25, -3 / 25), rtol=1e-6
    )
    np.testing.assert_allclose(gradient(jnp.zeros(()), jnp.zeros(())), (0.0, 0.0))
