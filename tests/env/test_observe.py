import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.env.scenes import SHIP, begin_jitted, legs, mirrored, random_scene, sail, scene, turned

from glasshelm.encounters.types import Encounter
from glasshelm.env.observe import (
    FRAMES,
    TARGET_FEATURES,
    WAYPOINT_FEATURES,
    ObservationFrame,
    empty_observation,
    push_frame,
    waypoint_bearing_rad,
)

# Features that change sign when east and west are exchanged.
ODD_TARGET = [TARGET_FEATURES.index(name) for name in ("dx", "bearing", "vx", "cpa_dx")]
ODD_WAYPOINT = [WAYPOINT_FEATURES.index(name) for name in ("dx", "bearing")]
RUDDERS = 0.08 * np.sin(np.arange(40) / 7.0)


def feature(observation, slot: int, name: str, frame: int = 0) -> float:
    return float(observation.targets[slot, frame, TARGET_FEATURES.index(name)])


def test_frame_of_a_known_scene_is_eq_10_and_11():
    # Own ship northbound at 10 kn; a ship 4 km ahead, 2 km to starboard, westbound at 6 m/s.
    u = SHIP.speed_m_s
    seen = begin_jitted(scene([(2000.0, 4000.0, 270.0, 6.0)], route=[(3000.0, 3000.0)])).observation
    np.testing.assert_allclose(seen.waypoint[0], [0.15, 0.15, 0.25], rtol=1e-5)
    v = np.array([-6.0, -u])
    p = np.array([2000.0, 4000.0])
    tcpa = -(p @ v) / (v @ v)
    at_cpa = p + tcpa * v
    knots20 = 20 * 1852 / 3600
    expected = [
        0.1,
        0.2,
        math.atan2(2000, 4000) / math.pi,
        -6 / knots20,
        -u / knots20,
        np.hypot(*p) / (20_000 * math.sqrt(2)),
        at_cpa[0] / 20_000,
        at_cpa[1] / 20_000,
        np.hypot(*at_cpa) / (20_000 * math.sqrt(2)),
        tcpa / 1000,
    ]
    np.testing.assert_allclose(seen.targets[0, 0], expected, rtol=1e-4, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("angle", [0.5, 2.0, -2.8])
def test_scene_moved_and_turned_looks_and_pays_alike(angle):
    original = random_scene(3)
    elsewhere = turned(original, angle, 5_000.0, -3_000.0)
    here, there = sail(original, RUDDERS), sail(elsewhere, RUDDERS)
    np.testing.assert_allclose(
        here.state.observation.targets, there.state.observation.targets, atol=3e-5
    )
    np.testing.assert_allclose(
        here.state.observation.waypoint, there.state.observation.waypoint, atol=3e-5
    )
    np.testing.assert_allclose(here.reward.total, there.reward.total, atol=1e-4)
    np.testing.assert_allclose(here.margin, there.margin, atol=1e-3)


def test_mirrored_scene_flips_the_odd_features_and_only_them():
    original = random_scene(5)
    here, there = sail(original, RUDDERS), sail(mirrored(original), -RUDDERS)
    signs = np.ones(len(TARGET_FEATURES))
    signs[ODD_TARGET] = -1
    seen = here.state.observation.targets
    np.testing.assert_allclose(seen * signs, there.state.observation.targets, atol=1e-6)
    assert np.abs(seen[..., ODD_TARGET]).max(axis=(0, 1, 2)).min() > 0.01
    signs = np.ones(len(WAYPOINT_FEATURES))
    signs[ODD_WAYPOINT] = -1
    np.testing.assert_allclose(
        here.state.observation.waypoint * signs, there.state.observation.waypoint, atol=1e-6
    )
    np.testing.assert_allclose(here.reward.waypoint, there.reward.waypoint, atol=1e-6)


def test_first_frame_is_repeated_five_times():
    seen = begin_jitted(random_scene(1)).observation
    assert seen.targets.shape[-2] == seen.waypoint.shape[-2] == FRAMES == 5
    for frame in range(1, FRAMES):
        np.testing.assert_array_equal(seen.targets[:, frame], seen.targets[:, 0])
        np.testing.assert_array_equal(seen.waypoint[frame], seen.waypoint[0])
    assert np.abs(seen.targets[:4]).min(axis=(1, 2)).shape == (4,)
    assert (np.abs(seen.targets[:4, 0]).sum(-1) > 0).all()


def test_history_is_the_newest_frame_first():
    out = sail(random_scene(2), RUDDERS)
    targets = np.asarray(out.state.observation.targets)
    for back in range(1, FRAMES):
        np.testing.assert_array_equal(targets[20, :, back], targets[20 - back, :, 0])
    assert not np.array_equal(targets[20, 0, 0], targets[20, 0, 1])


def test_target_heard_late_begins_with_a_history_of_itself():
    track = legs((12.0, math.inf, 1000.0, 6000.0, 180.0, 5.0))
    base = scene([(0.0, 0.0, 0.0, 0.0)])
    out = sail(Encounter(base.own, base.route, track, base.present), np.zeros(8))
    seen = out.state.observation
    assert seen.present[:, 0].tolist() == [False, False] + [True] * 6  # at 5, 10, 15 ... s
    assert not np.any(seen.targets[1])
    for frame in range(FRAMES):
        np.testing.assert_array_equal(seen.targets[2, 0, frame], seen.targets[2, 0, 0])
    assert feature(jax.tree.map(lambda x: x[2], seen), 0, "dx") == pytest.approx(0.05)
    assert not np.array_equal(seen.targets[3, 0, 0], seen.targets[3, 0, 1])
    np.testing.assert_array_equal(seen.targets[3, 0, 1], seen.targets[2, 0, 0])


def test_lost_target_is_absent_and_all_zero():
    track = legs((0.0, 12.0, 1000.0, 6000.0, 180.0, 5.0))
    base = scene([(0.0, 0.0, 0.0, 0.0)])
    out = sail(Encounter(base.own, base.route, track, base.present), np.zeros(9))
    present = out.state.observation.present[:, 0].tolist()
    assert present == [True, True] + [False] * 7
    assert not np.any(out.state.observation.targets[2, 0, 0])


def test_remember_keeps_no_zero_frames_on_the_first_sight():
    sight = ObservationFrame(jnp.ones(3), 2 * jnp.ones((2, 10)), jnp.array([True, True]))
    seen = push_frame(empty_observation(2), sight, first=True)
    assert (seen.waypoint == 1).all()
    assert (seen.targets == 2).all()


@pytest.mark.parametrize("degrees", [-170.0, 0.0, 45.0, 179.0])
def test_bearing_is_read_back_from_the_frame(degrees):
    x, y = 1e4 * math.sin(math.radians(degrees)), 1e4 * math.cos(math.radians(degrees))
    seen = begin_jitted(scene([], route=[(x, y)])).observation
    assert math.degrees(float(waypoint_bearing_rad(seen.waypoint[0]))) == pytest.approx(
        degrees, abs=1e-3
    )
