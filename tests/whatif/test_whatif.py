"""A branch must go on as the log did; a change must do what it says, and nothing else."""

import time

import jax
import msgspec
import numpy as np
import pytest
from tests.untrained import untrained

from glasshelm.core.errors import InputError
from glasshelm.encounters.random_encounters import random_scenario
from glasshelm.encounters.scenario_factory import scenario_from
from glasshelm.frames.schema import Frame
from glasshelm.pilots.registry import WITHOUT_WEIGHTS, pilot_named
from glasshelm.pilots.straight import StraightPilot
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.frame_builder import DECIMALS
from glasshelm.simulation.voyage import Voyage, simulate
from glasshelm.whatif.ask import what_if
from glasshelm.whatif.branch import branch_at
from glasshelm.whatif.changes import Deleted, Hidden, KeptCourse, Rudder
from glasshelm.whatif.counterfactual_rollout import BranchRollout, roll_out
from glasshelm.whatif.outcome import differences, outcome_of

pytestmark = pytest.mark.slow

SHIP = SHIPS["paper"]
STEPS = 60
#: What the log's rounding and the first decision after it may differ by [rad]: 0.001 degrees.
ROUNDED_RAD = 20 * 10.0**-DECIMALS


def logged(frames) -> list[Frame]:
    """The frames as a log gives them back."""
    encoder, decoder = msgspec.json.Encoder(), msgspec.json.Decoder(Frame)
    return [decoder.decode(encoder.encode(frame)) for frame in frames]


@pytest.fixture(scope="module")
def learned():
    return pilot_named("paper-attention")


@pytest.fixture(scope="module")
def imazu_log(learned):
    """Imazu's case 5: one ship ahead, one crossing from starboard; she alters to port at once."""
    return logged(simulate(scenario_from("imazu:5", SHIP), learned, 2 * STEPS))


@pytest.fixture(scope="module")
def advice_log(learned):
    """A recording with ships that come, are lost, and are not shown to the pilot."""
    return logged(simulate(scenario_from("gulf-of-finland", SHIP), learned, 60, advise=True))


@pytest.mark.parametrize("number", [0, 2, 4, 37, 119])
def test_branch_decides_as_the_log_did(imazu_log, learned, number):
    sailed = roll_out(branch_at(imazu_log, number, learned, 1), (), 1)
    assert abs(sailed.rudder_rad[0] - imazu_log[number].decision.rudder_rad) < ROUNDED_RAD


@pytest.mark.parametrize("number", [0, 3, 40, 59])
def test_branch_of_a_recording_decides_as_the_log_did(advice_log, learned, number):
    frame = advice_log[number]
    sailed = roll_out(branch_at(advice_log, number, learned, STEPS), (), STEPS)
    assert abs(sailed.rudder_rad[0] - frame.decision.rudder_rad) < ROUNDED_RAD
    # The whole frame is the one that was logged, but for what only a recording knows.
    again = sailed.frames()[0]
    assert [t.id for t in again.targets] == [t.id for t in frame.targets]
    for one, two in zip(again.targets, frame.targets, strict=True):
        assert (one.lost, one.selected, one.name) == (two.lost, two.selected, two.name)
        assert one.range_m == pytest.approx(two.range_m, rel=1e-5)
        assert one.danger == pytest.approx(two.danger, abs=1e-5)
        assert one.latitude_deg == pytest.approx(two.latitude_deg, abs=1e-6)
    assert again.time_utc[:19] == frame.time_utc[:19]


@pytest.mark.parametrize("name", ["paper-cpa", "paper-waypoint"])
def test_what_a_pilot_keeps_in_mind_is_rebuilt(name):
    """These choose a course every sixth decision: a branch in between must not choose anew."""
    pilot = WITHOUT_WEIGHTS[name]
    frames = logged(simulate(random_scenario(35, SHIP), pilot, 40))
    branch = branch_at(frames, 15, pilot, 20)
    assert int(branch.initial.memory.age) == 15
    sailed = roll_out(branch, (), 20)
    wanted = [f.decision.rudder_rad for f in frames[15:36]]
    np.testing.assert_allclose(sailed.rudder_rad, wanted, atol=1e-4)


def test_who_had_the_helm_is_rebuilt():
    """The guard looks every twelfth decision: in between a branch goes on as it found then."""
    pilot, ship = pilot_named("large-ship-sum-guarded"), SHIPS["large_ship"]
    frames = logged(simulate(scenario_from("imazu:21", ship), pilot, 40))
    assert frames[15].guard.steers
    sailed = roll_out(branch_at(frames, 15, pilot, 20), (), 20)
    wanted = [f.decision.rudder_rad for f in frames[15:36]]
    np.testing.assert_allclose(sailed.rudder_rad, wanted, atol=1e-4)


