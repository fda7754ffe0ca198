"""What holds for every pilot that thinks in courses, whatever its rule."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.pilots.scenes import colliding, observed

from glasshelm.encounters.random_encounters import RandomEncounters, random_encounters
from glasshelm.env.observe import Observation
from glasshelm.pilots.batched import BatchedPilot
from glasshelm.pilots.course_pilot import CourseMemory, CourseMethod, CoursePilot
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.registry import METHODS, WITHOUT_WEIGHTS, pilot_named
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.rollout import plain_cases, rollout

SHIP = SHIPS["paper"]
AVOIDING = [name for name in METHODS if name != "waypoint"]


def course(name: str, what: Observation, offset_deg: float = 0.0, ship=SHIP) -> float:
    """The course [deg] off the waypoint's bearing that a method chooses."""
    method = METHODS[name]
    chosen = jax.jit(lambda s, o: method.rule(s, o, ship, method.settings))
    return float(jnp.degrees(chosen(what, jnp.radians(jnp.float32(offset_deg)))))


def test_every_method_steers_every_preset_ship_by_name():
    for ship in ("paper", "large-ship"):
        for name in METHODS:
            pilot = pilot_named(f"{ship}-{name}")
            assert isinstance(pilot, Pilot)
            assert pilot.name == f"{ship}-{name}"
            assert pilot.ship == SHIPS[ship.replace("-", "_")]
    kinds = {name.removeprefix("paper-").removeprefix("large-ship-") for name in WITHOUT_WEIGHTS}
    assert kinds == {*METHODS, "straight", "glassbox"}


@pytest.mark.parametrize("name", METHODS)
def test_alone_she_steers_for_the_waypoint(name):
    assert course(name, observed()) == pytest.approx(0.0, abs=0.1)
    assert course(name, observed(heading_deg=20.0)) == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("name", METHODS)
def test_a_ship_far_away_and_leaving_is_let_go(name):
    leaving = (9000.0, 9000.0, 45.0, 6.0)
    assert course(name, observed(leaving)) == pytest.approx(0.0, abs=0.5)


@pytest.mark.parametrize("name", AVOIDING)
@pytest.mark.parametrize("course_deg", [180.0, 270.0])
def test_for_a_ship_ahead_or_from_starboard_near_collision_course_she_alters(name, course_deg):
    east, north, heading, speed = colliding(course_deg, tcpa_s=200.0)
    # Not dead ahead: there the force of a field has no side.
    assert abs(course(name, observed((east + 300.0, north, heading, speed)))) > 5.0


@pytest.mark.parametrize("name", METHODS)
def test_an_absent_target_changes_nothing(name):
    what = observed(colliding(180.0))
    ghost = Observation(what.waypoint, what.targets.at[1].set(0.01), what.present)
    assert course(name, what) == course(name, ghost)


@pytest.mark.parametrize("name", METHODS)
def test_no_slots_at_all_is_an_empty_sea(name):
    what = observed()
    assert course(name, Observation(what.waypoint, what.targets[:0], what.present[:0])) == 0.0


def test_a_course_is_chosen_every_so_many_decisions_and_steered_in_between():
    def further(observation, offset_rad, ship, settings):
        return offset_rad + settings

    pilot = CoursePilot(SHIP, "further", CourseMethod(further, 0.1, period=3))
    what, memory = observed(), pilot.start()
    offsets = []
    for _ in range(7):
        decision, memory = pilot.decide(what, memory)
        offsets.append(float(memory.offset_rad))
        assert float(decision.rudder) > 0
    np.testing.assert_allclose(offsets, [0.1, 0.1, 0.1, 0.2, 0.2, 0.2, 0.3], rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cpa", "mpc"])
def test_one_world_is_steered_as_it_is_among_others(name):
    pilot = CoursePilot(SHIP, name, METHODS[name])
    what = observed(colliding(270.0))
    one, _ = jax.jit(pilot.decide)(what, pilot.start())
    two = jax.tree.map(lambda x: jnp.stack([x, x]), (what, pilot.start()))
    both, _ = jax.jit(jax.vmap(pilot.decide))(*two)
    np.testing.assert_allclose(both.rudder, one.rudder)
    branches = str(jax.make_jaxpr(jax.vmap(pilot.decide))(*two))
    assert "cond[" in branches  # both worlds choose at once, or neither does


@functools.cache
def intruded(method: str) -> int:
    """In how many of 24 encounters with the real ship somebody came into the domain."""
    ship = SHIPS["large_ship"]
    encounters = random_encounters(jax.random.key(5), 24, ship, RandomEncounters(targets=(1, 3)))
    policy = BatchedPilot(CoursePilot(ship, method, METHODS[method]))
    measures = rollout(policy, plain_cases(encounters, ship, 480), 480)
    return int((measures.margin[:, 1] > 0).sum())


@pytest.mark.slow
@pytest.mark.parametrize("name", AVOIDING)
def test_every_avoidance_avoids(name):
    assert intruded(name) < 0.6 * intruded("waypoint")


def test_the_memory_is_one_course_and_a_count():
    memory = CoursePilot(SHIP, "cpa", METHODS["cpa"]).start()
    assert isinstance(memory, CourseMemory)
    assert memory.offset_rad.shape == memory.age.shape == ()
