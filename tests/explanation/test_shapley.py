"""Shapley values per ship: the axioms, the definition, and an independent library."""

import itertools
import json
from math import factorial
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.untrained import observation, untrained

from glasshelm.core.errors import InputError
from glasshelm.explanation.coalitions import coalitions, exact_from_worths
from glasshelm.explanation.quantities import values_at
from glasshelm.explanation.shapley import (
    exact_shapley,
    sampled_shapley,
    shapley_by_ship,
    value_function,
)

ORACLE = Path(__file__).parent / "shapiq.json"
LIMIT = 0.087


def test_a_hand_solved_game():
    """A glove game: players 0 and 1 hold left gloves, 2 a right one; a pair is worth 1."""
    inside = coalitions(3)
    worth = jnp.asarray((inside[:, 2] & (inside[:, 0] | inside[:, 1])).astype(np.float32))
    found = exact_from_worths(worth)
    np.testing.assert_allclose(found.by_ship, [1 / 6, 1 / 6, 4 / 6], atol=1e-6)
    # Left gloves replace each other; each completes a pair with the right one half of the time.
    expected = np.array([[0, -0.5, 0.5], [-0.5, 0, 0.5], [0.5, 0.5, 0]])
    np.testing.assert_allclose(found.pairs, expected, atol=1e-6)


@pytest.mark.parametrize("players", [1, 2, 3, 5])
def test_shares_are_means_over_all_orders_of_joining(players):
    worth = np.random.default_rng(players).normal(size=2**players)
    expected = np.zeros(players)
    for order in itertools.permutations(range(players)):
        joined = 0
        for player in order:
            expected[player] += worth[joined | 1 << player] - worth[joined]
            joined |= 1 << player
    expected /= factorial(players)
    found = exact_from_worths(jnp.asarray(worth, jnp.float32))
    np.testing.assert_allclose(found.by_ship, expected, atol=1e-5)
    assert float(found.by_ship.sum()) == pytest.approx(worth[-1] - worth[0], abs=1e-5)


@pytest.mark.parametrize("case", json.loads(ORACLE.read_text())["games"], ids=lambda c: c["name"])
def test_the_same_as_shapiq(case):
    found = exact_from_worths(jnp.asarray(case["worth"], jnp.float32))
    np.testing.assert_allclose(found.by_ship, case["by_player"], atol=1e-5)
    np.testing.assert_allclose(found.pairs, case["pairs"], atol=1e-5)


@pytest.mark.parametrize("kind", ["sum", "attention"])
@pytest.mark.parametrize("ships", [0, 1, 4])
def test_the_rudder_is_the_rudder_without_ships_and_what_each_adds(kind, ships):
    pilot, seen = untrained(kind), observation(ships)
    found = shapley_by_ship("rudder", pilot.actor, pilot.critic, seen, LIMIT)
    assert float(found.all) == pytest.approx(float(pilot.actor(seen)) * LIMIT, abs=1e-7)
    alone = float(found.none + found.by_ship.sum())
    assert alone == pytest.approx(float(found.all), abs=1e-6)


def test_of_an_additive_critic_the_share_is_the_priority():
    pilot, seen = untrained("sum"), observation(5)
    action = pilot.actor(seen)
    values = values_at(pilot.critic, seen, jnp.stack([action, jnp.zeros(())]))
    found = shapley_by_ship("contrast", pilot.actor, pilot.critic, seen, LIMIT)
    np.testing.assert_allclose(found.by_ship, values.by_ship[0] - values.by_ship[1], atol=1e-5)
    np.testing.assert_allclose(found.pairs, 0.0, atol=1e-5)


def test_who_is_not_there_has_no_share_and_changes_none():
    pilot, seen = untrained(), observation(4)
    gone = seen.present.at[2].set(False)
    found = shapley_by_ship(
        "decision", pilot.actor, pilot.critic, eqx.tree_at(lambda o: o.present, seen, gone), LIMIT
    )
    assert float(found.by_ship[2]) == 0.0
    assert np.all(np.asarray(found.by_ship)[[0, 1, 3]] != 0.0)
    assert float(found.none + found.by_ship.sum()) == pytest.approx(float(found.all), abs=1e-5)


def test_ships_in_another_order_have_the_same_shares():
    pilot, seen = untrained(), observation(4)
    turned = jax.tree.map(lambda x: x[::-1], (seen.targets, seen.present))
    other = eqx.tree_at(lambda o: (o.targets, o.present), seen, turned)
    one = shapley_by_ship("decision", pilot.actor, pilot.critic, seen, LIMIT)
    two = shapley_by_ship("decision", pilot.actor, pilot.critic, other, LIMIT)
    np.testing.assert_allclose(one.by_ship, two.by_ship[::-1], atol=1e-6)
    np.testing.assert_allclose(one.pairs, two.pairs[::-1, ::-1], atol=1e-6)


@pytest.mark.slow
def test_samples_lie_within_their_error_of_the_exact_shares_and_add_up():
    pilot, seen = untrained(), observation(6)
    worth = value_function("rudder", pilot.actor, None, seen, LIMIT)
    exact = exact_shapley(worth, 6)
    found = sampled_shapley(worth, 6, 3, 200)
    gap = np.abs(np.asarray(found.by_ship - exact.by_ship))
    assert np.all(gap <= 4 * np.asarray(found.error) + 1e-7)
    assert np.all(np.asarray(found.error) > 0)
    assert float(found.by_ship.sum()) == pytest.approx(float(exact.all - exact.none), abs=1e-5)


def test_many_ships_are_sampled_and_say_so():
    pilot, seen = untrained("sum"), observation(14)
    found = shapley_by_ship("rudder", pilot.actor, None, seen, LIMIT)
    assert np.all(np.asarray(found.error) > 0)
    assert float(found.none + found.by_ship.sum()) == pytest.approx(float(found.all), abs=1e-5)


def test_without_a_critic_only_the_rudder_can_be_shared_out():
    pilot = untrained(critic=False)
    with pytest.raises(InputError, match="needs a critic"):
        shapley_by_ship("decision", pilot.actor, None, observation(2), LIMIT)
