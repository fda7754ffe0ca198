"""The simulated critic: sub-tasks that add up, and what each of them says."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.planning.test_course_planner import SHIP, begin, scene

from glasshelm.planning.course_planner import CourseSettings, plan_course
from glasshelm.planning.manoeuvres import ManoeuvreTable
from glasshelm.planning.simulated_critic import ManoeuvreCosts, SimulatedCritic
from glasshelm.ship.nomoto import SHIPS

CRITIC = SimulatedCritic()
value = jax.jit(lambda observation: CRITIC(observation, SHIP))
HEAD_ON, CROSSING = (0.0, 6000.0, 180.0, 5.0), (5000.0, 3000.0, 270.0, 5.0)


def values(*rows, **scenery):
    return value(begin(scene(*rows, **scenery), SHIP).observation)[1]


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


def test_with_one_ship_it_values_as_the_planner_does():
    """What the planner takes the worst of all ships of is then that ship's own."""
    observation = begin(scene(HEAD_ON), SHIP).observation
    plan = jax.jit(lambda o: plan_course(o, SHIP, CourseSettings()))(observation)
    np.testing.assert_allclose(value(observation)[1].total, plan.values, rtol=1e-4, atol=2e-3)


def test_keeping_course_and_speed_is_the_last_manoeuvre():
    manoeuvres = ManoeuvreTable().at(jnp.asarray(0.3))
    assert float(manoeuvres.offset_rad[-1]) == pytest.approx(-0.3)
    assert float(manoeuvres.duration_s[-1]) == max(ManoeuvreTable().keep_s)
    assert float(manoeuvres.altered_rad(jnp.asarray(0.3))[0]) == pytest.approx(0.3)


@pytest.mark.parametrize("name", SHIPS)
def test_the_worst_a_ship_can_cost_is_to_be_run_over(name):
    costs, ship = ManoeuvreCosts(), SHIPS[name]
    observation = begin(scene((0.0, 2000.0, 180.0, 5.0)), ship).observation
    found = jax.jit(lambda o: CRITIC(o, ship))(observation)[1]
    keep = float(found.by_ship[-1, 0])
    assert keep < -(0.9 * costs.near_weight + 0.9 * costs.worst_weight)
    assert float(found.by_ship[:, 0].max()) > keep
