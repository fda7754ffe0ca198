import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.untrained import observation, untrained

import glasshelm
from glasshelm.env.observe import DISTANCE_M, SPEED_M_S, TIME_S, Observation
from glasshelm.env.padding import bucket_size, pad_observation
from glasshelm.explanation.actor_explanation import explain_rudder
from glasshelm.explanation.danger_zero import RANGE_M, far_ship, far_value
from glasshelm.explanation.shapley import (
    MAX_PADDED_EXACT,
    exact_shapley,
    shapley_by_ship,
    value_function,
)
from glasshelm.pilots.decide import Selection, _in_slots

CLOSE = {"rtol": 1e-5, "atol": 1e-5}
jitted = eqx.filter_jit(explain_rudder)
critic_at = eqx.filter_jit(lambda critic, seen, action: critic(seen, action))


def at(kind: str, seen: Observation, action: float = 0.3):
    pilot = untrained(kind)
    return jitted(pilot.actor, pilot.critic, seen, jnp.asarray(action, jnp.float32))


def permuted(seen: Observation, order: np.ndarray) -> Observation:
    return Observation(seen.waypoint, seen.targets[order], seen.present[order])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "ships"), [("attention", n) for n in (0, 1, 4, 40)] + [("sum", 4)]
)
def test_parts_sum_to_the_critics_own_total(kind, ships):
    seen = observation(ships)
    why = at(kind, seen)
    total = critic_at(untrained(kind).critic, seen, jnp.asarray(0.3)).total
    np.testing.assert_allclose(why.value.waypoint + why.value.by_ship.sum(), total, **CLOSE)
    np.testing.assert_allclose(why.value.total, total, **CLOSE)


@given(action=st.floats(-1, 1, width=32), seed=st.integers(0, 5))
def test_priority_is_the_gain_over_rudder_amidships(action, seed):
    seen = observation(4, seed)
    critic = untrained("sum").critic
    why = at("sum", seen, action)
    there, straight = (critic_at(critic, seen, jnp.asarray(a, jnp.float32)) for a in (action, 0.0))
    np.testing.assert_allclose(why.priority.by_ship, there.by_ship - straight.by_ship, **CLOSE)
    np.testing.assert_allclose(why.priority.total, there.total - straight.total, **CLOSE)


def test_priority_of_rudder_amidships_is_zero():
    why = at("attention", observation(4), 0.0)
    np.testing.assert_allclose(why.priority.waypoint, 0.0, atol=1e-6)
    np.testing.assert_allclose(why.priority.by_ship, 0.0, atol=1e-6)
    np.testing.assert_allclose(why.intention.increment, 0.0, atol=1e-6)
    assert np.abs(why.intention.level).max() > 1e-3


@pytest.mark.parametrize("kind", ["sum", "attention"])
def test_order_of_ships_changes_nothing(kind):
    seen, order = observation(4), np.array([3, 0, 1, 2])
    why, other = at(kind, seen), at(kind, permuted(seen, order))
    np.testing.assert_allclose(other.value.by_ship, why.value.by_ship[order], **CLOSE)
    np.testing.assert_allclose(other.priority.by_ship, why.priority.by_ship[order], **CLOSE)
    np.testing.assert_allclose(
        other.sweep.value.by_ship, why.sweep.value.by_ship[:, order], **CLOSE
    )
    if kind == "attention":
        np.testing.assert_allclose(other.attention, why.attention[order], **CLOSE)
        np.testing.assert_allclose(
            other.intention.increment, why.intention.increment[order], **CLOSE
        )


@pytest.mark.parametrize(
    ("kind", "ships", "slots"),
    [("attention", 0, 4), ("attention", 1, 4), ("attention", 4, 40), ("sum", 1, 4)],
)
def test_padding_changes_nothing(kind, ships, slots):
    seen = observation(ships)
    padded = jax.tree.map(jnp.asarray, pad_observation(seen, slots))
    wide, everyone = at(kind, padded), jax.device_get(Selection(padded, jnp.arange(slots)))
    assert not wide.present[ships:].any()
    assert not wide.value.by_ship[ships:].any()
    bare, trimmed = at(kind, seen), _in_slots(wide, everyone, ships)
    assert jax.tree.structure(bare) == jax.tree.structure(trimmed)
    for a, b in zip(jax.tree.leaves(bare), jax.tree.leaves(trimmed), strict=True):
        np.testing.assert_allclose(a, b, **CLOSE)


@pytest.mark.parametrize("ships", [1, 2, 7, 40])
def test_attention_is_shared_out_whole(ships):
    why = at("attention", jax.tree.map(jnp.asarray, pad_observation(observation(ships), 40)))
    np.testing.assert_allclose(why.attention.sum(), 1.0, atol=1e-5)
    assert (why.attention >= 0).all()
    assert not why.attention[ships:].any()
    if ships == 1:
        assert why.attention[0] == 1.0


def test_intention_is_value_or_gain_times_attention():
    why = at("attention", observation(4))
    np.testing.assert_allclose(why.intention.level, why.value.by_ship * why.attention)
    np.testing.assert_allclose(why.intention.increment, why.priority.by_ship * why.attention)