def test_an_order_is_no_guards():
    """While a rudder is ordered nobody else has the helm, whatever the guard would do."""
    pilot, ship = pilot_named("large-ship-sum-guarded"), SHIPS["large_ship"]
    frames = logged(simulate(scenario_from("imazu:21", ship), pilot, 20))
    told = what_if(frames, 13, pilot, [Rudder(5.0, 30.0)], minutes=1.0, explained=True)
    ordered = told.counterfactual.frames()
    assert all(f.guard.steers for f in told.factual.frames())
    assert not ordered[0].guard.steers
    assert ordered[0].decision.pilot_rudder_rad is not None
    assert ordered[6].guard.steers


def test_another_pilots_watch_is_not_remembered():
    first, second = WITHOUT_WEIGHTS["paper-waypoint"], WITHOUT_WEIGHTS["paper-cpa"]
    voyage = Voyage(random_scenario(35, SHIP), first, 40)
    frames = voyage.advance(16)
    voyage.change_pilot(second)
    frames = logged([*frames, *voyage.advance(16)])
    branch = branch_at(frames, 20, second, 10)
    assert int(branch.initial.memory.age) == 4
    assert roll_out(branch, (), 10).rudder_rad[0] == pytest.approx(
        frames[20].decision.rudder_rad, abs=1e-4
    )


@pytest.mark.parametrize("number", [0, 20, 60])
def test_unchanged_future_is_the_rest_of_the_log(imazu_log, learned, number):
    left = len(imazu_log) - 1 - number
    sailed = roll_out(branch_at(imazu_log, number, learned, left), (), left)
    again, rest = sailed.frames(), imazu_log[number:]
    assert len(again) == len(rest)
    for one, two in zip(again, rest, strict=True):
        assert one.time_s == two.time_s
        assert np.hypot(one.own.east_m - two.own.east_m, one.own.north_m - two.own.north_m) < 0.05
        assert one.decision.rudder_rad == pytest.approx(two.decision.rudder_rad, abs=1e-4)
    rewards = [[f.reward.total for f in frames[1:]] for frames in (again, rest)]
    np.testing.assert_allclose(*rewards, atol=1e-3)
    assert again[0].reward == rest[0].reward


def test_targets_go_on_as_logged_and_then_straight(advice_log):
    sailed = roll_out(branch_at(advice_log, 20, StraightPilot(), 80), (), 80).frames()
    for one, two in zip(sailed, advice_log[20:], strict=False):
        there = {t.id: t for t in two.targets if not t.lost}
        assert {t.id for t in one.targets if not t.lost} == set(there)
        for t in (t for t in one.targets if not t.lost):
            assert (t.east_m, t.north_m) == (there[t.id].east_m, there[t.id].north_m)
    last, later = ({t.id: t for t in f.targets if not t.lost} for f in (advice_log[-1], sailed[-1]))
    gone_s = sailed[-1].time_s - advice_log[-1].time_s
    assert gone_s == 200.0
    assert set(later) == set(last)
    for id, t in last.items():
        east = t.east_m + gone_s * t.speed_m_s * np.sin(t.course_rad)
        assert later[id].east_m == pytest.approx(east, abs=0.1)


def test_same_question_has_the_same_answer_bit_for_bit(imazu_log, learned):
    one, two = (
        what_if(imazu_log, 10, learned, [Deleted("2")], minutes=5.0, explained=True)
        for _ in range(2)
    )
    for a, b in zip(
        jax.tree.leaves(one.counterfactual.steps),
        jax.tree.leaves(two.counterfactual.steps),
        strict=True,
    ):
        np.testing.assert_array_equal(a, b)
    encode = msgspec.json.Encoder().encode
    assert encode(one.counterfactual.frames()) == encode(two.counterfactual.frames())
    assert one.summary == two.summary


def same(one: BranchRollout, two: BranchRollout) -> bool:
    parts = (
        (one.steps.own, one.steps.decision.rudder, one.reward.waypoint),
        (two.steps.own, two.steps.decision.rudder, two.reward.waypoint),
    )
    return all(np.array_equal(a, b) for a, b in zip(*map(jax.tree.leaves, parts), strict=True))


