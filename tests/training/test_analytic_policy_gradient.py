import dataclasses
import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.core.geometry import Vector
from glasshelm.encounters.random_encounters import PAPER, RandomEncounters
from glasshelm.networks.actors import ActorSizes, make_actor
from glasshelm.ship.nomoto import SHIPS
from glasshelm.training.analytic_policy_gradient import (
    AnalyticSettings,
    draw_batch,
    policy_gradient,
    sail,
    ship_at,
    smooth_reward,
    voyage_return,
)

SHIP = SHIPS["paper"]
#: Ships that meet own ship within three minutes, from just outside her domain.
NEAR = RandomEncounters(
    time_to_collision_s=(150.0, 300.0),
    position_noise_m=200.0,
    targets=(0, 2),
    nearest_spawn_loa=2.0,
    spawn_danger=-0.1,
)
SETTINGS = AnalyticSettings(
    worlds_by_count=(1, 2, 2), encounters=NEAR, beside=(), decisions=8, rudder_pull=0.0
)


@functools.cache
def small_actor():
    sizes = ActorSizes(encoder=(16, 12), head=(12,), attention=(8,), lens="fine")
    return make_actor("attention", sizes, jax.random.key(2))


@functools.cache
def worlds():
    with jax.ensure_compile_time_eval():
        return jax.jit(lambda: draw_batch(jax.random.key(5), SHIP, SETTINGS))()


@eqx.filter_jit
def returns_of(actor, batch):
    return sail(actor, batch, SHIP, SETTINGS)[1].returns


@eqx.filter_jit
def open_loop(actions, batch):
    return jax.vmap(lambda e, a: voyage_return(e, a, SHIP, SETTINGS))(batch, actions)


@eqx.filter_jit
def rudders_of(actor, observation):
    return actor(observation)


@eqx.filter_jit
def moved(actor, direction, length):
    return jax.tree.map(lambda a, d: a + length * d if eqx.is_array(a) else a, actor, direction)


def inner(a, b) -> float:
    return sum(float(jnp.vdot(x, y)) for x, y in zip(arrays(a), arrays(b), strict=True))


def arrays(tree):
    return jax.tree.leaves(eqx.filter(tree, eqx.is_array))


def some_direction(seed: int):
    keys = iter(jax.random.split(jax.random.key(seed), 100))
    return jax.tree.map(
        lambda x: jax.random.normal(next(keys), x.shape) if eqx.is_array(x) else x, small_actor()
    )


def test_batch_holds_the_numbers_of_ships_asked_for():
    assert worlds().present.sum(-1).tolist() == [0, 1, 1, 2, 2]
    assert (SETTINGS.worlds, SETTINGS.ships, SETTINGS.pairs) == (5, 6, 10)


def test_smooth_reward_pays_for_the_course_and_charges_for_danger():
    far, near = jnp.float32([-5.0, -5.0]), jnp.float32([-5.0, 0.3])
    ahead = jnp.float32(0.0)
    assert float(smooth_reward(ahead, far, SETTINGS)) == pytest.approx(0.2, abs=1e-4)
    charge = smooth_reward(ahead, far, SETTINGS) - smooth_reward(ahead, near, SETTINGS)
    # well inside, softplus is the danger itself plus the margin
    expected = SETTINGS.danger_weight * (0.3 + SETTINGS.danger_margin)
    assert float(charge) == pytest.approx(expected, rel=1e-3)


def test_closed_loop_return_is_the_open_loop_return_of_the_same_commands():
    log, voyages = eqx.filter_jit(sail)(small_actor(), worlds(), SHIP, SETTINGS)
    actions = log.actions.T
    assert actions.shape == (5, 8)
    np.testing.assert_allclose(open_loop(actions, worlds()), voyages.returns, rtol=1e-3, atol=1e-3)
    assert (np.asarray(voyages.worst[1:]) > -0.2).any()  # the batch is not all open sea
    assert float(voyages.worst[0]) < -100  # nobody there


def test_open_loop_follows_a_route_of_several_waypoints():
    # The second waypoint lies abeam of the first: whoever steers for it is paid otherwise.
    near, abeam = jnp.float32([0.0, 9000.0]), jnp.float32([700.0, 700.0])
    routes = Vector(jnp.tile(near, (5, 1)), jnp.tile(abeam, (5, 1)))
    batch = eqx.tree_at(lambda b: b.route, worlds(), routes)
    settings = dataclasses.replace(SETTINGS, decisions=20)
    log, voyages = eqx.filter_jit(sail)(small_actor(), batch, SHIP, settings)
    returns = jax.jit(jax.vmap(lambda e, a: voyage_return(e, a, SHIP, settings)))
    np.testing.assert_allclose(returns(batch, log.actions.T), voyages.returns, rtol=1e-3, atol=1e-3)
    first = Vector(routes.x[:, :1], routes.y[:, :1])
    only_first = returns(eqx.tree_at(lambda b: b.route, batch, first), log.actions.T)
    assert float(jnp.abs(only_first - voyages.returns).min()) > 0.1


