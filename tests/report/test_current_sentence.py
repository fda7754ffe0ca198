"""The sentence of an instant, on a voyage that is really sailed."""

import math
import re

import msgspec
import numpy as np
import pytest
from tests.report.adding import ROUNDED_DEG, told_sum

import glasshelm
from glasshelm.encounters.scenario_factory import scenario_from
from glasshelm.frames.phrases import cpa_words, rudder_words
from glasshelm.frames.schema import Guard
from glasshelm.report.current_sentence import current_sentence
from glasshelm.ship.nomoto import ship_named
from glasshelm.simulation.voyage import simulate


@pytest.fixture(scope="module")
def frames():
    scenario = scenario_from("random:35", ship_named("paper"))
    return list(simulate(scenario, glasshelm.load("paper-attention"), 24))


def ahead_of(frame, turn_rad):
    """A track of 20 minutes that turns at once and goes straight on."""
    heading = frame.own.heading_rad + turn_rad * np.minimum(np.arange(241) / 12, 1.0)
    east = frame.own.east_m + np.cumsum(5 * frame.own.speed_m_s * np.sin(heading))
    north = frame.own.north_m + np.cumsum(5 * frame.own.speed_m_s * np.cos(heading))
    return np.stack([east, north, heading], axis=1)


@pytest.mark.slow
def test_it_says_what_the_helm_does_and_why(frames):
    turning = next(k for k, f in enumerate(frames) if abs(f.decision.rudder_rad) > 0.01)
    said = current_sentence(frames[: turning + 1])
    side = "starboard" if frames[turning].decision.rudder_rad > 0 else "port"
    assert said.what.startswith("Rudder")
    assert f"to {side}" in said.what
    assert said.why


def test_the_shares_are_those_of_the_rudder_shown(frames):
    """Not means over the turn: they add up to the order beside them."""
    k = next(k for k, f in enumerate(frames) if k > 2 and abs(f.decision.rudder_rad) > 0.02)
    same = current_sentence([*frames[k - 2 : k], frames[k]])
    assert same.why == current_sentence([frames[k]]).why
    last = frames[k]
    total = last.decision.base_rad + sum(t.shapley_rad for t in last.targets if t.selected)
    assert total == pytest.approx(last.decision.rudder_rad, abs=1e-4)


@pytest.fixture(scope="module")
def crowded():
    """Recorded traffic: more ships than the pilot is shown, shares that were sampled, advice."""
    scenario = scenario_from("gulf-of-finland", ship_named("paper"))
    return list(simulate(scenario, glasshelm.load("paper-sum"), 24, advise=True))


@pytest.mark.slow
@pytest.mark.parametrize("voyage", ["frames", "crowded"])
def test_what_is_said_adds_up_to_the_rudder(voyage, request):
    checked = others = 0
    for frame in request.getfixturevalue(voyage):
        rudder = abs(math.degrees(frame.decision.rudder_rad))
        said = current_sentence([frame]).why.split(". ")[0]
        if "°" not in said:
            assert rudder < 0.501, said
            continue
        assert told_sum(said) == pytest.approx(rudder, abs=ROUNDED_DEG), said
        checked += 1
        others += bool(re.search(r"\d others", said))
    assert checked >= 5
    assert others or voyage == "frames"


def test_the_cpa_in_the_sentence_is_the_present_one(frames):
    last = frames[-1]
    said = current_sentence(frames)
    quoted = [t for t in last.targets if cpa_words(t.dcpa_m, t.tcpa_s) in said.why]
    assert quoted, said.why
    assert all(t.name in said.why for t in quoted)


def test_what_comes_is_read_from_the_predicted_track(frames):
    said = current_sentence(frames, ahead_of(frames[-1], math.radians(30)))
    whole = round(math.degrees(frames[-1].own.heading_rad) + 30) % 360
    assert f"To {whole:03d}°" in said.next
    steady = current_sentence(frames, ahead_of(frames[-1], 0.0))
    assert steady.next.startswith("Steady on")
    assert "20 min" in steady.next


def test_an_advice_says_that_it_is_one(frames):
    decision = msgspec.structs.replace(frames[0].decision, applied=False)
    assert current_sentence(
        [msgspec.structs.replace(frames[0], decision=decision)]
    ).what.startswith("Advice:")


@pytest.mark.parametrize(
    ("rudder_deg", "words"),
    [
        (3.44, "rudder 3.4° to starboard"),
        (-0.54, "rudder 0.5° to port"),
        (-0.2, "rudder amidships (0.2° to port)"),
        (0.0, "rudder amidships"),
        (-0.04, "rudder amidships"),
    ],
)
def test_a_rudder_is_said_to_the_tenth_shown_beside_it(frames, rudder_deg, words):
    assert rudder_words(math.radians(rudder_deg)) == words
    decision = msgspec.structs.replace(
        frames[0].decision, rudder_rad=math.radians(rudder_deg), applied=False
    )
    said = current_sentence([msgspec.structs.replace(frames[0], decision=decision)])
    assert said.what.startswith(f"Advice: {words}; course")


def test_where_nothing_is_decided_nothing_is_said(frames):
    assert current_sentence([msgspec.structs.replace(frames[0], decision=None)]) is None


def test_a_lost_ship_is_not_passed(frames):
    gone = [msgspec.structs.replace(t, lost=True) for t in frames[-1].targets]
    last = msgspec.structs.replace(frames[-1], targets=gone)
    said = current_sentence([*frames[:-1], last], ahead_of(frames[-1], 0.0))
    assert "passes" not in said.next


def test_who_has_the_helm_in_the_pilots_place(frames):
    one = frames[-1]
    ship = one.targets[0]
    theirs = msgspec.structs.replace(one.decision, pilot_rudder_rad=math.radians(2), base_rad=None)
    ordered = msgspec.structs.replace(one, decision=theirs)
    assert (
        current_sentence([ordered]).why
        == "Ordered; the pilot himself decides: rudder 2.0° to starboard"
    )
    ahead = Guard(True, ship.id, 300.0, 0.2)
    assert current_sentence([msgspec.structs.replace(ordered, guard=ahead)]).why == (
        f"The guard steers: the pilot's own way (rudder 2.0° to starboard) brings {ship.name} "
        "into the domain in 5 min"
    )
    near = Guard(True, ship.id, 300.0, -0.02)
    advised = msgspec.structs.replace(theirs, applied=False)
    said = current_sentence([msgspec.structs.replace(ordered, guard=near, decision=advised)]).why
    assert said.startswith("The guard advises: ")
    assert said.endswith(f"brings {ship.name} to the edge of the domain in 5 min")
    clear = current_sentence([msgspec.structs.replace(ordered, guard=Guard(True))]).why
    assert clear.startswith("The guard steers until it looks again")
    watching = msgspec.structs.replace(one, guard=Guard(False))
    assert current_sentence([watching]) == current_sentence([one])