def test_without_the_only_ship_the_pilot_returns_to_the_waypoints_course(learned):
    frames = logged(simulate(scenario_from("imazu:1", SHIP), learned, 240))
    aside = [abs(bearing(f)) for f in frames]
    number = int(np.argmax(aside))
    assert np.degrees(aside[number]) > 4, "she gives way in this case"
    told = what_if(frames, number, learned, [Deleted("1")], minutes=10.0)
    assert abs(bearing(told.counterfactual.frames()[-1])) < np.radians(1.5)
    assert told.counterfactual_outcome.ships == ()
    assert told.counterfactual_outcome.reward.collision == 0.0
    assert "No other ship would be there" in told.summary


def bearing(frame: Frame) -> float:
    """The waypoint's bearing off the heading."""
    own, to = frame.own, frame.waypoint
    off = np.arctan2(to.east_m - own.east_m, to.north_m - own.north_m) - own.heading_rad
    return float((off + np.pi) % (2 * np.pi) - np.pi)


def test_a_deleted_ship_is_as_if_she_had_never_been(imazu_log, learned):
    """The same decisions, to the bit, as in a log that never had her."""
    never = [msgspec.structs.replace(f, targets=f.targets[:1]) for f in imazu_log]
    one = roll_out(branch_at(imazu_log, 10, learned, STEPS), [Deleted("2")], STEPS)
    two = roll_out(branch_at(never, 10, learned, STEPS), (), STEPS)
    np.testing.assert_allclose(one.rudder_rad, two.rudder_rad, atol=1e-5)


def test_blind_to_a_ship_that_is_not_fed_changes_nothing(advice_log, learned):
    number = 40
    selected = {t.id for f in advice_log[number:] for t in f.targets if t.selected}
    far = max(
        (t for t in advice_log[number].targets if t.id not in selected and not t.lost),
        key=lambda t: t.range_m,
    )
    assert far.range_m > 20_000
    branch = branch_at(advice_log, number, learned, 20)
    assert same(roll_out(branch, [Hidden(far.id)], 20), roll_out(branch, (), 20))


def test_blind_and_deleted_steer_alike_but_only_one_ship_is_there(imazu_log, learned):
    branch = branch_at(imazu_log, 0, learned, 360)
    blind, gone = (roll_out(branch, [change], 360) for change in (Hidden("2"), Deleted("2")))
    np.testing.assert_array_equal(blind.steps.own.east_m, gone.steps.own.east_m)
    told = outcome_of(blind)
    assert {ship.id for ship in told.ships} == {"1", "2"}
    assert {ship.id for ship in outcome_of(gone).ships} == {"1"}
    met = next(ship for ship in told.ships if ship.id == "2")
    assert (met.danger > 0) == (told.reward.collision < 0)
    assert not any(t.selected for f in blind.frames() for t in f.targets if t.id == "2")


def test_a_ship_that_keeps_her_course_goes_straight(advice_log):
    """A ship that turns in the log, sailed on straight from the branch."""
    number, steps = 20, 39
    turns = max(
        (abs(late.course_rad - early.course_rad), early.id)
        for early in advice_log[number].targets
        for late in advice_log[-1].targets
        if early.id == late.id and not early.lost and not late.lost and early.speed_m_s > 2
    )
    assert turns[0] > 0.05
    branch = branch_at(advice_log, number, StraightPilot(), steps)
    kept = roll_out(branch, [KeptCourse(turns[1])], steps).frames()
    places = np.array([(t.east_m, t.north_m) for f in kept for t in f.targets if t.id == turns[1]])
    assert len(places) == steps + 1
    begin = next(t for t in advice_log[number].targets if t.id == turns[1])
    run = 5.0 * np.arange(steps + 1)[:, None] * begin.speed_m_s
    way = np.array([np.sin(begin.course_rad), np.cos(begin.course_rad)])
    np.testing.assert_allclose(places, places[0] + run * way, atol=0.1)
    others = {t.id: t.east_m for t in kept[-1].targets if t.id != turns[1] and not t.lost}
    for t in (t for t in advice_log[number + steps].targets if t.id in others):
        assert others[t.id] == t.east_m


def test_own_ship_that_keeps_her_course_goes_straight(imazu_log, learned):
    sailed = roll_out(branch_at(imazu_log, 5, learned, STEPS), [KeptCourse()], STEPS)
    assert np.ptp(sailed.heading_rad) == 0.0
    assert not sailed.rudder_rad.any()


def test_an_ordered_rudder_is_held_and_then_the_pilot_decides(imazu_log, learned):
    """Five degrees for 20 s: what Nomoto's model says (Eq. 6), then the pilot's own rudder."""
    branch = branch_at(imazu_log, 0, learned, STEPS)
    sailed = roll_out(branch, [Rudder(-5.0, 20.0)], STEPS)
    np.testing.assert_allclose(sailed.rudder_rad[:4], -np.radians(5), rtol=1e-6)
    assert abs(sailed.rudder_rad[4] + np.radians(5)) > 1e-4
    lag, gain = SHIP.time_constant_s, SHIP.gain_1_s
    turned = -gain * np.radians(5) * (20.0 - lag * (1 - np.exp(-20.0 / lag)))
    assert sailed.heading_rad[4] - sailed.heading_rad[0] == pytest.approx(turned, rel=1e-4)
    parted = differences(roll_out(branch, (), STEPS), sailed)
    assert parted.diverge_s == 0.0