def test_gradient_without_feedback_is_the_finite_difference_of_the_commands():
    log, _ = eqx.filter_jit(sail)(small_actor(), worlds(), SHIP, SETTINGS)
    observation, actions = log.observation, log.actions.T
    # How every return answers to every single command, by central differences.
    step = 0.01
    adjoint = np.zeros(actions.shape)
    for t in range(actions.shape[1]):
        up = open_loop(actions.at[:, t].add(step), worlds())
        down = open_loop(actions.at[:, t].add(-step), worlds())
        adjoint[:, t] = np.asarray(up - down, np.float64) / (2 * step)
    exact = jax.jit(jax.grad(lambda a: open_loop(a, worlds()).sum()))(actions)
    np.testing.assert_allclose(exact, adjoint, atol=0.03 * np.abs(adjoint).max())
    assert np.abs(adjoint).max() > 0.1
    # Scaled voyage by voyage, and carried to the actor along some direction.
    length = np.linalg.norm(adjoint, axis=-1, keepdims=True)
    weight = adjoint / (length + SETTINGS.adjoint_scale)
    gradient, _ = eqx.filter_jit(policy_gradient)(small_actor(), worlds(), SHIP, SETTINGS)
    answers, slopes = [], []
    for seed in range(3):
        direction, small = some_direction(seed), 1e-3
        answer = [
            np.asarray(rudders_of(moved(small_actor(), direction, s), observation))
            for s in (small, -small)
        ]
        slope = (answer[0] - answer[1]).T / (2 * small)  # [w, t]
        answers.append(-(weight * slope).mean(0).sum())
        slopes.append(inner(gradient, direction))
    np.testing.assert_allclose(slopes, answers, rtol=0.05, atol=0.02 * np.abs(answers).max())


def test_gradient_with_feedback_is_the_finite_difference_of_the_mean_return():
    settings = dataclasses.replace(SETTINGS, feedback=True)
    gradient, _ = eqx.filter_jit(policy_gradient)(small_actor(), worlds(), SHIP, settings)
    slopes, answers = [], []
    for seed in range(3):
        direction, small = some_direction(seed), 2e-3
        up = returns_of(moved(small_actor(), direction, small), worlds()).mean()
        down = returns_of(moved(small_actor(), direction, -small), worlds()).mean()
        answers.append(-float(up - down) / (2 * small))
        slopes.append(inner(gradient, direction))
    np.testing.assert_allclose(slopes, answers, rtol=0.05, atol=0.03 * np.abs(answers).max())


@pytest.mark.parametrize("feedback", [False, True])
def test_one_step_along_the_gradient_raises_the_return(feedback):
    settings = dataclasses.replace(SETTINGS, feedback=feedback)
    gradient, voyages = eqx.filter_jit(policy_gradient)(small_actor(), worlds(), SHIP, settings)
    size = inner(gradient, gradient) ** 0.5
    better = returns_of(moved(small_actor(), gradient, -0.01 / size), worlds()).mean()
    worse = returns_of(moved(small_actor(), gradient, 0.01 / size), worlds()).mean()
    middle = float(voyages.returns.mean())
    assert float(better) > middle + 1e-3
    assert float(worse) < middle - 1e-3


def test_the_ship_changes_gradually_into_the_one_trained_for():
    large, paper = SHIPS["large_ship"], SHIPS["paper"]
    settings = dataclasses.replace(SETTINGS, from_ship="paper", blend=(10, 30))
    before, middle, after = (ship_at(jnp.int32(i), large, settings) for i in (0, 20, 99))
    assert float(before.gain_1_s) == pytest.approx(paper.gain_1_s)
    assert float(before.time_constant_s) == pytest.approx(paper.time_constant_s)
    assert float(middle.time_constant_s) == pytest.approx((11.10 * 141.0) ** 0.5)
    assert float(after.gain_1_s) == pytest.approx(large.gain_1_s)
    assert before.rudder_rate_rad_s == large.rudder_rate_rad_s
    assert ship_at(jnp.int32(0), large, SETTINGS) is large


def test_rudder_pull_asks_for_less_rudder():
    plain, _ = eqx.filter_jit(policy_gradient)(small_actor(), worlds(), SHIP, SETTINGS)
    settings = dataclasses.replace(SETTINGS, rudder_pull=0.5)
    pulled, _ = eqx.filter_jit(policy_gradient)(small_actor(), worlds(), SHIP, settings)
    observation = eqx.filter_jit(sail)(small_actor(), worlds(), SHIP, SETTINGS)[0].observation

    def rudder(actor):
        return float((rudders_of(actor, observation) ** 2).mean())

    extra = jax.tree.map(jnp.subtract, pulled, plain)
    small = 0.01 / inner(extra, extra) ** 0.5
    less, more = (moved(small_actor(), extra, s) for s in (-small, small))
    assert rudder(less) < rudder(small_actor()) < rudder(more)


def test_worlds_begin_in_turn_as_the_settings_say():
    near = dataclasses.replace(PAPER, waypoint_m=(9_000.0, 9_000.0))
    settings = AnalyticSettings(worlds_by_count=(4, 4, 4), beside=(PAPER, near, PAPER))
    batch = draw_batch(jax.random.key(0), SHIP, settings)
    np.testing.assert_array_equal(batch.present.sum(-1), np.repeat([0, 1, 2], 4))
    far = np.isclose(batch.route.y[:, 0], 46_300.0)
    np.testing.assert_array_equal(far, np.arange(12) % 2 == 1)
    np.testing.assert_array_equal(np.isclose(batch.route.y[:, 0], 9_000.0), np.arange(12) % 4 == 2)
