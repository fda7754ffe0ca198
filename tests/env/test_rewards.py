import math

import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.env.rewards import (
    SUB_TASKS,
    Reward,
    SubTask,
    collision_reward,
    course_reward,
    step_reward,
    turn_reward,
)


def rad(degrees: float):
    return jnp.float32(math.radians(degrees))


@pytest.mark.parametrize(
    ("now", "before", "reward"),
    [
        (0.0, 0.0, 0.0),  # outside
        (0.0, 0.4, 0.0),  # just left
        (0.4, 0.3, -0.4 - 0.5),  # danger rises
        (0.4, 0.0, -0.4 - 0.5),  # just entered
        (0.4, 0.5, -0.2 - 0.1),  # danger falls
        (0.4, 0.4, -0.2 - 0.1),  # danger stands
        (1.0, 0.9, -1.5),
    ],
)
def test_collision_reward_has_the_three_branches_of_eq_16(now, before, reward):
    found = collision_reward(jnp.float32([now]), jnp.float32([before]))
    np.testing.assert_allclose(found, [reward], atol=1e-6)


@pytest.mark.parametrize(
    ("degrees", "reward"),
    [
        (0, 0.20),
        (60, 0.20 * (0.9 * math.exp(-0.5) + 0.1 * 2 / 3)),
        (180, 0.20 * 0.9 * math.exp(-4.5)),
    ],
)
def test_course_reward_is_eq_17(degrees, reward):
    assert float(course_reward(rad(degrees))) == pytest.approx(reward, rel=1e-5)
    assert float(course_reward(rad(-degrees))) == pytest.approx(reward, rel=1e-5)


def test_turn_reward_is_the_share_of_ten_degrees_or_of_what_was_left():
    none = jnp.float32(0.0)
    # 30° → 26°: 4 of 10 degrees
    assert float(turn_reward(rad(26), rad(30), none)) == pytest.approx(0.05 * 0.4, rel=1e-4)
    assert float(turn_reward(rad(-26), rad(30), none)) == pytest.approx(0.05 * 0.4, rel=1e-4)
    # 4° → 1°: 3 of the 4 degrees left
    assert float(turn_reward(rad(1), rad(-4), none)) == pytest.approx(0.05 * 0.75, rel=1e-4)


def test_turn_reward_is_clipped_and_guarded():
    none = jnp.float32(0.0)
    assert float(turn_reward(rad(10), rad(40), none)) == pytest.approx(0.05)
    assert float(turn_reward(rad(40), rad(10), none)) == 0.0
    assert float(turn_reward(rad(0), rad(0), none)) == 0.0
    assert float(turn_reward(rad(5), rad(0), none)) == 0.0


def test_turn_reward_counts_only_while_no_ship_is_in_the_domain():
    assert float(turn_reward(rad(20), rad(30), jnp.float32(1e-3))) == 0.0
    assert float(turn_reward(rad(20), rad(30), jnp.float32(0.0))) == pytest.approx(0.05)


def test_gate_looks_at_the_sum_over_all_ships():
    free = step_reward(rad(20), rad(30), jnp.zeros(3), jnp.zeros(3))
    held = step_reward(rad(20), rad(30), jnp.float32([0, 0, 0.2]), jnp.float32([0, 0, 0.2]))
    assert float(free.waypoint - held.waypoint) == pytest.approx(0.05, abs=1e-6)
    np.testing.assert_allclose(held.by_ship, [0, 0, -0.2], atol=1e-6)


def test_scalar_reward_is_the_sum_of_the_sub_tasks_in_their_order():
    reward = Reward(jnp.float32([0.2, 0.1]), jnp.float32([[-0.3, -0.5], [0.0, 0.0]]))
    assert [task.name for task in SUB_TASKS] == ["WAYPOINT", "COLLISION"]
    np.testing.assert_allclose(reward.by_task[:, SubTask.WAYPOINT], [0.2, 0.1])
    np.testing.assert_allclose(reward.by_task[:, SubTask.COLLISION], [-0.8, 0.0], atol=1e-6)
    np.testing.assert_allclose(reward.total, [-0.6, 0.1], atol=1e-6)
