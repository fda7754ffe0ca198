import math

import hypothesis.strategies as st
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given

from glasshelm.core.geometry import (
    Vector,
    closest_approach,
    direction,
    norm,
    to_body,
    to_world,
    velocity,
    wrap_angle,
)

angles = st.floats(-20.0, 20.0, width=32)
metres = st.floats(-20_000.0, 20_000.0, width=32)
speeds = st.floats(-12.0, 12.0, width=32)


def vector(x: float, y: float) -> Vector:
    return Vector(jnp.float32(x), jnp.float32(y))


@given(angles)
def test_wrapped_angle_is_in_range_and_the_same_direction(angle):
    wrapped = float(wrap_angle(jnp.float32(angle)))
    assert -math.pi - 1e-6 <= wrapped < math.pi + 1e-6
    assert math.isclose(math.sin(wrapped), math.sin(angle), abs_tol=1e-5)
    assert math.isclose(math.cos(wrapped), math.cos(angle), abs_tol=1e-5)


def test_half_a_turn_wraps_to_minus_pi():
    assert float(wrap_angle(jnp.float32(math.pi))) == pytest.approx(-math.pi, abs=1e-6)
    assert float(wrap_angle(jnp.float32(-math.pi))) == pytest.approx(-math.pi, abs=1e-6)
    assert float(wrap_angle(jnp.float32(3.0))) == pytest.approx(3.0, abs=1e-6)


@pytest.mark.parametrize(
    ("course_deg", "east", "north"), [(0, 0, 1), (90, 1, 0), (180, 0, -1), (270, -1, 0)]
)
def test_courses_run_clockwise_from_north(course_deg, east, north):
    v = velocity(jnp.float32(math.radians(course_deg)), jnp.float32(5.0))
    np.testing.assert_allclose(v, (5 * east, 5 * north), atol=1e-5)
    assert math.cos(float(direction(v)) - math.radians(course_deg)) == pytest.approx(1)


@given(metres, metres, angles)
def test_body_and_world_are_inverse(x, y, heading):
    v, h = vector(x, y), jnp.float32(heading)
    np.testing.assert_allclose(to_world(to_body(v, h), h), v, atol=0.02)
    np.testing.assert_allclose(to_body(to_world(v, h), h), v, atol=0.02)


def test_a_ship_to_the_east_is_abeam_to_starboard_of_a_northbound_ship():
    north, east = jnp.float32(0.0), jnp.float32(math.pi / 2)
    np.testing.assert_allclose(to_body(vector(100, 0), north), (100, 0), atol=1e-4)
    np.testing.assert_allclose(to_body(vector(100, 0), east), (0, 100), atol=1e-4)
    np.testing.assert_allclose(to_body(vector(0, 100), east), (-100, 0), atol=1e-4)


@given(metres, metres, speeds, speeds)
def test_cpa_agrees_with_brute_force(x, y, vx, vy):
    cpa = closest_approach(vector(x, y), vector(vx, vy))
    t = np.linspace(-3600.0, 3600.0, 14_401)  # every half second
    x, y, vx, vy = (np.float64(np.float32(k)) for k in (x, y, vx, vy))
    distance = np.hypot(x + vx * t, y + vy * t)
    relative_speed = np.hypot(vx, vy)
    assert float(cpa.dcpa_m) <= distance.min() + 0.05
    assert float(cpa.dcpa_m) >= distance.min() - 0.25 * relative_speed - 0.05
    found = np.hypot(*cpa.position)
    assert found == pytest.approx(float(cpa.dcpa_m), abs=0.02)
    if relative_speed > 0.1:  # below, the minimum is too flat to be timed in single precision
        assert float(cpa.tcpa_s) == pytest.approx(t[distance.argmin()], abs=0.5)


def test_cpa_of_ships_that_do_not_move_relative_to_each_other_is_now():
    cpa = closest_approach(vector(300, 400), vector(0, 0))
    assert float(cpa.tcpa_s) == 0
    assert float(cpa.dcpa_m) == pytest.approx(500)
    np.testing.assert_allclose(cpa.position, (300, 400))


def test_cpa_is_kept_within_the_horizon():
    slow = closest_approach(vector(0, 10_000), vector(0, -1))
    assert float(slow.tcpa_s) == 3600
    assert float(slow.dcpa_m) == pytest.approx(6400)
    past = closest_approach(vector(0, 10_000), vector(0, 1))
    assert float(past.tcpa_s) == -3600


@pytest.mark.parametrize("speed", [0.0, 1e-5, 1e-3, 5.0])
def test_cpa_and_its_gradient_are_finite_at_every_relative_speed(speed):
    def dcpa(x, y, v):
        return closest_approach(Vector(x, y), Vector(v, 0.5 * v)).dcpa_m

    value, slope = jax.value_and_grad(dcpa, argnums=(0, 1, 2))(
        jnp.float32(100.0), jnp.float32(-200.0), jnp.float32(speed)
    )
    assert np.isfinite([value, *slope]).all()


def test_norm_and_direction_have_finite_gradients_at_zero():
    for f in (norm, direction):
        slope = jax.grad(lambda x, y, f=f: f(Vector(x, y)), argnums=(0, 1))(0.0, 0.0)
        assert np.isfinite(slope).all()
    assert float(norm(vector(3, 4))) == pytest.approx(5)
