"""The force is the slope of the potential, and a field has a mirror image."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.pilots.scenes import AGILE, mirrored, observed

from glasshelm.core.geometry import Vector
from glasshelm.pilots.potential_field import PotentialSettings, potential_course, repulsion

SETTINGS = PotentialSettings(influence_m=4000.0, radius_m=500.0, strength=0.2)


def potential(own, ship) -> jax.Array:
    """Khatib's ½·η·(1/ρ − 1/ρ₀)² of own ship's place, written out."""
    gap = jnp.hypot(*(ship - own)) - SETTINGS.radius_m
    reach = SETTINGS.influence_m
    inside = 0.5 * SETTINGS.strength * reach**3 * (1.0 / gap - 1.0 / reach) ** 2
    return jnp.where(gap < reach, inside, 0.0)


@pytest.mark.parametrize("place", [(1500.0, 2000.0), (-900.0, 300.0), (3000.0, -2500.0), (5e3, 0)])
def test_the_force_is_the_negative_gradient(place):
    ship = jnp.asarray(place, jnp.float32)
    slope = jax.grad(potential)(jnp.zeros(2), ship)
    force = repulsion(Vector(*ship), SETTINGS)
    np.testing.assert_allclose(jnp.stack(force), -slope, rtol=1e-4, atol=1e-7)


def test_beyond_its_reach_nothing_pushes_and_near_by_it_stays_finite():
    beyond = SETTINGS.influence_m + SETTINGS.radius_m + 1.0
    assert repulsion(Vector(jnp.float32(beyond), jnp.float32(0.0)), SETTINGS).x == 0.0
    near = repulsion(Vector(jnp.float32(1.0), jnp.float32(0.0)), SETTINGS).x
    assert jnp.isfinite(near)
    assert near < 0.0


def test_the_mirrored_field_steers_the_mirrored_course():
    rows = [(800.0, 2500.0, 180.0, 5.0), (-2000.0, 1500.0, 90.0, 5.0)]
    chosen = jax.jit(lambda s: potential_course(s, jnp.zeros(()), AGILE, SETTINGS))
    one, other = (float(chosen(observed(*r, ship=AGILE))) for r in (rows, mirrored(*rows)))
    assert abs(one) > 0.05
    assert one == pytest.approx(-other, abs=1e-4)


def test_dead_ahead_the_field_has_no_side():
    """Khatib's known weakness, kept as printed: on or back, until something moves."""
    chosen = jax.jit(lambda s: potential_course(s, jnp.zeros(()), AGILE, SETTINGS))
    for north in (2000.0, 3500.0):
        ahead = float(chosen(observed((0.0, north, 180.0, 5.0), ship=AGILE)))
        assert np.sin(ahead) == pytest.approx(0.0, abs=1e-3)
        beside = float(chosen(observed((300.0, north, 180.0, 5.0), ship=AGILE)))
        assert np.sin(beside) < -0.01