def test_frames_of_a_changed_future_say_so_and_explain(imazu_log, learned):
    told = what_if(imazu_log, 10, learned, [Rudder(5.0, 30.0)], minutes=2.0, explained=True)
    frames = told.counterfactual.frames()
    assert frames[0].decision.rudder_rad == pytest.approx(np.radians(5), abs=1e-6)
    assert frames[0].source == "imazu:5, with the rudder 5° to starboard for 30 s from 50 s"
    # The value is that of the ordered rudder: the end of the sweep.
    edge = frames[0].sweep.waypoint[-1]
    assert frames[0].value.waypoint == pytest.approx(edge, abs=1e-4)
    # Shares would be those of the pilot's own rudder: he is named beside the order instead.
    logged = imazu_log[10].decision
    assert frames[0].decision.pilot_rudder_rad == pytest.approx(logged.rudder_rad, abs=ROUNDED_RAD)
    assert frames[0].decision.base_rad is None
    assert all(t.shapley_rad is None and t.intention is None for t in frames[0].targets)
    after = next(f for f in frames if f.time_s >= frames[0].time_s + 30)
    assert after.decision.pilot_rudder_rad is None
    assert all(t.shapley_rad is not None for t in after.targets)
    assert frames[0].reward == imazu_log[10].reward


def test_numbers_of_a_future_are_those_of_its_frames(imazu_log, learned):
    told = what_if(imazu_log, 0, learned, [Hidden("2")], minutes=30.0)
    for sailed, numbers in (
        (told.factual, told.factual_outcome),
        (told.counterfactual, told.counterfactual_outcome),
    ):
        frames = sailed.frames()
        range_m, id = min((t.range_m, t.id) for f in frames for t in f.targets)
        assert numbers.nearest.id == id
        assert numbers.nearest.closest_m == pytest.approx(range_m, abs=1e-3)
        total = sum(f.reward.total for f in frames[1:])
        assert numbers.reward.total == pytest.approx(total, abs=1e-3)
        inside = 5.0 * sum(any(t.danger > 0 for t in f.targets) for f in frames[1:])
        assert numbers.inside_s == inside


def test_an_untrained_pilot_without_critic_can_be_asked_too():
    pilot = untrained(critic=False)
    frames = logged(simulate(random_scenario(5, SHIP), pilot, 10))
    told = what_if(frames, 10, pilot, [KeptCourse()], minutes=1.0, explained=True)
    assert told.counterfactual.frames()[0].value is None


@pytest.mark.parametrize(
    ("changes", "minutes", "line"),
    [
        ([], 30.0, "nothing is asked"),
        ([Deleted("99")], 30.0, "no ship '99' from this instant on: there are 1, 2"),
        ([Rudder(9.0)], 30.0, "rudder 9°: own ship's goes to 5° on either side"),
        ([Rudder(float("nan"))], 30.0, "rudder nan°"),
        ([Rudder(2.0, -1.0)], 30.0, "-1 s: a rudder is held for more than 0 s"),
        ([Deleted("1")], 0.0, "0 minutes: more than 0"),
        ([Deleted("1")], float("inf"), "inf minutes"),
    ],
)
def test_what_cannot_be_asked_is_told_in_one_line(imazu_log, changes, minutes, line):
    with pytest.raises(InputError) as caught:
        what_if(imazu_log, 0, StraightPilot(), changes, minutes)
    assert line in str(caught.value)
    assert "\n" not in str(caught.value)


def test_frame_outside_the_log_is_refused(imazu_log):
    with pytest.raises(InputError, match="the log has frames 0 to 120"):
        branch_at(imazu_log, 121, StraightPilot(), 10)


def test_half_an_hour_takes_less_than_a_second_once_compiled(imazu_log, learned):
    """Of the processors, who may be busy with others. Measured: 0.05 s with two ships."""
    what_if(imazu_log, 0, learned, [Deleted("1")])
    took = []
    for _ in range(3):
        began = time.process_time()
        told = what_if(imazu_log, 30, learned, [Deleted("2")])
        took.append(time.process_time() - began)
        assert len(told.counterfactual) == 361
    assert min(took) < 1.0
