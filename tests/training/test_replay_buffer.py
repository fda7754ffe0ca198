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
    Row,
    drawable,
    empty_replay,
    gather,
    replay_bytes,
    sample,
    write,
)
from glasshelm.training.vector_env import cut_short, draw_pool, first_worlds, tick

SHIP = ship_named("paper")


def test_a_million_transitions_fit_in_400_mb():
    assert replay_bytes(10_000, 100, 6) <= 400e6


@pytest.fixture(scope="module")
def sailed():
    """A short ring written over twice, and everything that the worlds showed on the way."""
    worlds, ring, settings = 4, 17, EnvSettings(episode_steps=9)
    pool = draw_pool(jax.random.key(0), 16, SHIP, PAPER)
    actor = make_actor("sum", ActorSizes((4,), (4,)), jax.random.key(1))

    @jax.jit
    def go(all_worlds, replay, key):
        cut = cut_short(replay.written, worlds, settings.episode_steps)
        after, row = tick(
            all_worlds, actor, pool, jnp.zeros(()), cut, key, SHIP, settings, NoiseSettings()
        )
        return after, write(replay, row), row

    all_worlds, replay = first_worlds(pool, worlds), empty_replay(ring, worlds, 6)
    shown, rows = [], []
    for number in range(2 * ring + 5):
        shown.append(all_worlds.state.observation)
        all_worlds, replay, row = go(all_worlds, replay, jax.random.key(100 + number))
        rows.append(row)
    return replay, shown, rows


def test_stacks_are_the_worlds_own_observations_bit_for_bit(sailed):
    replay, shown, rows = sailed
    low, high = (int(x) for x in drawable(replay))
    assert high - low == replay.ticks - 5
    starts, ends = 0, 0
    for number in range(low, high):
        batch = gather(replay, jnp.full(4, number), jnp.arange(4))
        transition = np.asarray(rows[number].transition)
        np.testing.assert_array_equal(batch.weight, transition)
        np.testing.assert_array_equal(batch.observation.waypoint, shown[number].waypoint)
        np.testing.assert_array_equal(batch.observation.targets, shown[number].targets)
        np.testing.assert_array_equal(batch.observation.present, shown[number].present)
        following = shown[number + 1]
        np.testing.assert_array_equal(
            batch.following.waypoint[transition], following.waypoint[transition]
        )
        np.testing.assert_array_equal(
            batch.following.targets[transition], following.targets[transition]
        )
        np.testing.assert_array_equal(batch.action, rows[number].action)
        np.testing.assert_array_equal(batch.next_action, rows[number + 1].action)
        np.testing.assert_array_equal(batch.reward.by_ship, rows[number].rewards[:, 1:])
        starts += int((np.asarray(rows[number].age) == 0).sum())
        ends += int((~transition).sum())
    assert starts >= 4
    assert ends >= 4


def test_episodes_end_at_different_ticks_and_take_their_full_length(sailed):
    _, _, rows = sailed
    ends = np.array([~np.asarray(row.transition) for row in rows])  # [tick, world]
    assert ends.any(0).all()
    assert ends.sum(1).max() <= 2
    for world in range(4):
        ticks = np.flatnonzero(ends[:, world])
        assert (np.diff(ticks) == 10).all()  # nine steps and the last frame's own row


def test_no_draw_reaches_what_the_write_head_has_overwritten():
    ring, worlds = 12, 2
    replay = empty_replay(ring, worlds, 1)
    for number in range(ring + 7):
        stamp = jnp.full((worlds, 13), float(number))
        replay = write(
            replay,
            Row(
                stamp,
                stamp[:, 0],
                stamp[:, :2],
                jnp.ones((worlds, 1), jnp.uint8),
                jnp.full(worlds, number, jnp.int16),  # one endless episode
                jnp.ones(worlds, bool),
                jnp.zeros(worlds, bool),
            ),
        )
    batch = sample(replay, 2000, jax.random.key(0))
    now = batch.action
    np.testing.assert_array_equal(
        batch.observation.waypoint[..., 0], now[:, None] - jnp.arange(5.0)[None, :]
    )
    np.testing.assert_array_equal(
        batch.following.waypoint[..., 0], now[:, None] + 1 - jnp.arange(5.0)[None, :]
    )
    low, high = drawable(replay)
    assert set(np.asarray(now).astype(int)) == set(range(int(low), int(high)))
    beyond = gather(replay, low[None] - 1, jnp.zeros(1, int))  # one more would be wrong
    assert float(beyond.observation.waypoint[0, 4, 0]) != float(low) - 5
