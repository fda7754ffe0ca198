"""The labels are what really happens, and what is learned of them is their mean."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.encounters.random_encounters import PAPER, random_encounters
from glasshelm.planning.learned_critic import LearnedCritic, ManoeuvreCriticSizes
from glasshelm.planning.manoeuvres import ManoeuvreTable
from glasshelm.planning.simulated_critic import ManoeuvreCosts, SimulatedCritic
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.disturbances import (
    DISTURBANCES,
    with_instruments,
    with_random_disturbances,
)
from glasshelm.simulation.rollout import plain_cases, reset_case
from glasshelm.training.manoeuvre_regression import cost_loss, true_costs

SHIP, COSTS = SHIPS["paper"], ManoeuvreCosts()
TABLE = ManoeuvreTable((-60.0, 30.0, 60.0), (400.0, 1000.0), (-40.0,), (250.0,))
CRITIC = SimulatedCritic(TABLE, COSTS)
COUNT = 6


def test_the_loss_is_least_at_the_logarithm_of_the_mean():
    """Nine in ten cost nothing, one costs 99: the mean of 1 + y is 10.9."""
    labels = jnp.log1p(jnp.array([0.0] * 9 + [99.0]))
    tried = jnp.linspace(-3.0, 6.0, 9001)
    losses = jax.vmap(lambda f: cost_loss(jnp.full(10, f), labels).mean())(tried)
    assert float(tried[jnp.argmin(losses)]) == pytest.approx(np.log(10.9), abs=2e-3)
    squares = float(labels.mean())  # where a squared error of the logarithm would be least
    assert np.exp(squares) < 2


def test_of_a_ship_that_costs_nothing_nothing_is_to_be_learned_below_zero():
    below, above, nothing = jnp.array(-0.5), jnp.array(0.5), jnp.zeros(())
    assert float(jax.grad(cost_loss)(below, nothing)) == 0.0
    assert float(cost_loss(below, nothing)) == float(cost_loss(nothing, nothing)) == 1.0
    assert float(jax.grad(cost_loss)(above, nothing)) > 0
    assert float(jax.grad(cost_loss)(below, jnp.ones(()))) < 0


@pytest.fixture(scope="module")
def cases():
    encounters = random_encounters(jax.random.key(5), COUNT, SHIP, PAPER)
    plain = jax.tree.map(np.asarray, plain_cases(encounters, SHIP, 480))
    return jax.tree.map(jnp.asarray, with_instruments(plain, np.arange(COUNT, dtype=np.int32)))


@jax.jit
def costs_of(cases):
    """The labels, and what the simulated critic expects from what is seen."""

    def one(case):
        start = reset_case(case)
        seen = start.perceived.observation
        _, values = CRITIC(seen, SHIP)
        return true_costs(case, start.state, seen, SHIP, TABLE, COSTS), -values.by_ship.T

    return jax.device_get(jax.vmap(one)(cases))


def test_labels_are_the_simulated_critics_where_ships_keep_straight(cases):
    labels, expected = costs_of(cases)
    assert (labels > 1.0).mean() > 0.05
    np.testing.assert_allclose(labels, expected, rtol=2e-3, atol=0.2)


def test_a_current_that_is_seen_changes_no_label(cases):
    """Apart from the way to the waypoint, which here is too far off to be set aside."""
    carried = DISTURBANCES["current"][1](cases, np.random.default_rng(1))
    carried = eqx.tree_at(lambda c: c.encounter.route.y, carried, replace_fn=lambda y: 100 * y)
    labels, expected = costs_of(carried)
    np.testing.assert_allclose(labels, expected, rtol=1e-2, atol=0.5)


def test_labels_know_who_will_alter_course(cases):
    rng = np.random.default_rng(2)
    labels, expected = costs_of(DISTURBANCES["altering"][1](cases, rng))
    present = np.asarray(cases.encounter.present)
    assert np.abs(labels - expected)[present].max() > 100
    assert not labels[~present].any()


def test_of_alterations_that_come_later_labels_need_not_know(cases):
    rng = np.random.default_rng(2)
    altering = DISTURBANCES["altering"][1](cases, rng)
    case = jax.tree.map(lambda x: x[0], altering)
    start = reset_case(case)
    seen = start.perceived.observation

    def costs(reaction_s):
        return true_costs(case, start.state, seen, SHIP, TABLE, COSTS, None, reaction_s)

    straight = eqx.tree_at(
        lambda c: c.encounter.targets,
        case,
        replace_fn=lambda t: jax.tree.map(lambda x: x[:, :1], t),
    )
    soon = true_costs(straight, start.state, seen, SHIP, TABLE, COSTS)
    np.testing.assert_array_equal(costs(60.0), soon)
    assert np.abs(np.asarray(costs(np.inf) - costs(60.0))).max() > 10


def test_labels_know_the_true_ship(cases):
    labels, expected = costs_of(DISTURBANCES["ship"][1](cases, np.random.default_rng(3)))
    assert np.abs(labels - expected).max() > 10


def test_some_cases_are_disturbed_each_in_its_own_way(cases):
    many = jax.tree.map(lambda x: jnp.repeat(x, 50, axis=0), cases)
    many = with_random_disturbances(
        dataclasses.replace(many, disturbance=None), 0.5, np.random.default_rng(4)
    )
    noise = np.asarray(many.disturbance.own_heading_rad) > 0
    drift = np.asarray(many.disturbance.current_m_s.x) != 0
    gain = np.asarray(many.ship.gain_1_s) != np.float32(SHIP.gain_1_s)
    for flags in (noise, drift, gain):
        assert 0.15 < flags.mean() < 0.35
    assert 0.03 < (noise & drift & gain).mean() < 0.12
    bent = np.asarray(many.encounter.targets.start_s)[..., 1] < 1e4
    assert 0.2 < bent.any(-1).mean() < 0.5


def test_the_critic_is_additive_and_says_nothing_of_empty_slots(cases):
    sizes = ManoeuvreCriticSizes((8, 8), table=TABLE, costs=COSTS)
    critic = LearnedCritic(sizes, jax.random.key(0))
    seen = jax.tree.map(lambda x: x[0], costs_observations(cases))
    _, values = critic(seen, SHIP)
    assert values.by_ship.shape == (TABLE.size, seen.present.shape[0])
    assert float(values.by_ship.max()) <= 0.0
    assert not np.asarray(values.by_ship)[:, ~np.asarray(seen.present)].any()
    _, simulated = CRITIC(seen, SHIP)
    np.testing.assert_allclose(values.waypoint, simulated.waypoint, rtol=1e-5)
    np.testing.assert_allclose(values.helm, simulated.helm, rtol=1e-5)
    some, along = critic.along(jnp.float32(0.55), seen, SHIP)
    best = int(jnp.argmax(along.total))
    assert np.isfinite(np.asarray(along.waypoint)).sum() == len(TABLE.durations_s)
    bearing = float(seen.waypoint[0, 2]) * np.pi
    assert float(some.offset_rad[best]) + bearing == pytest.approx(np.radians(30), abs=0.03)


def costs_observations(cases):
    return jax.vmap(lambda c: reset_case(c).perceived.observation)(cases)
