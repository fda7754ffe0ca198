from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.training.config import preset_named
from glasshelm.training.ddpg import (
    PackedSize,
    actor_optimiser,
    critic_optimiser,
    packed_size,
    update,
)
from glasshelm.training.init_actor import init_actor
from glasshelm.training.losses import ActorLossSettings
from glasshelm.training.replay_buffer import gather
from glasshelm.training.stages import DdpgStage

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def after_filling():
    """The tiny preset's state after filling and a few updates, and a batch of it."""
    config = preset_named("tiny")
    stage = DdpgStage(config)
    state = stage.start(init_actor(config))
    for number in range(25):
        state, _ = stage.advance(state, number)
    steps = jnp.arange(12)
    return state, gather(state.replay, steps, steps % 10)


SETTINGS = preset_named("tiny").ddpg
STEP = jax.jit(update, static_argnums=(2, 4, 5, 6))


def weights(network):
    return np.concatenate([np.ravel(x) for x in jax.tree.leaves(network)])


def test_no_update_before_the_replay_is_warm(after_filling):
    state, _ = after_filling
    assert int(state.critic_optimiser[0].count) == 25 - 20
    assert int(state.replay.written) == 25


def test_target_networks_follow_at_the_rate_tau(after_filling):
    state, batch = after_filling
    size = packed_size(12, (0, 6), False)
    new, _, _ = STEP(state, batch, size, jax.random.key(0), True, SETTINGS, "sum")
    expected = weights(state.target_critic) + 0.001 * (
        weights(new.critic) - weights(state.target_critic)
    )
    np.testing.assert_allclose(weights(new.target_critic), expected, atol=1e-7)
    assert not np.array_equal(weights(new.actor), weights(state.actor))


def test_policy_evaluation_leaves_the_actor_alone(after_filling):
    state, batch = after_filling
    size = packed_size(12, (0, 6), False)
    new, loss, _ = STEP(state, batch, size, jax.random.key(0), False, SETTINGS, "heads")
    np.testing.assert_array_equal(weights(new.actor), weights(state.actor))
    assert float(loss) > 0
    assert not np.array_equal(weights(new.critic), weights(state.critic))


def test_episodes_that_do_not_fit_the_rows_are_left_out(after_filling):
    state, batch = after_filling
    ships = np.asarray(batch.observation.present.sum(-1))
    assert ships[-1] > 0
    fits = int(ships[:-1].sum())
    short = STEP(state, batch, PackedSize(fits, None), jax.random.key(0), False, SETTINGS, "sum")
    without = eqx.tree_at(lambda b: b.weight, batch, batch.weight.at[-1].set(0.0))
    plenty = PackedSize(int(ships.sum()), None)
    full = STEP(state, without, plenty, jax.random.key(0), False, SETTINGS, "sum")
    assert float(short[1]) == pytest.approx(float(full[1]), rel=1e-5)
    everyone = STEP(state, batch, plenty, jax.random.key(0), False, SETTINGS, "sum")
    assert float(everyone[1]) != pytest.approx(float(full[1]), rel=1e-5)


def test_the_weights_of_the_actor_decay_by_lambda_reg_alone():
    """Where Q is flat, a weight shrinks by 2·λ_reg of itself times the learning rate, no more."""
    settings = replace(SETTINGS, actor_loss=ActorLossSettings(regularisation=0.25))
    weight = jnp.array([2.0, 0.01])
    adam = actor_optimiser(settings)
    change, _ = adam.update(jnp.zeros(2), adam.init(weight), weight)
    np.testing.assert_allclose(change, -settings.learning_rate * 2 * 0.25 * weight, rtol=1e-5)


def test_the_learning_rate_may_fall():
    falling = replace(SETTINGS, learning_rate_end=0.05)
    weight = jnp.ones(())

    def last_step(settings):
        adam = critic_optimiser(settings)
        state, step = adam.init(weight), weight
        for _ in range(settings.cycles):
            step, state = adam.update(weight, state)
        return float(step)

    assert last_step(SETTINGS) == pytest.approx(-0.001, rel=1e-3)
    assert last_step(falling) == pytest.approx(-0.00005, rel=0.02)
