import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.env.scenes import SHIP, random_scene, sail, scene

from glasshelm.core.geometry import Vector
from glasshelm.encounters.types import Encounter
from glasshelm.env.rewards import SubTask
from glasshelm.env.step import EnvSettings, reset, step

RUDDERS = 0.08 * np.sin(np.arange(60) / 2.0)


def test_a_waypoint_reached_terminates_and_does_not_truncate():
    # 10 kn: 25.7 m a step; 600 m − 500 m of arrival distance is passed in the fourth.
    out = sail(scene([], route=[(0.0, 600.0)]), np.zeros(6))
    assert out.terminated.tolist() == [False] * 3 + [True] * 3
    assert not out.truncated.any()


def test_the_clock_truncates_and_does_not_terminate():
    out = sail(scene([]), np.zeros(6), EnvSettings(episode_steps=4))
    assert out.truncated.tolist() == [False] * 3 + [True] * 3
    assert not out.terminated.any()


def test_arrival_on_the_last_step_is_termination_alone():
    out = sail(scene([], route=[(0.0, 600.0)]), np.zeros(4), EnvSettings(episode_steps=4))
    assert bool(out.terminated[-1])
    assert not bool(out.truncated[-1])


def test_waypoints_are_taken_in_order_and_only_the_last_terminates():
    route = [(0.0, 600.0), (2000.0, 600.0), (2000.0, 4000.0)]
    state = reset(scene([], route=route), SHIP)
    encounter = scene([], route=route)
    go = eqx.filter_jit(step)
    reached = []
    for _ in range(400):
        bearing = float(state.observation.waypoint[0, 2]) * math.pi
        out = go(encounter, state, jnp.float32(np.clip(bearing, -1, 1) * 0.087), SHIP)
        if int(out.state.leg) != int(state.leg):
            reached.append((float(out.state.own.east_m), float(out.state.own.north_m)))
            assert not bool(out.terminated)
        state = out.state
        if bool(out.terminated):
            break
    assert bool(out.terminated)
    assert int(state.leg) == len(route) - 1
    for (east, north), mark in zip(reached, route, strict=False):
        assert math.hypot(east - mark[0], north - mark[1]) < 500
    assert len(reached) == 2
    assert math.hypot(float(state.own.east_m) - 2000, float(state.own.north_m) - 4000) < 500


def test_changing_the_waypoint_pays_no_turn_reward():
    # The new waypoint lies nearer to the bow than the old: nobody turned.
    encounter = scene([], route=[(200.0, 480.0), (0.0, 9000.0)], heading_deg=0.0)
    out = sail(encounter, np.zeros(2))
    assert out.state.leg.tolist() == [1, 1]
    assert float(out.reward.waypoint[0]) == pytest.approx(0.2, abs=1e-5)


def test_jit_does_what_eager_does():
    encounter = random_scene(4)
    state = reset(encounter, SHIP)
    eager = step(encounter, state, jnp.float32(0.05), SHIP)
    jitted = eqx.filter_jit(step)(encounter, state, jnp.float32(0.05), SHIP)
    for a, b in zip(jax.tree.leaves(eager), jax.tree.leaves(jitted), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-5, atol=1e-5)


@pytest.mark.slow
def test_batch_by_vmap_does_what_one_does():
    encounters = [random_scene(seed, count) for seed, count in ((1, 0), (2, 3), (3, 6))]
    batch = jax.tree.map(lambda *x: jnp.stack(x), *encounters)
    rudder = jnp.float32([0.0, 0.05, -0.08])

    def once(e, r):
        return step(e, reset(e, SHIP), r, SHIP)

    together = jax.jit(jax.vmap(once))(batch, rudder)
    for i, encounter in enumerate(encounters):
        alone = jax.jit(once)(encounter, rudder[i])
        for a, b in zip(jax.tree.leaves(alone), jax.tree.leaves(together), strict=True):
            np.testing.assert_allclose(a, b[i], rtol=1e-5, atol=1e-5)


