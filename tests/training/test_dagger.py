import dataclasses
import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.encounters.random_encounters import PAPER, WIDE
from glasshelm.networks.actors import ActorSizes, make_actor
from glasshelm.planning.manoeuvres import ManoeuvreTable
from glasshelm.planning.simulated_critic import ManoeuvreCosts
from glasshelm.planning.situation import rudder_towards
from glasshelm.ship.nomoto import SHIPS
from glasshelm.training.dagger import (
    DaggerSettings,
    collect_labels,
    dagger_iteration,
    init_dagger,
)
from glasshelm.training.encounter_mix import EncounterMix

pytestmark = pytest.mark.slow

SHIP = SHIPS["large_ship"]
SETTINGS = DaggerSettings(
    # An expert with few manoeuvres: a small actor can learn them in seconds.
    ManoeuvreTable((-60.0, -30.0, 30.0, 60.0), (400.0, 900.0), (), (), keep_s=()),
    ManoeuvreCosts(horizon_s=1800.0, alter_cost=0.0),
    EncounterMix((1, 2, 2, 1)),
    segments=6,
    iterations=20,
    updates=100,
    dataset_iterations=2,
    batch_decisions=4,
    average_rate=0.02,
)


@functools.cache
def student():
    sizes = ActorSizes((24, 16), (16,), (8,), "fine")
    with jax.ensure_compile_time_eval():
        return jax.jit(lambda: make_actor("sum", sizes, jax.random.key(2)))()


@functools.cache
def worlds():
    with jax.ensure_compile_time_eval():
        return jax.jit(lambda: SETTINGS.mix.draw(jax.random.key(5), SHIP))()


@functools.cache
def fleet():
    with jax.ensure_compile_time_eval():
        return SETTINGS.packed(worlds())


@eqx.filter_jit
def labels_of(actor_share):
    return collect_labels(student(), worlds(), actor_share, jax.random.key(1), SHIP, SETTINGS)


def test_with_beta_1_the_expert_steers_its_own_labels():
    labels = labels_of(jnp.zeros(()))
    assert labels.rudder.shape == (24, 6)
    # The first command of a segment is the one that its course asks for: visible one step on.
    turned = labels.observation.waypoint[4, :, 0, 2] - labels.observation.waypoint[0, :, 0, 2]
    steered = labels.rudder[:4].sum(0)
    moved = jnp.abs(turned) > 1e-3
    assert moved.any()
    np.testing.assert_array_less(0.0, (-turned * steered)[moved])


def test_with_beta_0_the_actor_steers_but_the_expert_labels():
    expert, actor = labels_of(jnp.zeros(())), labels_of(jnp.ones(()))
    np.testing.assert_allclose(expert.rudder[0], actor.rudder[0])
    assert not np.allclose(expert.observation.waypoint[-1], actor.observation.waypoint[-1])
    straight = jax.vmap(lambda s: rudder_towards(jnp.zeros(()), s, SHIP))(
        jax.tree.map(lambda x: x[-1], actor.observation)
    )
    empty = ~worlds().present.any(-1)  # no targets: the expert steers for the waypoint
    np.testing.assert_allclose(actor.rudder[-1][empty], straight[empty], atol=1e-6)


def test_weights_are_larger_where_more_is_at_stake():
    weight = labels_of(jnp.zeros(())).weight[0]
    assert float(weight.min()) >= 0.1
    assert float(weight.max()) <= 1.0
    crowded = worlds().present.sum(-1)
    assert float(weight[crowded == 0].max()) < float(weight[crowded > 0].max())


@pytest.fixture(scope="module")
def learned():
    run = eqx.filter_jit(lambda state, key: dagger_iteration(state, key, SHIP, SETTINGS))
    state, losses = init_dagger(student(), SETTINGS), []
    for number in range(6):
        state, loss = run(state, jax.random.fold_in(jax.random.key(3), number))
        losses.append(float(loss))
    return state, losses


def test_the_actor_learns_to_steer_like_the_expert(learned):
    state, losses = learned
    labels = jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), state.dataset)

    @eqx.filter_jit
    def loss_of(actor):
        rudders = jax.vmap(lambda observation: actor(observation, fleet()))(labels.observation)
        return jnp.mean(labels.weight * (rudders - labels.rudder) ** 2)

    assert float(loss_of(state.average)) < 0.5 * float(loss_of(student()))
    assert all(np.isfinite(losses))
    assert int(state.iteration) == 6


def test_the_oldest_labels_are_replaced(learned):
    state, _ = learned
    assert state.dataset.rudder.shape == (2, 24, 6)
    assert not np.allclose(state.dataset.rudder[0], state.dataset.rudder[1])
    assert np.all(np.abs(np.asarray(state.dataset.rudder)) <= 1.0)


def test_a_batch_has_the_numbers_of_targets_asked_for_from_the_distributions_in_turn():
    near = dataclasses.replace(PAPER, waypoint_m=(9_000.0, 9_000.0))
    mix = EncounterMix((4, 4, 4), (WIDE, PAPER, near, PAPER))
    assert (mix.size, mix.total_targets, mix.total_pairs) == (12, 12, 20)
    batch = mix.draw(jax.random.key(0), SHIP)
    np.testing.assert_array_equal(batch.present.sum(-1), np.repeat([0, 1, 2], 4))
    far = np.isclose(batch.route.y[:, 0], 46_300.0)
    np.testing.assert_array_equal(far, np.arange(12) % 2 == 1)
    np.testing.assert_array_equal(np.isclose(batch.route.y[:, 0], 9_000.0), np.arange(12) % 4 == 2)
