"""The simulated critic: sub-tasks that add up, and choices that a navigator would make."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.pilots.scenes import meeting

from glasshelm.encounters.types import Encounter
from glasshelm.env.step import reset, step
from glasshelm.explanation.manoeuvre_explanation import choose
from glasshelm.planning.manoeuvres import ManoeuvreTable
from glasshelm.planning.simulated_critic import ManoeuvreCosts, SimulatedCritic
from glasshelm.planning.situation import rudder_towards, situation_of
from glasshelm.ship.nomoto import SHIPS

SHIP = SHIPS["large_ship"]
CRITIC = SimulatedCritic()
value = jax.jit(lambda critic, observation: critic(observation, SHIP), static_argnums=0)
begin = jax.jit(reset, static_argnums=1)
HEAD_ON, CROSSING = (0.0, 6000.0, 180.0, 5.0), (5000.0, 3000.0, 270.0, 5.0)


def scene(*rows, **scenery) -> Encounter:
    return meeting(*rows, **scenery, ship=SHIP)


def values(*rows, **scenery):
    return value(CRITIC, begin(scene(*rows, **scenery), SHIP).observation)[1]


def chosen_rad(observation, critic=CRITIC) -> float:
    """The course of the best manoeuvre, off the waypoint's bearing."""
    manoeuvres, found = value(critic, observation)
    return float(manoeuvres.offset_rad[choose(found)])


def test_what_a_ship_costs_does_not_depend_on_the_others():
    """The sum over ships is exact: a manoeuvre fixes own ship's future."""
    both, one, other = values(HEAD_ON, CROSSING), values(HEAD_ON), values(CROSSING)
    np.testing.assert_allclose(both.by_ship[:, 0], one.by_ship[:, 0], rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(both.by_ship[:, 1], other.by_ship[:, 0], rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(both.waypoint, one.waypoint, rtol=1e-5)
    np.testing.assert_array_equal(both.helm, one.helm)


def test_absent_ships_cost_nothing_and_no_cost_is_a_gain():
    found = values(HEAD_ON)
    assert not found.by_ship[:, 1].any()
    assert (found.by_ship <= 0).all()
    assert (found.helm <= 0).all()


def test_keeping_course_and_speed_is_the_last_manoeuvre():
    manoeuvres = ManoeuvreTable().at(jnp.asarray(0.3))
    assert float(manoeuvres.offset_rad[-1]) == pytest.approx(-0.3)
    assert float(manoeuvres.duration_s[-1]) == max(ManoeuvreTable().keep_s)
    assert float(manoeuvres.altered_rad(jnp.asarray(0.3))[0]) == pytest.approx(0.3)


@pytest.mark.parametrize("name", SHIPS)
def test_the_worst_a_ship_can_cost_is_to_be_run_over(name):
    costs, ship = ManoeuvreCosts(), SHIPS[name]
    observation = begin(meeting((0.0, 2000.0, 180.0, 5.0), ship=ship), ship).observation
    found = jax.jit(lambda o: CRITIC(o, ship))(observation)[1]
    keep = float(found.by_ship[-1, 0])
    assert keep < -(0.9 * costs.near_weight + 0.9 * costs.worst_weight)
    assert float(found.by_ship[:, 0].max()) > keep


@pytest.mark.slow
def test_the_situation_is_read_back_from_the_observation():
    encounter, move = scene((2000.0, 5000.0, 250.0, 4.0)), jax.jit(step, static_argnums=3)
    state = begin(encounter, SHIP)
    for _ in range(30):
        state = move(encounter, state, jnp.float32(SHIP.rudder_limit_rad), SHIP).state
    at = situation_of(state.observation, SHIP)
    assert float(at.rate_of_turn_rad_s) == pytest.approx(
        float(state.own.rate_of_turn_rad_s), rel=0.05
    )
    speed = np.hypot(float(at.velocity.x[0]), float(at.velocity.y[0]))
    assert speed == pytest.approx(4.0, rel=1e-3)


def test_alone_it_steers_for_the_waypoint_at_once():
    assert chosen_rad(begin(scene(), SHIP).observation) == 0.0
    aside = begin(scene(waypoint=(20_000.0, 20_000.0)), SHIP).observation
    assert abs(chosen_rad(aside)) < np.radians(11)
    assert float(rudder_towards(jnp.float32(chosen_rad(aside)), aside, SHIP)) == 1.0


def test_it_alters_for_a_ship_ahead_and_for_none_that_is_far_away():
    assert chosen_rad(begin(scene((9000.0, 9000.0, 0.0, 5.0)), SHIP).observation) == 0.0
    assert abs(chosen_rad(begin(scene(HEAD_ON), SHIP).observation)) > np.radians(9.0)


@pytest.mark.parametrize("heading", [-35.0, 35.0])
def test_of_two_sides_the_one_being_steered_is_kept(heading):
    """A head-on ship can be passed on either side; alone, changing sides would be free."""
    begun = begin(scene((0.0, 7000.0, 180.0, 5.0), heading_deg=heading), SHIP).observation
    bearing = float(situation_of(begun, SHIP).bearing_rad)
    assert np.sign(heading + np.degrees(bearing + chosen_rad(begun))) == np.sign(heading)
    fickle = dataclasses.replace(CRITIC, costs=ManoeuvreCosts(alter_cost=0.0))
    free, charged = (value(critic, begun)[1] for critic in (fickle, CRITIC))
    assert not free.helm.any()
    assert float(free.total.max()) > float(charged.total.max())


def test_an_absent_target_changes_nothing():
    observation = begin(scene(HEAD_ON), SHIP).observation
    ghost = type(observation)(
        observation.waypoint, observation.targets.at[1].set(0.01), observation.present
    )
    with_ghost, without = value(CRITIC, ghost)[1], value(CRITIC, observation)[1]
    np.testing.assert_array_equal(with_ghost.total, without.total)


def test_the_manoeuvres_are_those_of_the_table():
    table = ManoeuvreTable(
        (-30.0, 30.0), (100.0, 200.0), (0.0, 60.0), (50.0,), (60.0,), (70.0, 80.0)
    ).off_waypoint()
    assert table.shape == (1 + 4 + 2, 4)  # nothing; one alteration; 0 then 60 twice
    np.testing.assert_allclose(table[0], 0.0)
    np.testing.assert_allclose(table[-1], [0.0, 50, np.radians(60), 80], rtol=1e-6)
