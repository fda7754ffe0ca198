import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.encounters.random_encounters import PAPER
from glasshelm.env.step import EnvSettings
from glasshelm.networks.actors import ActorSizes, make_actor
from glasshelm.ship.nomoto import ship_named
from glasshelm.training.exploration import NoiseSettings
from glasshelm.training.replay_buffer import (
    ReplayRow,
    append,
    empty_buffer,
    gather,
    sample,
    sampleable_steps,
)
from glasshelm.training.vector_env import draw_pool, init_envs, staggered_end, step_all

SHIP = ship_named("paper")
append_jitted, gather_jitted, sample_jitted = (
    jax.jit(append), jax.jit(gather), jax.jit(sample, static_argnums=1)
)  # fmt: skip


def test_a_million_transitions_fit_in_400_mb():
    buffer = jax.eval_shape(lambda: empty_buffer(10_000, 100, 6))
    assert sum(x.size * x.dtype.itemsize for x in jax.tree.leaves(buffer)) <= 400e6


@pytest.fixture(scope="module")
def simulated():
    """A short ring written over twice, and every observation on the way."""
    num_envs, ring, settings = 4, 17, EnvSettings(episode_steps=9)
    pool = jax.jit(lambda: draw_pool(jax.random.key(0), 16, SHIP, PAPER))()
    actor = make_actor("sum", ActorSizes((4,), (4,)), jax.random.key(1))

    @jax.jit
    def go(envs, replay, key):
        truncate = staggered_end(replay.written, num_envs, settings.episode_steps)
        envs, row = step_all(
            envs, actor, pool, jnp.zeros(()), truncate, key, SHIP, settings, NoiseSettings()
        )
        return envs, append(replay, row), row

    envs, replay = init_envs(pool, num_envs), empty_buffer(ring, num_envs, 6)
    observations, rows = [], []
    for number in range(2 * ring + 5):
        observations.append(envs.state.observation)
        envs, replay, row = go(envs, replay, jax.random.key(100 + number))
        rows.append(row)
    return replay, observations, rows


@pytest.mark.slow
def test_stacks_are_the_environments_own_observations_bit_for_bit(simulated):
    replay, observations, rows = simulated
    low, high = (int(x) for x in sampleable_steps(replay))
    assert high - low == replay.capacity - 5
    starts, ends = 0, 0
    for number in range(low, high):
        batch = gather_jitted(replay, jnp.full(4, number), jnp.arange(4))
        transition = np.asarray(rows[number].transition)
        np.testing.assert_array_equal(batch.weight, transition)
        np.testing.assert_array_equal(batch.observation.waypoint, observations[number].waypoint)
        np.testing.assert_array_equal(batch.observation.targets, observations[number].targets)
        np.testing.assert_array_equal(batch.observation.present, observations[number].present)
        following = observations[number + 1]
        np.testing.assert_array_equal(
            batch.next_observation.waypoint[transition], following.waypoint[transition]
        )
        np.testing.assert_array_equal(
            batch.next_observation.targets[transition], following.targets[transition]
        )
        np.testing.assert_array_equal(batch.action, rows[number].action)
        np.testing.assert_array_equal(batch.next_action, rows[number + 1].action)
        np.testing.assert_array_equal(batch.reward.by_ship, rows[number].rewards[:, 1:])
        starts += int((np.asarray(rows[number].age) == 0).sum())
        ends += int((~transition).sum())
    assert starts >= 4
    assert ends >= 4


def test_episodes_end_at_different_steps_and_take_their_full_length(simulated):
    _, _, rows = simulated
    ends = np.array([~np.asarray(row.transition) for row in rows])  # [step, environment]
    assert ends.any(0).all()
    assert ends.sum(1).max() <= 2
    for env in range(4):
        steps = np.flatnonzero(ends[:, env])
        assert (np.diff(steps) == 10).all()  # nine steps and the last frame's own row


def test_no_draw_reaches_what_the_write_head_has_overwritten():
    ring, num_envs = 12, 2
    replay = empty_buffer(ring, num_envs, 1)
    for number in range(ring + 7):
        stamp = jnp.full((num_envs, 13), float(number))
        replay = append_jitted(
            replay,
            ReplayRow(
                stamp,
                stamp[:, 0],
                stamp[:, :2],
                jnp.ones((num_envs, 1), jnp.uint8),
                jnp.full(num_envs, number, jnp.int16),  # one endless episode
                jnp.ones(num_envs, bool),
                jnp.zeros(num_envs, bool),
            ),
        )
    batch = sample_jitted(replay, 2000, jax.random.key(0))
    now = batch.action
    np.testing.assert_array_equal(
        batch.observation.waypoint[..., 0], now[:, None] - jnp.arange(5.0)[None, :]
    )
    np.testing.assert_array_equal(
        batch.next_observation.waypoint[..., 0], now[:, None] + 1 - jnp.arange(5.0)[None, :]
    )
    low, high = sampleable_steps(replay)
    assert set(np.asarray(now).astype(int)) == set(range(int(low), int(high)))
    beyond = gather_jitted(replay, low[None] - 1, jnp.zeros(1, int))  # one more would be wrong
    assert float(beyond.observation.waypoint[0, 4, 0]) != float(low) - 5
