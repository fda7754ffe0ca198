import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.networks.scenes import COUNTS, CRITIC, KEY, actions, observations, of_counts

from glasshelm.env.observe import Observation
from glasshelm.networks.critics import CriticSizes, SubTaskCritic

LENSES = ("flat", "fine")


def test_paper_sizes_are_tables_a1_and_a2():
    critic = eqx.filter_eval_shape(lambda: SubTaskCritic(CriticSizes(), KEY))
    count = lambda mlp: sum(x.size for x in (*mlp.weights, *mlp.biases))  # noqa: E731
    # 5 frames of 3 and the action → 256 → 256 → 128 → 1
    by_hand = 16 * 256 + 256 + 256 * 256 + 256 + 256 * 128 + 128 + 128 + 1
    assert count(critic.of_waypoint) == by_hand == 103_169
    assert count(critic.of_target) == 112_129
    leaves = jax.tree.leaves(eqx.filter(critic, lambda x: hasattr(x, "shape")))
    assert sum(x.size for x in leaves) == 103_169 + 112_129


@pytest.mark.parametrize("norm", [False, True])
@pytest.mark.parametrize("lens", LENSES)
def test_value_is_the_sum_of_the_heads_of_eq_19(lens, norm):
    critic = SubTaskCritic(dataclasses.replace(CRITIC, lens=lens, norm=norm), KEY)
    observation, rudder = of_counts(), actions(len(COUNTS))
    values = critic(observation, rudder)
    np.testing.assert_allclose(
        values.total, values.waypoint + values.by_ship.sum(-1), rtol=1e-5, atol=1e-6
    )
    np.testing.assert_allclose(values.by_task.sum(-1), values.total, rtol=1e-5, atol=1e-6)
    np.testing.assert_array_equal(values.by_task[:, 1], values.collision)
    # Each ship's value is what she would have alone, and the waypoint's is nobody's.
    for slot in range(observation.present.shape[1]):
        only = observation.present & (jnp.arange(observation.present.shape[1]) == slot)
        alone = critic(Observation(observation.waypoint, observation.targets, only), rudder)
        np.testing.assert_allclose(alone.by_ship[:, slot], values.by_ship[:, slot], atol=1e-6)
        np.testing.assert_allclose(alone.waypoint, values.waypoint, atol=1e-6)
    assert not np.asarray(values.by_ship)[~np.asarray(observation.present)].any()


def test_head_reads_its_frames_then_the_action():
    critic = SubTaskCritic(CRITIC, KEY)
    observation, rudder = observations(np.ones((1, 2))), jnp.float32([0.4])
    values = critic(observation, rudder)
    own = jnp.concatenate([observation.waypoint[0].reshape(15), rudder])
    np.testing.assert_allclose(values.waypoint[0], critic.of_waypoint(own)[0], rtol=1e-4)
    for ship in range(2):
        row = jnp.concatenate([observation.targets[0, ship].reshape(50), rudder])
        np.testing.assert_allclose(
            values.by_ship[0, ship], critic.of_target(row)[0], rtol=1e-4, atol=1e-6
        )


def test_order_of_the_ships_and_empty_slots_do_not_matter():
    critic = SubTaskCritic(CRITIC, KEY)
    observation, rudder = of_counts(), actions(len(COUNTS))
    values = critic(observation, rudder)
    order = np.array([3, 1, 0, 2])
    shuffled = critic(
        Observation(
            observation.waypoint, observation.targets[:, order], observation.present[:, order]
        ),
        rudder,
    )
    np.testing.assert_allclose(values.by_ship[:, order], shuffled.by_ship, atol=1e-6)
    np.testing.assert_allclose(values.total, shuffled.total, rtol=1e-5, atol=1e-5)
    wider = Observation(
        observation.waypoint,
        jnp.pad(observation.targets, ((0, 0), (0, 3), (0, 0), (0, 0)), constant_values=5.0),
        jnp.pad(observation.present, ((0, 0), (0, 3))),
    )
    np.testing.assert_allclose(critic(wider, rudder).total, values.total, rtol=1e-5, atol=1e-5)


def test_without_ships_the_waypoint_is_all():
    values = SubTaskCritic(CRITIC, KEY)(observations(np.zeros((2, 3))), actions(2))
    np.testing.assert_array_equal(values.total, values.waypoint)
    np.testing.assert_array_equal(values.collision, 0.0)
