import dataclasses
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.core.geometry import Vector, to_body
from glasshelm.encounters.random_encounters import (
    CONVERGING,
    PAPER,
    WIDE,
    random_encounter,
    random_scenario,
)
from glasshelm.ship.domain import danger_unclipped
from glasshelm.ship.nomoto import SHIPS

SHIP = SHIPS["paper"]
STRAIGHT = dataclasses.replace(PAPER, position_noise_m=0.0, course_noise_rad=0.0)


def draw(settings, count=500, seed=0):
    keys = jax.random.split(jax.random.key(seed), count)
    return jax.jit(jax.vmap(lambda k: random_encounter(k, SHIP, settings)))(keys)


@pytest.fixture(scope="module")
def straight():
    return draw(STRAIGHT)


@pytest.fixture(scope="module")
def paper():
    return draw(PAPER)


@pytest.fixture(scope="module")
def wide():
    return draw(WIDE)


def columns(encounters):
    t = encounters.targets
    return (np.asarray(x)[..., 0] for x in (t.east_m, t.north_m, t.course_rad, t.speed_m_s))


def offset_and_body(encounters):
    east, north, _, _ = columns(encounters)
    own = encounters.own
    offset = Vector(
        jnp.asarray(east) - own.east_m[:, None], jnp.asarray(north) - own.north_m[:, None]
    )
    return offset, to_body(offset, own.heading_rad[:, None])


def test_without_noise_every_pair_collides_at_t_col(straight):
    # Eq. 8 backwards: the way from target to own ship is t_col times their relative velocity.
    east, north, course, speed = columns(straight)
    v_east = -speed * np.sin(course)
    v_north = float(SHIP.speed_m_s) - speed * np.cos(course)
    t_col = np.hypot(east, north) / np.hypot(v_east, v_north)
    np.testing.assert_allclose(east - t_col * v_east, 0, atol=1.0)
    np.testing.assert_allclose(north - t_col * v_north, 0, atol=1.0)
    assert t_col.min() >= 600 * (1 - 1e-3)
    assert t_col.max() <= 1800 * (1 + 1e-3)


def test_ranges_of_equation_8_are_filled(straight):
    _, _, course, speed = columns(straight)
    assert 4.1 <= speed.min() < 4.2
    assert 6.1 < speed.max() <= 6.2
    degrees = np.degrees(course)
    assert -150.01 <= degrees.min() < -145
    assert 145 < degrees.max() <= 150.01


def test_noise_has_the_size_of_equation_9(straight, paper):
    # The same keys with and without noise differ by the noise alone, where neither was redrawn.
    east, north, course, speed = columns(straight)
    east_2, north_2, course_2, speed_2 = columns(paper)
    same = speed == speed_2
    assert same.mean() > 0.5
    for shift in ((east_2 - east)[same], (north_2 - north)[same]):
        assert np.abs(shift).max() <= 1000.1
        assert shift.std() == pytest.approx(1000 / math.sqrt(3), rel=0.05)
    turn = np.degrees((course_2 - course)[same])
    assert np.abs(turn).max() <= 30.01
    assert turn.std() == pytest.approx(30 / math.sqrt(3), rel=0.05)


def test_spawn_rule_of_the_paper(paper):
    offset, body = offset_and_body(paper)
    assert float(jnp.hypot(*offset).min()) >= 7 * float(SHIP.loa_m)
    assert float(danger_unclipped(body, SHIP.loa_m).max()) <= 0


def test_spawn_rule_of_wide(wide):
    offset, body = offset_and_body(wide)
    assert float(jnp.hypot(*offset).min()) >= WIDE.nearest_spawn_loa * float(SHIP.loa_m)
    assert float(danger_unclipped(body, SHIP.loa_m).max()) <= WIDE.spawn_danger
    assert float(jnp.hypot(*offset).min()) < 7 * float(SHIP.loa_m), "wide starts nearer than paper"


def test_wide_varies_waypoint_and_heading(wide):
    for values, (low, high) in (
        (np.asarray(wide.route.y), WIDE.waypoint_m),
        (np.asarray(wide.own.heading_rad), (-WIDE.own_heading_rad, WIDE.own_heading_rad)),
    ):
        margin = 0.05 * (high - low)
        assert low <= values.min() < low + margin
        assert high - margin < values.max() <= high
    for leaf in [*jax.tree.leaves(wide.own), wide.route.x, wide.targets.east_m]:
        assert bool(jnp.all(jnp.isfinite(leaf)))


def test_converging_ships_go_much_the_same_way_and_come_from_both_sides():
    drawn = draw(CONVERGING)
    _, _, course, _ = columns(drawn)
    assert np.degrees(np.abs(course)).max() <= 50.1
    _, body = offset_and_body(drawn)
    present, across = np.asarray(drawn.present), np.asarray(body.x)
    near = present & (np.hypot(*body) < 4_000)
    pinched = (near & (across < 0)).any(-1) & (near & (across > 0)).any(-1)
    assert pinched[present.sum(-1) >= 2].mean() > 0.3
    assert float(jnp.hypot(*offset_and_body(drawn)[0]).min()) >= 5.5 * float(SHIP.loa_m)


def test_counts_are_uniform_from_none_to_six(paper):
    present = np.asarray(paper.present)
    counts = np.bincount(present.sum(1), minlength=7)
    assert len(counts) == 7
    # 500 draws: each count is 71 ± 8 (one standard deviation); 4.5 of them either way.
    assert np.all(np.abs(counts - 500 / 7) < 36)
    assert np.all(present == (np.arange(6) < present.sum(1)[:, None])), "the first slots are filled"


def test_courses_of_ships_are_independent(straight):
    _, _, course, speed = columns(straight)
    assert np.abs(np.corrcoef(course[:, 0], course[:, 1])[0, 1]) < 0.2
    assert np.abs(np.corrcoef(course[:, 0], speed[:, 0])[0, 1]) < 0.2


def test_own_ship_starts_as_in_the_paper(paper):
    assert bool(jnp.all(paper.own.heading_rad == 0))
    assert bool(jnp.all(paper.own.speed_m_s == SHIP.speed_m_s))
    np.testing.assert_allclose(paper.route.y, 46_300, rtol=1e-6)


def test_scenarios_are_reproducible_by_seed():
    once, again, other = (random_scenario(seed, SHIP) for seed in (11, 11, 12))
    for a, b in zip(jax.tree.leaves(once.encounter), jax.tree.leaves(again.encounter), strict=True):
        np.testing.assert_array_equal(a, b)
    assert len(once.targets) == once.encounter.present.shape[0]
    assert bool(jnp.all(once.encounter.present))
    ours, theirs = (float(s.encounter.targets.east_m.sum()) for s in (once, other))
    assert ours != theirs