@pytest.mark.slow
def test_what_stands_in_an_empty_slot_has_no_influence():
    ship = (400.0, 3000.0, 185.0, 6.0)
    alone = sail(scene([ship]), RUDDERS)
    # The empty slot would hold a ship on top of own ship.
    padded = sail(scene([ship, (0.0, 0.0, 0.0, 5.0)], present=[True, False]), RUDDERS)
    np.testing.assert_allclose(
        alone.state.observation.targets[:, 0], padded.state.observation.targets[:, 0], atol=1e-6
    )
    assert not np.any(padded.state.observation.targets[:, 1])
    assert not np.any(padded.state.observation.present[:, 1])
    assert not np.any(padded.state.danger[:, 1])
    assert not np.any(padded.reward.by_ship[:, 1])
    assert (padded.margin[:, 1] < -100).all()
    assert (padded.range_m[:, 1] > 1e5).all()
    np.testing.assert_allclose(alone.reward.total, padded.reward.total, atol=1e-6)
    assert alone.state.danger.max() > 0.1  # the other one did come near


def test_zero_slots_are_a_world():
    out = sail(scene([]), RUDDERS)
    assert out.reward.by_ship.shape == (60, 0)
    np.testing.assert_allclose(out.reward.total, out.reward.waypoint)


def test_reward_is_derived_by_summing():
    out = sail(scene([(400.0, 3000.0, 185.0, 6.0), (-300.0, 900.0, 0.0, 5.0)]), RUDDERS)
    by_ship = np.asarray(out.reward.by_ship)
    assert (by_ship.min(0) < -0.1).all()
    np.testing.assert_allclose(
        out.reward.total, np.asarray(out.reward.waypoint) + by_ship.sum(-1), atol=1e-6
    )
    np.testing.assert_allclose(out.reward.by_task[:, SubTask.COLLISION], by_ship.sum(-1), atol=1e-6)


def test_rewards_follow_the_danger_of_the_states():
    out = sail(scene([(400.0, 3000.0, 185.0, 6.0)]), np.zeros(150))
    danger = np.concatenate([[0.0], np.asarray(out.state.danger[:, 0])])
    now, before = danger[1:], danger[:-1]
    expected = np.where(now > 0, np.where(now > before, -now - 0.5, -0.5 * now - 0.1), 0.0)
    np.testing.assert_allclose(out.reward.by_ship[:, 0], expected, atol=1e-5)
    assert len(np.unique(np.sign(now - before))) == 3  # rose, stood at zero, fell
    np.testing.assert_allclose(now, np.maximum(out.margin[:, 0], 0.0), atol=1e-6)


def test_range_and_margin_are_those_of_the_targets():
    out = sail(scene([(1000.0, 3000.0, 180.0, 5.0)]), np.zeros(10))
    t = 5.0 * np.arange(1, 11)
    north = 3000 - (5.0 + SHIP.speed_m_s) * t
    np.testing.assert_allclose(out.range_m[:, 0], np.hypot(1000, north), rtol=1e-4)
    np.testing.assert_allclose(out.margin[:, 0], 1 - np.hypot(1000 / 1088, north / 2176), atol=1e-3)


@pytest.mark.slow
def test_voyage_has_finite_gradients():
    encounter = random_scene(7, 3)

    def total(rudder, encounter: Encounter):
        state = reset(encounter, SHIP)

        def go(state, _):
            out = step(encounter, state, rudder, SHIP)
            return out.state, out.reward.waypoint + out.margin.sum()

        return jax.lax.scan(go, state, None, length=30)[1].sum()

    for present in (True, False):
        e = Encounter(
            encounter.own,
            Vector(encounter.route.x, encounter.route.y),
            encounter.targets,
            encounter.present & present,
        )
        slope = float(jax.jit(jax.grad(total))(jnp.float32(0.0), e))
        assert math.isfinite(slope)
