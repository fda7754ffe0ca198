import pytest
from tests.bridge.frames import Other, frame

from glasshelm.colregs.classification import EncounterType
from glasshelm.colregs.encounter_tracker import EncounterTracker
from glasshelm.colregs.rule_text import ROLES

#: name -> a target who comes to own ship's place in 600 s, and what own ship is to her.
MEETINGS = {
    "head-on": (Other(), ("head-on", "give-way", "14")),
    "from starboard": (Other(east_m=3000.0, north_m=3000.0, course_deg=270.0),
                       ("crossing", "give-way", "15")),
    "from port": (Other(east_m=-3000.0, north_m=3000.0, course_deg=90.0),
                  ("crossing", "stand-on", "17")),
    "slower ahead": (Other(north_m=1800.0, course_deg=0.0, speed_m_s=2.0),
                     ("overtaking", "give-way", "13")),
    "faster astern": (Other(north_m=-1800.0, course_deg=0.0, speed_m_s=8.0),
                      ("overtaken", "stand-on", "17")),
}  # fmt: skip


@pytest.mark.parametrize("name", MEETINGS)
def test_rules_13_to_17_until_the_closest_approach_is_past(name):
    other, wanted = MEETINGS[name]
    tracker = EncounterTracker()
    for time_s in range(0, 600, 50):
        role = ROLES[tracker.update(frame(time_s, other))["1"]]
        assert role == wanted, time_s
    role = ROLES[tracker.update(frame(650, other))["1"]]
    assert role == ("none", "none", None)


def test_the_kind_is_taken_at_first_risk_and_does_not_change():
    """Rule 13(d): no later alteration of bearing makes a crossing of an overtaking."""
    tracker = EncounterTracker()
    slow = Other(north_m=1800.0, course_deg=0.0, speed_m_s=2.0)
    tracker.update(frame(0, slow))
    types = tracker.update(frame(5, Other(east_m=1500.0, north_m=1500.0, course_deg=270.0)))
    assert types["1"] == EncounterType.OVERTAKING


def test_ships_keep_their_meetings_as_others_come_and_go():
    tracker = EncounterTracker()
    ahead, starboard = Other("a"), MEETINGS["from starboard"][0]
    others = [Other(str(k), north_m=-9000.0 - k) for k in range(9)]
    tracker.update(frame(0, ahead))
    for time_s, seen in ((5, [*others, starboard, ahead]), (10, [ahead, starboard]), (15, [ahead])):
        types = tracker.update(frame(time_s, *seen))
        assert types["a"] == EncounterType.HEAD_ON
    assert list(types) == ["a"]
    assert tracker.update(frame(20)) == {}


def test_no_risk_no_rule():
    types = EncounterTracker().update(frame(0, Other(east_m=15_000.0), Other("2", lost=True)))
    assert list(types.values()) == [EncounterType.NONE, EncounterType.NONE]


def test_a_ship_that_stops_is_in_no_meeting():
    """What is left of her course is the noise of her position."""
    tracker = EncounterTracker()
    assert tracker.update(frame(0, Other(speed_m_s=0.4)))["1"] == EncounterType.HEAD_ON
    assert tracker.update(frame(5, Other(speed_m_s=0.2)))["1"] == EncounterType.NONE
    assert (
        tracker.update(frame(10, Other(speed_m_s=0.0, course_deg=0.0)))["1"] == EncounterType.NONE
    )
