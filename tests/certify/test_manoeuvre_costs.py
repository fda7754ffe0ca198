"""Linear bounds of what a manoeuvre costs hold for all errors."""

import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.certify.manoeuvre_costs import Linear, _Scales, gauge_bounds, larger
from glasshelm.core.geometry import Vector
from glasshelm.ship.domain import (
    AHEAD_LOA,
    ASTERN_LOA,
    PORT_LOA,
    STARBOARD_LOA,
    danger_unclipped,
)

LOA_M = 340.0
DOMAIN = _Scales(*(1 / (a * LOA_M) for a in (STARBOARD_LOA, PORT_LOA, AHEAD_LOA, ASTERN_LOA)))
PLACES, ERRORS = 400, 8


def evaluated(form: Linear, fractions: np.ndarray) -> np.ndarray:
    return np.asarray(form.shift) + np.einsum("gc,sg->sc", np.asarray(form.slopes), fractions)


@pytest.mark.parametrize("size_m", [0.0, 10.0, 100.0, 1000.0])
def test_the_danger_is_between_its_bounds(size_m):
    drawn = np.random.default_rng(1)
    x, y = drawn.uniform(-2500, 2500, (2, PLACES)).astype(np.float32)
    x[:20], y[20:40], x[40:44], y[40:44] = 0.0, 0.0, 0.0, 0.0
    across, along = (size_m * drawn.uniform(-1, 1, (2, ERRORS, PLACES))).astype(np.float32)
    slack = np.full(PLACES, 0.1 * size_m, np.float32)
    centre = np.hypot(across, along).sum(0) + slack
    bounds = gauge_bounds(
        Vector(jnp.asarray(x), jnp.asarray(y)), jnp.asarray(across), jnp.asarray(along),
        jnp.asarray(slack), DOMAIN, jnp.asarray(centre),
    )  # fmt: skip
    fractions = drawn.uniform(-1, 1, (200, ERRORS))
    fractions[::2] = np.sign(fractions[::2])
    turn = drawn.uniform(0, 2 * np.pi, (200, PLACES))
    east = x + fractions @ across + slack * np.sin(turn)
    north = y + fractions @ along + slack * np.cos(turn)
    danger = np.asarray(danger_unclipped(Vector(jnp.asarray(east), jnp.asarray(north)), LOA_M))
    assert np.all(danger <= evaluated(bounds.high, fractions) + 2e-6)
    assert np.all(danger >= evaluated(bounds.low, fractions) - 2e-6)
    assert np.all(danger <= np.asarray(bounds.most) + 2e-6)
    assert np.all(danger >= np.asarray(bounds.least) - 2e-6)
    if size_m == 0.0:
        np.testing.assert_allclose(bounds.most, danger[0], atol=1e-5)
        np.testing.assert_allclose(bounds.least, danger[0], atol=1e-5)


def test_the_larger_of_two_is_below_its_bound_and_no_looser_than_needed():
    drawn = np.random.default_rng(2)

    def form() -> Linear:
        shift, slopes = drawn.normal(size=PLACES), drawn.normal(size=(ERRORS, PLACES))
        return Linear(jnp.asarray(shift, jnp.float32), jnp.asarray(0.3 * slopes, jnp.float32))

    a, b = form(), form()
    bound = larger(a, b)
    fractions = np.sign(drawn.uniform(-1, 1, (300, ERRORS)))
    both = np.maximum(evaluated(a, fractions), evaluated(b, fractions))
    assert np.all(both <= evaluated(bound, fractions) + 1e-5)
    below = np.asarray(b.most) < np.asarray(a.least)
    assert below.any()
    np.testing.assert_allclose(np.asarray(bound.shift)[below], np.asarray(a.shift)[below])
