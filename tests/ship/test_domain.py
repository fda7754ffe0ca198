import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.core.geometry import Vector
from glasshelm.ship.domain import danger, danger_unclipped

LOA = 340.0


def at(x: float, y: float) -> Vector:
    return Vector(jnp.float32(x), jnp.float32(y))


# Half axes of Eq. 14-15 for 340 m: 1088 m to starboard, 544 m to port,
# 2176 m ahead, 544 m astern.
@pytest.mark.parametrize(("x", "y"), [(1088, 0), (-544, 0), (0, 2176), (0, -544)])
def test_danger_falls_from_one_at_own_ship_to_zero_on_the_edge(x, y):
    assert float(danger(at(0, 0), LOA)) == 1.0
    for share in (0.25, 0.5, 0.75):
        assert float(danger(at(share * x, share * y), LOA)) == pytest.approx(1 - share, abs=1e-6)
    assert float(danger(at(x, y), LOA)) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("theta", np.linspace(0.1, 6.2, 9))
def test_the_edge_is_four_quarters_of_ellipses(theta):
    x = (1088 if math.sin(theta) >= 0 else 544) * math.sin(theta)
    y = (2176 if math.cos(theta) >= 0 else 544) * math.cos(theta)
    assert float(danger_unclipped(at(x, y), LOA)) == pytest.approx(0.0, abs=1e-5)
    assert float(danger_unclipped(at(0.5 * x, 0.5 * y), LOA)) == pytest.approx(0.5, abs=1e-5)


def test_outside_is_zero_clipped_and_negative_unclipped():
    assert float(danger(at(0, 4352), LOA)) == 0.0
    assert float(danger_unclipped(at(0, 4352), LOA)) == pytest.approx(-1.0)
    assert float(danger(at(-600, 0), LOA)) == 0.0
    assert float(danger(at(600, 0), LOA)) > 0.4


def test_domain_grows_with_the_ship():
    assert float(danger(at(0, 1088), LOA / 2)) == pytest.approx(0.0, abs=1e-6)


def test_gradient_is_finite_on_top_of_own_ship():
    slope = jax.grad(lambda x, y: danger_unclipped(Vector(x, y), LOA), argnums=(0, 1))(0.0, 0.0)
    assert np.isfinite(slope).all()
