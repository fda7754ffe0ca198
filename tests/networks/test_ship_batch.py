import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.networks.scenes import COUNTS, CRITIC, KEY, SIZES, SLOTS, actions, of_counts

from glasshelm.networks.actors import make_actor
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.networks.ship_batch import Packed, Padded

SHIPS = sum(COUNTS)
PAIRS = sum(n * n for n in COUNTS)
BATCHES = (COUNTS, (0, 0, 0))


def packed(present, spare: int = 0) -> Packed:
    ships = int(present.sum())
    pairs = int((present.sum(-1) ** 2).sum())
    return Packed(present, max(ships, 1) + spare, max(pairs, 1) + spare)


def same(a, b):
    for x, y in zip(jax.tree.leaves(a), jax.tree.leaves(b), strict=True):
        np.testing.assert_allclose(x, y, rtol=1e-4, atol=2e-5)


@pytest.mark.slow
@pytest.mark.parametrize("spare", [0, 5])
@pytest.mark.parametrize("counts", BATCHES)
@pytest.mark.parametrize("kind", ["sum", "attention"])
def test_packed_actor_and_its_gradient_are_the_padded_ones(kind, counts, spare):
    actor = make_actor(kind, dataclasses.replace(SIZES, lens="fine"), KEY)
    observation = of_counts(counts)
    wanted = jnp.linspace(-1.0, 1.0, len(counts))

    @eqx.filter_jit
    @eqx.filter_value_and_grad(has_aux=True)
    def loss(actor, fleet):
        rudder = actor(observation, fleet)
        return jnp.sum((rudder - wanted) ** 2), rudder

    same(loss(actor, packed(observation.present, spare)), loss(actor, Padded(observation.present)))


@pytest.mark.parametrize("spare", [0, 5])
@pytest.mark.parametrize("counts", BATCHES)
def test_packed_critic_and_its_gradients_are_the_padded_ones(counts, spare):
    critic = SubTaskCritic(CRITIC, KEY)
    observation, rudder = of_counts(counts), actions(len(counts))

    @eqx.filter_jit
    @eqx.filter_value_and_grad(has_aux=True)
    def loss(inputs, fleet):
        critic, rudder = inputs
        values = critic(observation, rudder, fleet)
        return jnp.sum((values.total - 1.0) ** 2) + jnp.sum(values.by_ship**2), values

    inputs = critic, rudder
    same(
        loss(inputs, packed(observation.present, spare)), loss(inputs, Padded(observation.present))
    )


def test_gradient_reaches_the_actions_of_worlds_with_ships():
    critic, observation = SubTaskCritic(CRITIC, KEY), of_counts()
    slope = jax.grad(lambda a: critic(observation, a, packed(observation.present)).collision.sum())(
        actions(len(COUNTS))
    )
    assert (np.asarray(slope != 0) == (np.asarray(COUNTS) > 0)).all()


def test_whole_tells_the_worlds_that_fit():
    present = of_counts().present  # 0, 3, 1, 4, 2, 0 ships
    assert Packed(present, SHIPS).complete.tolist() == [True] * 6
    assert Packed(present, SHIPS - 1).complete.tolist() == [True] * 4 + [False, True]
    assert Packed(present, 4).complete.tolist() == [True] * 3 + [False, False, True]
    # 0, 9, 1, 16, 4, 0 pairs: room for all ships, but not for all pairs
    assert Packed(present, SHIPS, PAIRS).complete.tolist() == [True] * 6
    assert Packed(present, SHIPS, 12).complete.tolist() == [True] * 3 + [False, False, True]


def test_worlds_that_fit_are_right_although_others_do_not():
    actor, critic = make_actor("attention", SIZES, KEY), SubTaskCritic(CRITIC, KEY)
    observation, rudder = of_counts(), actions(len(COUNTS))
    fleet = Packed(observation.present, SHIPS - 3, PAIRS - 5)
    whole = np.asarray(fleet.complete)
    assert 0 < whole.sum() < len(COUNTS)
    np.testing.assert_allclose(
        actor(observation, fleet)[whole], actor(observation)[whole], rtol=1e-4, atol=1e-6
    )
    np.testing.assert_allclose(
        critic(observation, rudder, fleet).total[whole],
        critic(observation, rudder).total[whole],
        rtol=1e-4,
        atol=1e-5,
    )


@pytest.mark.parametrize("make", [Padded, packed])
def test_verbs_do_what_they_say(make):
    present = of_counts().present
    fleet = make(present)
    draw = np.random.default_rng(1)
    u, v = (draw.normal(size=(len(COUNTS), SLOTS, 2)).astype(np.float32) for _ in "uv")
    here = np.asarray(present)
    rows = fleet.to_rows(jnp.asarray(u))

    total = np.where(here[..., None], u, 0).sum(1)
    np.testing.assert_allclose(fleet.sum_ships(rows), total, atol=1e-5)
    np.testing.assert_allclose(fleet.to_slots(rows[..., 0]), np.where(here, u[..., 0], 0))

    spread = fleet.to_slots(fleet.broadcast(jnp.asarray(u[:, 0]))[..., 0] + 0 * rows[..., 0])
    np.testing.assert_allclose(spread, np.where(here, u[:, :1, 0], 0))

    weight = np.where(here, np.exp(u[..., 0]), 0)
    share = weight / np.maximum(weight.sum(-1, keepdims=True), 1e-30)
    np.testing.assert_allclose(fleet.to_slots(fleet.softmax(rows[..., 0])), share, atol=1e-6)

    pairs = fleet.pairs(rows, fleet.to_rows(jnp.asarray(v)))
    both = (u[:, :, None] + v[:, None])[..., 1] ** 2
    expected = np.where(here, np.where(here[:, None], both, 0).sum(-1), 0)
    found = fleet.to_slots(fleet.sum_pairs(pairs[..., 1] ** 2))
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_softmax_of_large_scores_does_not_overflow():
    fleet = Padded(jnp.array([[True, True, False]]))
    np.testing.assert_allclose(fleet.softmax(jnp.float32([[900.0, 900.0, 5e4]])), [[0.5, 0.5, 0]])
