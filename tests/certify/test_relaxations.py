"""LinearRelaxation lie below and above their activations, everywhere in the interval."""

import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.certify.relaxations import relax_leaky_relu, relax_softsign
from glasshelm.networks.mlp import leaky_relu, softsign


@pytest.mark.parametrize(
    ("lines", "activation"), [(relax_leaky_relu, leaky_relu), (relax_softsign, softsign)]
)
def test_lines_hold_the_activation(lines, activation):
    drawn = np.random.default_rng(0)
    width = 10.0 ** drawn.uniform(-4, 2, 2000)
    low = (drawn.normal(size=2000) * width).astype(np.float32)
    high = (low + width * drawn.uniform(0, 2, 2000)).astype(np.float32)
    found = lines(jnp.asarray(low), jnp.asarray(high))
    for share in np.linspace(0, 1, 41):
        x = np.clip((low + share * (high - low)).astype(np.float32), low, high)
        y = np.asarray(activation(jnp.asarray(x)))
        room = 1e-6 * (1 + np.abs(x))
        assert np.all(found.low_slope * x + found.low_shift <= y + room)
        assert np.all(found.high_slope * x + found.high_shift >= y - room)


def test_lines_of_a_point_are_the_activation():
    x = jnp.linspace(-3, 3, 13)
    for lines, activation in ((relax_leaky_relu, leaky_relu), (relax_softsign, softsign)):
        found = lines(x, x)
        np.testing.assert_allclose(found.low_slope * x + found.low_shift, activation(x), atol=2e-6)
        np.testing.assert_allclose(
            found.high_slope * x + found.high_shift, activation(x), atol=2e-6
        )
