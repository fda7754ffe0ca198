"""The glassbox pilot: its explanation is its decision."""

import dataclasses
import itertools
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.pilots.scenes import colliding, meeting

import glasshelm
from glasshelm.core.errors import InputError
from glasshelm.core.geometry import wrap_angle
from glasshelm.env.observe import Observation
from glasshelm.env.step import reset
from glasshelm.evaluation.contenders import parse_contenders
from glasshelm.explanation.manoeuvre_explanation import (
    SAME_COURSE_RAD,
    choose,
    last_safe_s,
    needed_ships,
)
from glasshelm.networks.critics import QValues
from glasshelm.pilots.batched import BatchedPilot
from glasshelm.pilots.glassbox import GlassboxPilot
from glasshelm.pilots.pilot_resolution import resolve_pilot_and_ship
from glasshelm.pilots.registry import pilot_named
from glasshelm.planning.simulated_critic import SimulatedCritic
from glasshelm.planning.situation import situation_of
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.rollout import plain_cases, rollout
from glasshelm.whatif.logged_world import pilot_of

SHIP, CRITIC = SHIPS["paper"], SimulatedCritic()
SCENARIO = glasshelm.scenario("random:35")


@pytest.fixture(scope="module")
def frames():
    return list(glasshelm.simulate(SCENARIO, pilot_named("paper-glassbox")))


def seen(*rows, ship=SHIP) -> Observation:
    return jax.jit(lambda e: reset(e, ship).observation)(meeting(*rows, ship=ship))


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


def test_the_pilot_for_any_ship_decides_as_the_one_made_for_that_ship(frames):
    pilot = pilot_named("glassbox")
    for name, ship in SHIPS.items():
        observation = seen(colliding(180, tcpa_s=900), ship=ship)
        found = glasshelm.explain(pilot, observation, ship=ship)
        made = glasshelm.explain(pilot_named(f"{name.replace('_', '-')}-glassbox"), observation)
        assert found.rudder == pytest.approx(made.rudder, abs=1e-5)
        ours, theirs = found.explanation.value, made.explanation.value
        np.testing.assert_allclose(ours.by_ship, theirs.by_ship, rtol=1e-4, atol=1e-3)
    for frame, any_ship in zip(frames, glasshelm.simulate(SCENARIO, pilot, 40), strict=False):
        assert any_ship.pilot == "glassbox"
        # Of two manoeuvres that are nearly as good, rounding may choose either.
        assert any_ship.value.total == pytest.approx(frame.value.total, rel=1e-3, abs=0.5)
    contender, large = parse_contenders(["glassbox"])
    assert (contender.pilots[0].ship, large.pilots[0].ship) == tuple(SHIPS.values())


def test_any_ship_is_a_ship_of_any_parameters(tmp_path):
    """The same program for all; a log names the pilot, and its frames the ship."""
    nimble = dataclasses.replace(SHIP, gain_1_s=0.2, time_constant_s=15.0, loa_m=60.0)
    pilot, quick = pilot_named("glassbox"), glasshelm.scenario("random:35", ship=nimble)
    frames = list(glasshelm.simulate(quick, pilot, 60))
    made = glasshelm.simulate(quick, GlassboxPilot(nimble, "made"), 60)
    for one, other in zip(frames, made, strict=True):
        assert one.manoeuvre == other.manoeuvre
        assert one.decision.rudder_rad == pytest.approx(other.decision.rudder_rad, abs=1e-5)
    assert pilot_of(frames[0]) is pilot
    contrast = glasshelm.why_not(frames, 30, pilot, frames[30].own.heading_rad + 1.0)
    assert contrast.chosen_rad % math.tau == pytest.approx(
        frames[30].manoeuvre.course_rad % math.tau, abs=1e-4
    )
    with pytest.raises(InputError, match="'glassbox' is for any ship"):
        pilot.decide(seen(), ())


def test_where_nobody_is_named_it_steers():
    for ship in SHIPS:
        assert resolve_pilot_and_ship(None, ship) == (pilot_named("glassbox"), SHIPS[ship])
    assert resolve_pilot_and_ship(None, None)[1] == SHIPS["paper"]


def test_the_course_chosen_is_that_of_the_manoeuvre_and_is_steered():
    observation = seen(colliding(180, tcpa_s=900))
    decision = glasshelm.explain(pilot_named("paper-glassbox"), observation)
    manoeuvre = decision.explanation.manoeuvre
    bearing = situation_of(observation, SHIP).bearing_rad
    manoeuvres, values = CRITIC(observation, SHIP)
    offset = manoeuvres.offset_rad[choose(values)]
    assert float(manoeuvre.course_rad) == pytest.approx(float(wrap_angle(bearing + offset)))
    assert np.sign(float(decision.rudder)) == np.sign(float(manoeuvre.course_rad))
