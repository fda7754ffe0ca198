"""Velocity obstacles against brute force: what is chosen really passes clear."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.pilots.scenes import AGILE, colliding, mirrored, observed

from glasshelm.core.geometry import Vector
from glasshelm.pilots.velocity_obstacles import (
    VelocitySettings,
    entry_s,
    passes_to_starboard,
    velocity_course,
)

SETTINGS = VelocitySettings(radius_m=800.0, horizon_s=3600.0, change_cost=0.0)


def course(rows, settings=SETTINGS) -> float:
    chosen = jax.jit(lambda s: velocity_course(s, jnp.zeros(()), AGILE, settings))
    return float(chosen(observed(*rows, ship=AGILE)))


def nearest(rows, course_rad) -> float:
    """The nearest that any ship comes within an hour, by looking every second."""
    t = np.arange(0.0, 3600.0)
    own = AGILE.speed_m_s * t[:, None] * np.array([np.sin(course_rad), np.cos(course_rad)])
    found = []
    for east, north, heading, speed in rows:
        way = np.radians(heading)
        there = np.array([east, north]) + speed * t[:, None] * [np.sin(way), np.cos(way)]
        found.append(np.hypot(*(there - own).T).min())
    return min(found)


def test_the_time_of_entry_is_that_of_a_simulation():
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 4000.0, 0.5)
    for _ in range(30):
        p, v = rng.uniform(-5000, 5000, 2), rng.uniform(-8, 8, 2)
        distance = np.hypot(*(p[:, None] + v[:, None] * t))
        inside = distance < 1000.0
        simulated = t[inside.argmax()] if inside.any() else np.inf
        closing = float(p @ v) < 0
        expected = simulated if closing else np.inf
        ours = float(entry_s(Vector(*jnp.asarray(p)), Vector(*jnp.asarray(v)), 1000.0))
        assert ours == pytest.approx(expected, abs=1.0) or (expected == np.inf and ours > 3999)


@pytest.mark.parametrize(
    "rows",
    [
        [colliding(180.0, ship=AGILE)],
        [colliding(270.0, ship=AGILE)],
        [colliding(90.0, 4.0, ship=AGILE)],
        [colliding(0.0, 2.0, ship=AGILE)],
        [colliding(180.0, ship=AGILE), colliding(270.0, ship=AGILE)],
        [colliding(150.0, ship=AGILE), colliding(300.0, ship=AGILE), colliding(45.0, ship=AGILE)],
    ],
)
def test_the_chosen_course_is_outside_every_cone_and_a_smaller_one_is_not(rows):
    chosen = course(rows)
    assert nearest(rows, 0.0) < 400.0  # keeping on would not do
    assert nearest(rows, chosen) > 780.0
    step = np.radians(SETTINGS.step_deg)
    for smaller in np.arange(0.0, abs(chosen) - 1.5 * step, step):
        assert min(nearest(rows, smaller), nearest(rows, -smaller)) < 830.0


def test_in_the_mirror_the_course_is_mirrored():
    rows = [(1200.0, 5000.0, 195.0, 5.0)]  # would pass at 547 m
    one, other = course(rows), course(mirrored(*rows))
    assert one != 0.0
    assert one == pytest.approx(-other, abs=1e-5)


def test_with_the_rules_she_passes_astern_of_a_ship_from_starboard():
    """Without them the shorter way is ahead of her."""
    rows = [(4700.0, 4000.0, 270.0, 5.0)]
    rules = dataclasses.replace(SETTINGS, colregs=True, rules_dcpa_m=2000.0)
    assert course(rows) < 0.0
    assert course(rows, rules) > 0.0


def test_which_side_the_other_is_left_on():
    ahead = Vector(jnp.float32(0.0), jnp.float32(1000.0))
    left, right = (Vector(jnp.float32(x), jnp.float32(-5.0)) for x in (-1.0, 1.0))
    assert not passes_to_starboard(ahead, left)  # she drifts to port: left to port
    assert passes_to_starboard(ahead, right)
    assert not passes_to_starboard(ahead, Vector(jnp.float32(1.0), jnp.float32(5.0)))  # leaving
