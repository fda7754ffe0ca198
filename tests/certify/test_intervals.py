"""The interval extension holds the function, and its derivatives, at every point of the box."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.certify.intervals import Interval, extension


def _product(x, y):
    return (x * y, x / (2.0 + y * y))


def _waves(x, y):
    return (jnp.sin(3.0 * x) * jnp.cos(y), jnp.sqrt(x * x + y * y + 1.0))


def _slope(x, y):
    return jax.jvp(lambda a: jnp.arctan2(a, 2.0 + y * y), (x,), (jnp.float32(1),))[1]


@pytest.mark.parametrize("f", [_product, _waves, lambda x, y: (_slope(x, y),)])
def test_extension_holds_every_value(f):
    drawn = np.random.default_rng(1)
    low = drawn.normal(size=(2, 200)).astype(np.float32) * 2
    high = low + drawn.exponential(size=(2, 200)).astype(np.float32)
    found = extension(f, 2)(
        *[Interval(*x) for x in zip(jnp.asarray(low), jnp.asarray(high), strict=True)]
    )
    for _ in range(50):
        at = low + drawn.uniform(size=(2, 200)).astype(np.float32) * (high - low)
        for box, value in zip(found, jax.vmap(f)(*jnp.asarray(at)), strict=True):
            room = 1e-5 * (1 + np.abs(value))
            assert np.all(box.low <= value + room)
            assert np.all(box.high >= value - room)


def test_dividing_by_what_may_be_zero_gives_anything():
    box = Interval(jnp.asarray(-1.0), jnp.asarray(1.0))
    (found,) = extension(lambda x: (1.0 / x,), 1)(box)
    assert float(found.low) == -np.inf
    assert float(found.high) == np.inf