@pytest.mark.slow
def test_what_a_pilot_lacks_is_absent():
    seen = observation(4)
    why = at("sum", seen)
    assert why.attention is None
    assert why.intention is None
    blind = untrained("attention", critic=False)
    why = explain_rudder(blind.actor, None, seen, jnp.asarray(0.1))
    assert why.value is why.priority is why.far is why.sweep is why.intention is None
    assert why.attention.shape == (4,)


def test_sweep_agrees_with_the_critic_rudder_by_rudder():
    seen = observation(4)
    why = at("sum", seen)
    assert why.sweep.action.shape == (21,)
    assert why.sweep.action[0] == -1
    assert why.sweep.action[-1] == 1
    assert np.abs(why.sweep.action).min() < 1e-7
    for k in (0, 4, 20):
        alone = untrained("sum").critic(seen, jnp.asarray(why.sweep.action[k]))
        np.testing.assert_allclose(why.sweep.value.by_ship[k], alone.by_ship, **CLOSE)
        np.testing.assert_allclose(why.sweep.value.waypoint[k], alone.waypoint, **CLOSE)


@pytest.mark.slow
def test_compiled_equals_eager():
    seen = observation(4)
    eager, _ = untrained("attention").decide(seen, ())
    compiled = glasshelm.explain(untrained("attention"), seen)
    for a, b in zip(jax.tree.leaves(eager), jax.tree.leaves(compiled), strict=True):
        np.testing.assert_allclose(a, b, **CLOSE)


def test_the_far_ship_is_far_and_opening():
    now = far_ship().targets[0, 0]
    assert now[5] * DISTANCE_M == pytest.approx(RANGE_M)
    assert now[4] * SPEED_M_S == pytest.approx(-20 * 1852 / 3600)  # ahead: she falls astern
    assert now[9] * TIME_S == pytest.approx(-RANGE_M / (20 * 1852 / 3600), rel=1e-4)
    ranges = far_ship().targets[0, :, 5] * DISTANCE_M
    np.testing.assert_allclose(-np.diff(ranges), 5 * 20 * 1852 / 3600, rtol=1e-2)


def test_far_value_is_the_collision_heads_own():
    critic = untrained("sum").critic
    action = jnp.asarray(0.4)
    expected = critic(far_ship(), action).by_ship[0]
    np.testing.assert_allclose(far_value(critic, action), expected)
    np.testing.assert_allclose(at("sum", observation(4), 0.4).far, expected, **CLOSE)


def test_slots_double():
    assert [bucket_size(n) for n in (0, 1, 2, 3, 4, 5, 8, 9, 40)] == [0, 1, 2, 4, 4, 8, 8, 16, 64]
    with pytest.raises(ValueError, match="do not fit"):
        pad_observation(observation(3), 2)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["sum", "attention"])
@pytest.mark.parametrize(("ships", "slots"), [(3, 4), (5, 8), (10, 16)])
def test_live_shares_are_the_exact_ones_whatever_the_slots(kind, ships, slots):
    seen = jax.tree.map(jnp.asarray, pad_observation(observation(ships), slots))
    pilot = untrained(kind)
    why = jax.jit(explain_rudder)(pilot.actor, pilot.critic, seen, pilot.actor(seen))
    exact = shapley_by_ship("rudder", pilot.actor, pilot.critic, observation(ships), 1.0)
    np.testing.assert_allclose(why.rudder_shapley.by_ship[:ships], exact.by_ship, atol=1e-5)
    np.testing.assert_allclose(why.rudder_shapley.pairs[:ships, :ships], exact.pairs, atol=1e-5)
    np.testing.assert_allclose(
        why.rudder_shapley.none + why.rudder_shapley.by_ship.sum(),
        why.rudder_shapley.all,
        atol=1e-5,
    )
    assert not np.any(why.rudder_shapley.error)
    assert np.isfinite(why.value_shapley.all) == (ships <= MAX_PADDED_EXACT)


@pytest.mark.slow
def test_beyond_twelve_ships_shares_are_sampled_and_say_how_well():
    pilot, seen = untrained("sum"), jax.tree.map(jnp.asarray, observation(14))
    why = jax.jit(explain_rudder)(pilot.actor, pilot.critic, seen, pilot.actor(seen))
    exact = exact_shapley(value_function("rudder", pilot.actor, None, seen, 1.0), 14)
    assert (why.rudder_shapley.error > 0).all()
    assert (
        np.abs(why.rudder_shapley.by_ship - exact.by_ship) < 5 * why.rudder_shapley.error + 1e-6
    ).all()
    np.testing.assert_allclose(
        why.rudder_shapley.none + why.rudder_shapley.by_ship.sum(),
        why.rudder_shapley.all,
        atol=1e-5,
    )


def test_what_one_ship_changes_is_the_rudder_without_her():
    pilot, seen = untrained("attention"), jax.tree.map(jnp.asarray, observation(4))
    why = explain_rudder(pilot.actor, pilot.critic, seen, pilot.actor(seen))
    for i in range(4):
        others = eqx.tree_at(lambda o: o.present, seen, seen.present.at[i].set(False))
        changed = pilot.actor(seen) - pilot.actor(others)
        np.testing.assert_allclose(why.leave_one_out[i], changed, atol=1e-6)
