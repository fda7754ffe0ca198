"""The planner sees what is there and chooses what a navigator would."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.core.geometry import Vector
from glasshelm.encounters.imazu import imazu_scenario
from glasshelm.encounters.random_encounters import random_encounter
from glasshelm.encounters.types import Encounter, straight_track
from glasshelm.env.step import reset, step
from glasshelm.pilots.course_pilot import CoursePilot
from glasshelm.pilots.planner import PLANNER
from glasshelm.planning.course_planner import CourseSettings, action_gap, plan_course
from glasshelm.planning.situation import rudder_towards, situation_of
from glasshelm.ship.nomoto import SHIPS, ShipState

SHIP = SHIPS["large_ship"]


def scene(*rows, waypoint=(0.0, 46_300.0), heading=0.0) -> Encounter:
    """Targets as rows of east, north [m], course [deg], speed [m/s]; one empty slot behind."""
    east, north, course, speed = jnp.array([*rows, (0.0, 0.0, 0.0, 0.0)]).T
    return Encounter(
        ShipState.steady(0.0, 0.0, float(np.radians(heading)), SHIP.speed_m_s),
        Vector(jnp.array([waypoint[0]]), jnp.array([waypoint[1]])),
        straight_track(east, north, jnp.radians(course), speed),
        jnp.arange(len(rows) + 1) < len(rows),
    )


plan = jax.jit(plan_course, static_argnums=(1, 2))
begin = jax.jit(reset, static_argnums=1)
move = jax.jit(step, static_argnums=3)
rudder_of = jax.jit(rudder_towards, static_argnums=2)


@pytest.mark.slow
def test_the_situation_is_read_back_from_the_observation():
    encounter = scene((2000.0, 5000.0, 250.0, 4.0))
    state = begin(encounter, SHIP)
    for _ in range(30):
        state = move(encounter, state, jnp.float32(SHIP.rudder_limit_rad), SHIP).state
    at = situation_of(state.observation, SHIP)
    assert float(at.rate_of_turn_rad_s) == pytest.approx(
        float(state.own.rate_of_turn_rad_s), rel=0.05
    )
    speed = np.hypot(float(at.velocity.x[0]), float(at.velocity.y[0]))
    assert speed == pytest.approx(4.0, rel=1e-3)


def test_alone_she_steers_for_the_waypoint():
    state = begin(scene(), SHIP)
    assert float(plan(state.observation, SHIP).offset_rad) == 0.0
    state = begin(scene(waypoint=(20_000.0, 20_000.0)), SHIP)
    found = plan(state.observation, SHIP)
    assert abs(float(found.offset_rad)) < np.radians(11)
    assert float(rudder_of(found.offset_rad, state.observation, SHIP)) == 1.0


def test_she_alters_for_a_ship_ahead_and_more_is_at_stake():
    calm = begin(scene((9000.0, 9000.0, 0.0, 5.0)), SHIP).observation
    tense = begin(scene((0.0, 6000.0, 180.0, 5.0)), SHIP).observation
    calm_plan, tense_plan = plan(calm, SHIP), plan(tense, SHIP)
    assert float(calm_plan.offset_rad) == 0.0
    assert abs(float(tense_plan.offset_rad)) > np.radians(9.0)
    assert float(action_gap(tense_plan, tense, SHIP)) > 3 * float(action_gap(calm_plan, calm, SHIP))


@pytest.mark.parametrize("heading", [-35.0, 35.0])
def test_of_two_sides_the_one_being_steered_is_kept(heading):
    """A head-on ship can be passed on either side; alone, changing sides would be free."""
    observation = begin(scene((0.0, 7000.0, 180.0, 5.0), heading=heading), SHIP).observation
    course = heading + np.degrees(
        float(situation_of(observation, SHIP).bearing_rad + plan(observation, SHIP).offset_rad)
    )
    assert np.sign(course) == np.sign(heading)
    fickle = plan(observation, SHIP, CourseSettings(keep_s=(), alter_cost=0.0))
    assert float(fickle.values.max()) > float(plan(observation, SHIP).values.max())


@pytest.mark.slow
def test_between_two_ways_out_the_middle_is_what_costs():
    """Imazu 19: two ships close in from both sides; a turn to either is better than none."""
    paper = SHIPS["paper"]
    observation = begin(imazu_scenario("19", paper).encounter, paper).observation
    found = plan(observation, paper)
    first = float(rudder_of(found.offset_rad, observation, paper))
    rudders = np.array([float(rudder_of(o, observation, paper)) for o in found.first_offsets_rad])
    values = np.asarray(found.values)
    lasts = (found.first_durations_s == 0.0) | (found.first_durations_s >= 200.0)
    across = values[lasts & (rudders * np.sign(first) < -0.5)].max()
    middle = values[lasts & (np.abs(rudders) < 0.25)].max()
    assert abs(first) > 0.5
    assert values.max() > across > middle + 20.0
    assert float(action_gap(found, observation, paper)) == pytest.approx(
        values.max() - middle, rel=1e-5
    )


def test_she_turns_to_the_waypoint_at_once_where_nothing_is_in_the_way():
    observation = begin(scene(waypoint=(30_000.0, 30_000.0)), SHIP).observation
    assert abs(np.degrees(float(plan(observation, SHIP).offset_rad))) < 11


def test_an_absent_target_changes_nothing():
    observation = begin(scene((0.0, 6000.0, 180.0, 5.0)), SHIP).observation
    ghost = type(observation)(
        observation.waypoint, observation.targets.at[1].set(0.01), observation.present
    )
    np.testing.assert_array_equal(plan(observation, SHIP).values, plan(ghost, SHIP).values)


def test_the_manoeuvres_are_those_of_the_settings():
    table = CourseSettings(
        (-30.0, 30.0), (100.0, 200.0), (0.0, 60.0), (50.0,), (60.0,), (70.0, 80.0)
    ).off_waypoint()
    assert table.shape == (1 + 4 + 2, 4)  # nothing; one alteration; 0 then 60 twice
    np.testing.assert_allclose(table[0], 0.0)
    np.testing.assert_allclose(table[-1], [0.0, 50, np.radians(60), 80], rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPS)
def test_it_keeps_clear_of_ships_that_meet_doing_nothing(name):
    ship = SHIPS[name]
    pilot = CoursePilot(ship, "planner", PLANNER)
    keys = jax.random.split(jax.random.key(11), 8)
    batch = jax.jit(jax.vmap(lambda k: random_encounter(k, ship, count=1)))(keys)

    @jax.jit
    def margins():
        state = jax.vmap(lambda e: reset(e, ship))(batch)
        memory = jax.tree.map(lambda x: jnp.broadcast_to(x, (8,)), pilot.start())

        def go(carry, _):
            state, memory = carry
            decision, memory = jax.vmap(pilot.decide)(state.observation, memory)
            out = jax.vmap(lambda e, s, a: step(e, s, a * ship.rudder_limit_rad, ship))(
                batch, state, decision.rudder
            )
            return (out.state, memory), jnp.where(batch.present, out.margin, -9.0).max(-1)

        return jax.lax.scan(go, (state, memory), None, length=400)[1].max(0)

    assert jnp.max(margins()) < 0.05


@pytest.mark.slow
def test_one_world_is_steered_as_it_is_among_others():
    encounter = imazu_scenario("5", SHIP).encounter
    pilot = CoursePilot(SHIP, "planner", PLANNER)
    observation = reset(encounter, SHIP).observation
    one, memory = jax.jit(pilot.decide)(observation, pilot.start())
    two = jax.tree.map(lambda x: jnp.stack([x, x]), (observation, pilot.start()))
    both, memories = jax.jit(jax.vmap(pilot.decide))(*two)
    np.testing.assert_allclose(both.rudder, one.rudder)
    np.testing.assert_allclose(memories.offset_rad, memory.offset_rad)
    assert int(memory.age) == 1
