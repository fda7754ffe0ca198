import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.networks.scenes import KEY, SIZES, observations, of_counts

from glasshelm.core.errors import InputError
from glasshelm.env.observe import Observation
from glasshelm.networks.actors import ActorSizes, AttentionActor, SumActor, make_actor
from glasshelm.networks.mlp import softsign

KINDS = ("sum", "attention")


def parameters(tree) -> int:
    return sum(x.size for x in jax.tree.leaves(eqx.filter(tree, eqx.is_array)))


def test_paper_sizes_are_tables_a3_to_a5():
    actor = eqx.filter_eval_shape(lambda: make_actor("sum", ActorSizes(), KEY))
    count = lambda mlp: sum(x.size for x in (*mlp.weights, *mlp.biases))  # noqa: E731
    # inputs × outputs + outputs: 5 frames of 3 → 256 → 256 → 128
    assert count(actor.encode_waypoint) == 15 * 256 + 256 + 256 * 256 + 256 + 256 * 128 + 128
    assert count(actor.encode_waypoint) == 102_784
    assert count(actor.encode_target) == 111_744  # 5 frames of 10 → 256 → 256 → 128
    assert count(actor.head) == 131_841  # 128 → 256 → 256 → 128 → 1
    attention = eqx.filter_eval_shape(lambda: make_actor("attention", ActorSizes(), KEY))
    assert count(attention.score) == 29_569  # 2 · 50 → 128 → 128 → 1


def test_parameters_are_all_in_those_layers():
    assert parameters(make_actor("sum", ActorSizes(), KEY)) == 102_784 + 111_744 + 131_841
    assert parameters(make_actor("attention", ActorSizes(), KEY)) == 346_369 + 29_569


@pytest.mark.parametrize("lens", ["flat", "fine"])
@pytest.mark.parametrize("kind", KINDS)
def test_order_of_the_ships_does_not_matter(kind, lens):
    actor = make_actor(kind, dataclasses.replace(SIZES, lens=lens), KEY)
    observation = of_counts()
    order = np.array([2, 0, 3, 1])
    shuffled = Observation(
        observation.waypoint, observation.targets[:, order], observation.present[:, order]
    )
    np.testing.assert_allclose(actor(observation), actor(shuffled), rtol=1e-4, atol=1e-6)
    if isinstance(actor, AttentionActor):
        np.testing.assert_allclose(
            actor.attention(observation)[:, order], actor.attention(shuffled), rtol=1e-4, atol=1e-6
        )


@pytest.mark.parametrize("kind", KINDS)
def test_empty_slots_do_not_matter(kind):
    actor = make_actor(kind, SIZES, KEY)
    alone = observations(np.ones((3, 2)))
    slots = jnp.full((3, 5, 5, 10), -3.0).at[:, np.array([1, 3])].set(alone.targets)
    present = jnp.zeros((3, 5), bool).at[:, np.array([1, 3])].set(True)
    padded = Observation(alone.waypoint, slots, present)
    np.testing.assert_allclose(actor(alone), actor(padded), rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_each_ship_and_the_waypoint_have_a_say(kind):
    actor = make_actor(kind, SIZES, KEY)
    observation = observations(np.ones((1, 3)))
    base = float(actor(observation)[0])
    for ship in range(3):
        other = eqx.tree_at(
            lambda s: s.targets, observation, observation.targets.at[0, ship].add(0.5)
        )
        assert abs(float(actor(other)[0]) - base) > 1e-5
    other = eqx.tree_at(lambda s: s.waypoint, observation, observation.waypoint + 0.5)
    assert abs(float(actor(other)[0]) - base) > 1e-5


@pytest.mark.parametrize("kind", KINDS)
def test_without_ships_the_traffic_feature_is_zero(kind):
    actor = make_actor(kind, SIZES, KEY)
    observation = observations(np.zeros((2, 3)))
    own = actor.encode_waypoint(observation.waypoint.reshape(2, 15))
    expected = softsign(actor.head(softsign(own)))[:, 0]
    np.testing.assert_allclose(actor(observation), expected, rtol=1e-5, atol=1e-6)
    no_slots = Observation(
        observation.waypoint, observation.targets[:, :0], observation.present[:, :0]
    )
    np.testing.assert_allclose(actor(no_slots), expected, rtol=1e-5, atol=1e-6)


def test_sum_actor_is_eq_20_and_21():
    actor = SumActor(SIZES, KEY)
    observation = observations(np.ones((1, 3)))
    feature = actor.encode_waypoint(observation.waypoint[0].reshape(15))
    for ship in range(3):
        feature = feature + actor.encode_target(observation.targets[0, ship].reshape(50))
    expected = softsign(actor.head(softsign(feature)))
    np.testing.assert_allclose(actor(observation)[0], expected[0], rtol=1e-4, atol=1e-6)


def test_attention_is_eq_23():
    actor = AttentionActor(SIZES, KEY)
    observation = observations(np.ones((1, 3)))
    s = observation.targets[0].reshape(3, 50)
    score = np.array(
        [sum(float(actor.score(jnp.concatenate([a, b]))[0]) for b in s) for a in s]
    )  # summed over j, j = i included
    alpha = np.exp(score - score.max())
    alpha /= alpha.sum()
    np.testing.assert_allclose(actor.attention(observation)[0], alpha, rtol=1e-3)
    own = actor.encode_waypoint(observation.waypoint[0].reshape(15))
    traffic = sum(w * actor.encode_target(row) for w, row in zip(alpha, s, strict=True))
    expected = softsign(actor.head(softsign(own + traffic)))
    np.testing.assert_allclose(actor(observation)[0], expected[0], rtol=1e-3, atol=1e-5)


def test_attention_sums_to_one_over_the_ships_present():
    alpha = np.asarray(AttentionActor(SIZES, KEY).attention(of_counts()))
    present = np.asarray(of_counts().present)
    assert not alpha[~present].any()
    assert (alpha[present] > 0).all()
    np.testing.assert_allclose(alpha.sum(-1), present.any(-1).astype(float), atol=1e-6)
    np.testing.assert_allclose(alpha[2].max(), 1.0)  # one ship: all of it


def test_rudder_stays_within_the_limits_and_reaches_near_them():
    actor = make_actor("sum", SIZES, KEY)
    observation = of_counts()
    loud = eqx.tree_at(lambda a: a.head.weights[-1], actor, actor.head.weights[-1] * 1e4)
    rudder = np.abs(np.asarray(loud(observation)))
    assert (rudder < 1).all()
    assert rudder.max() > 0.99


def test_unknown_actor_is_told():
    with pytest.raises(InputError, match="unknown actor 'max': choose sum or attention"):
        make_actor("max", SIZES, KEY)
