"""The glassbox pilot: its explanation is its decision."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.pilots.scenes import colliding, meeting

import glasshelm
from glasshelm.core.geometry import wrap_angle
from glasshelm.env.observe import Observation
from glasshelm.env.step import reset
from glasshelm.explanation.manoeuvre_explanation import (
    SAME_COURSE_RAD,
    choose,
    last_safe_s,
    needed_ships,
)
from glasshelm.networks.critics import QValues
from glasshelm.pilots.batched import BatchedPilot
from glasshelm.pilots.registry import pilot_named
from glasshelm.planning.simulated_critic import SimulatedCritic
from glasshelm.planning.situation import situation_of
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.rollout import plain_cases, rollout

SHIP, CRITIC = SHIPS["paper"], SimulatedCritic()


@pytest.fixture(scope="module")
def frames():
    return list(glasshelm.simulate(glasshelm.scenario("random:35"), pilot_named("paper-glassbox")))


def seen(*rows) -> Observation:
    return jax.jit(lambda e: reset(e, SHIP).observation)(meeting(*rows))


def test_in_every_frame_the_parts_add_up_and_the_chosen_total_is_the_largest(frames):
    assert len(frames) > 200
    for frame in frames:
        for value in (frame.value, frame.priority, *(a.value for a in frame.alternatives)):
            parts = value.waypoint + value.collision + value.helm
            assert parts == pytest.approx(value.total, abs=1e-4)
        for other in frame.alternatives:
            assert other.value.total <= frame.value.total + 1e-4
            assert sum(other.by_target.values()) == pytest.approx(other.value.collision, abs=1e-4)
        assert sum(t.q for t in frame.targets) == pytest.approx(frame.value.collision, abs=1e-4)
        assert sum(t.priority for t in frame.targets) == pytest.approx(
            frame.priority.collision, abs=1e-4
        )


def test_priorities_are_measured_from_keeping_course_and_speed(frames):
    for frame in frames:
        keep = next(a for a in frame.alternatives if a.name == "keep")
        assert keep.course_rad == pytest.approx(frame.own.heading_rad, abs=1e-4)
        for target in frame.targets:
            assert target.priority == pytest.approx(target.q - keep.by_target[target.id], abs=1e-4)


def test_avoiding_is_for_the_ships_and_coming_back_for_the_waypoint(frames):
    """Figs 10-11: first a positive collision priority, later one of the waypoint."""
    away = frames[0]
    assert away.decision.rudder_rad > 0.05
    assert away.priority.collision > 100.0
    assert away.priority.waypoint < 0.0
    back = next(f for f in frames if f.decision.rudder_rad < -0.05)
    assert back.priority.waypoint > 10.0
    assert back.priority.waypoint > 5.0 * abs(back.priority.collision)


def test_shares_add_up_to_the_rudder_and_to_the_course(frames):
    for frame in frames[::10]:
        rudder = frame.decision.base_rad + sum(t.shapley_rad for t in frame.targets)
        assert rudder == pytest.approx(frame.decision.rudder_rad, abs=1e-5)
        alone = next(a for a in frame.alternatives if a.name == "without ships").course_rad
        moved = (
            frame.manoeuvre.course_rad - alone - sum(t.course_shapley_rad for t in frame.targets)
        )
        assert (moved + np.pi) % (2 * np.pi) - np.pi == pytest.approx(0.0, abs=1e-4)


def test_in_an_empty_sea_nobody_is_needed(frames):
    empty, *_ = glasshelm.simulate(
        glasshelm.scenario("random:1:0"), pilot_named("paper-glassbox"), 0
    )
    assert empty.needed == []
    assert empty.last_safe_s == CRITIC.costs.horizon_s
    assert all(set(f.needed) <= {t.id for t in f.targets} for f in frames)
    assert any(f.needed for f in frames)


@pytest.mark.parametrize("seed", range(4))
def test_no_smaller_set_of_ships_would_do(seed):
    rng = np.random.default_rng(seed)
    course = jnp.linspace(-2.0, 2.0, 30)
    by_ship = jnp.asarray(-(rng.exponential(size=(30, 4)) ** 4), jnp.float32)
    values = QValues(jnp.asarray(rng.normal(size=30), jnp.float32), by_ship, jnp.zeros(30))
    present = jnp.array([True, True, True, False])
    values = QValues(values.waypoint, by_ship * present, values.helm)
    found = np.asarray(needed_ships(values, course, present))
    steered = course[choose(values)]

    def changes(left_out) -> bool:
        members = jnp.array([i not in left_out for i in range(4)])
        return abs(float(wrap_angle(course[choose(values, members)] - steered))) > SAME_COURSE_RAD

    sizes = [k for k in (1, 2, 3) if any(map(changes, itertools.combinations(range(3), k)))]
    assert found.sum() == (sizes[0] if sizes else 0)
    assert not sizes or changes(tuple(np.flatnonzero(found)))


def test_time_runs_out_for_the_last_safe_manoeuvre(frames):
    far, near, late = (
        float(last_safe_s(seen(colliding(180, tcpa_s=t)), SHIP, CRITIC.costs))
        for t in (1500, 500, 150)
    )
    assert far > near > 0
    assert np.isnan(late)
    assert float(last_safe_s(seen(), SHIP, CRITIC.costs)) == CRITIC.costs.horizon_s
    for before, after in itertools.pairwise(frames):
        if before.last_safe_s and after.last_safe_s and before.last_safe_s < 300:
            assert after.last_safe_s >= before.last_safe_s - 120


def test_it_keeps_clear_where_doing_nothing_collides():
    rows = [colliding(180, tcpa_s=1200), colliding(270, tcpa_s=1300), colliding(45, tcpa_s=1500)]
    pilot = pilot_named("paper-glassbox")
    encounter = meeting(*rows)
    cases = plain_cases(jax.tree.map(lambda x: x[None], encounter), SHIP, 360)
    measures = rollout(BatchedPilot(pilot), cases, 360)
    assert float(measures.margin[0, 1]) < 0.0


def test_the_course_chosen_is_that_of_the_manoeuvre_and_is_steered():
    observation = seen(colliding(180, tcpa_s=900))
    decision = glasshelm.explain(pilot_named("paper-glassbox"), observation)
    manoeuvre = decision.explanation.manoeuvre
    bearing = situation_of(observation, SHIP).bearing_rad
    manoeuvres, values = CRITIC(observation, SHIP)
    offset = manoeuvres.offset_rad[choose(values)]
    assert float(manoeuvre.course_rad) == pytest.approx(float(wrap_angle(bearing + offset)))
    assert np.sign(float(decision.rudder)) == np.sign(float(manoeuvre.course_rad))
