import pytest
from tests.bridge.frames import Other, frame

from glasshelm.colregs.encounter_tracker import EncounterTracker

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
    rules = EncounterTracker()
    for time_s in range(0, 600, 50):
        told = rules.update(frame(time_s, other))["1"]
        assert (told.type, told.role, told.rule) == wanted, time_s
    told = rules.update(frame(650, other))["1"]
    assert (told.type, told.role, told.rule) == ("none", "none", None)


def test_the_kind_is_taken_at_first_risk_and_does_not_change():
    """Rule 13(d): no later alteration of bearing makes a crossing of an overtaking."""
    rules = EncounterTracker()
    slow = Other(north_m=1800.0, course_deg=0.0, speed_m_s=2.0)
    rules.update(frame(0, slow))
    told = rules.update(frame(5, Other(east_m=1500.0, north_m=1500.0, course_deg=270.0)))["1"]
    assert told.type == "overtaking"


def test_ships_keep_their_meetings_as_others_come_and_go():
    rules = EncounterTracker()
    ahead, starboard = Other("a"), MEETINGS["from starboard"][0]
    others = [Other(str(k), north_m=-9000.0 - k) for k in range(9)]
    rules.update(frame(0, ahead))
    for time_s, seen in ((5, [*others, starboard, ahead]), (10, [ahead, starboard]), (15, [ahead])):
        told = rules.update(frame(time_s, *seen))
        assert told["a"].type == "head-on"
    assert list(told) == ["a"]
    assert rules.update(frame(20)) == {}


def test_no_risk_no_rule():
    told = EncounterTracker().update(frame(0, Other(east_m=15_000.0), Other("2", lost=True)))
    assert [m.type for m in told.values()] == ["none", "none"]


def test_a_ship_that_stops_is_in_no_meeting():
    """What is left of her course is the noise of her position."""
    rules = EncounterTracker()
    assert rules.update(frame(0, Other(speed_m_s=0.4)))["1"].type == "head-on"
    assert rules.update(frame(5, Other(speed_m_s=0.2)))["1"].type == "none"
    assert rules.update(frame(10, Other(speed_m_s=0.0, course_deg=0.0)))["1"].type == "none"
