"""Each failure is explained by what changes when one thing is changed."""

import equinox as eqx
import jax.numpy as jnp
import pytest
from benchmarks.failures import Event, FailureCause, explain_failures, summary_table
from tests.evaluation.cases import SHIP, SPEED, cases, encounter

from glasshelm.evaluation.suites.random_suite import random_suite
from glasshelm.pilots.function_pilot import FunctionPilot
from glasshelm.pilots.registry import pilot_named
from glasshelm.pilots.straight import StraightPilot
from glasshelm.ship.nomoto import SHIPS

pytestmark = pytest.mark.slow

U = SPEED
#: East, north [m], course [deg], speed [m/s]. She comes head-on; she keeps abeam to starboard.
AHEAD, BESIDE = (0.0, 9000.0, 180.0, 5.0), (2500.0, 0.0, 0.0, U)
#: She lies where own ship is a moment later.
ON_TOP = (0.0, 400.0, 0.0, 0.0)


def batch(*meetings):
    return cases(*[encounter(*rows) for rows in meetings], steps=360)


def explained(pilot, cases, event=Event.COLLISION, seer=None):
    return explain_failures(pilot, pilot_named("paper-mpc"), seer, cases, event)


class Hopeful(eqx.Module):
    """A seer who steers hard to starboard whatever he knows."""

    name: str = "hopeful"

    def policy_for(self, known):
        return _HARD


class _Hard(eqx.Module):
    def start(self, worlds):
        return ()

    def __call__(self, observation, memory):
        return jnp.ones(observation.waypoint.shape[0]), memory


_HARD = _Hard()


@pytest.fixture(scope="module")
def found():
    return explained(StraightPilot(), batch([AHEAD], [BESIDE], [AHEAD, BESIDE], [ON_TOP]))


def test_only_failures_are_explained_and_with_whom(found):
    assert [f.case for f in found] == [0, 2, 3]
    assert [f.met_slot for f in found] == [0, 0, 0]
    assert [f.ships for f in found] == [1, 2, 1]


def test_the_time_is_that_of_the_event(found):
    closing = U + 5.0
    assert found[0].time_s == pytest.approx((9000.0 - SHIP.loa_m) / closing, abs=5.0)
    assert found[0].nearest_m < 60.0
    assert found[0].depth > 0.9


def test_who_never_steers_fails_alone_too_and_no_other_ship_is_to_blame(found):
    assert all(f.alone and f.n_contributing == 0 for f in found)


def test_the_way_out_stays_open_until_the_turn_takes_too_long(found):
    # At 0.9°/s it needs one to three minutes to get 340 m aside.
    assert found[0].cause is FailureCause.MISSED_LATER
    assert 60.0 < found[0].time_s - found[0].last_way_out_s < 400.0


def test_a_ship_in_the_way_from_the_start_leaves_none(found):
    assert found[2].cause is FailureCause.UNKNOWN
    assert found[2].last_way_out_s is None
    observation = explained(StraightPilot(), batch([ON_TOP]), Event.INTRUSION, Hopeful())
    assert [f.cause for f in observation] == [FailureCause.UNAVOIDABLE]
    assert observation[0].searched
    assert not observation[0].oracle_clear


def test_company_is_who_stood_in_the_way():
    def shy(observation):
        """To starboard, but not with two ships in sight."""
        return jnp.where(observation.present.sum() == 1, 1.0, 0.0)

    pilot = FunctionPilot(shy, "shy", True)
    found = explained(pilot, batch([AHEAD, BESIDE]))
    assert len(found) == 1
    assert not found[0].alone
    assert found[0].n_contributing == 1


def test_intrusions_are_deeper_than_zero_and_the_table_counts_them():
    found = explained(StraightPilot(), batch([AHEAD], [BESIDE]), Event.INTRUSION)
    assert [f.case for f in found] == [0]
    table = summary_table(found)
    assert "| way out missed later | 1 of 1 | 1 | 0 |" in table


def test_every_failure_has_failed_and_not_before_it_began():
    """In encounters as they are drawn; at the start nobody is in the domain yet."""
    learned = pilot_named("large-ship-sum")
    encounters = random_suite(SHIPS["large_ship"], 128).cases
    for pilot, event in ((learned, Event.INTRUSION), (StraightPilot(), Event.COLLISION)):
        found = explain_failures(pilot, StraightPilot(), None, encounters, event)
        assert len(found) > 2
        for f in found:
            assert f.time_s > 0
            assert f.depth > 0
            assert event is Event.INTRUSION or f.nearest_m < 340.0


def test_nothing_to_explain():
    assert explained(StraightPilot(), batch([BESIDE])) == []
