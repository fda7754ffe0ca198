"""What of the reports a picture believes, and which time it says it is."""

import math
from datetime import UTC, datetime

import pytest
from tests.live.reports import SHIP, at, own, ship, taken, targets

from glasshelm.ais import traffic_time
from glasshelm.ais.reports import RejectReason, Report


@pytest.mark.parametrize(
    ("said", "why"),
    [
        ({"north_m": 9000.0}, RejectReason.JUMP),
        ({"course_rad": 0.5}, RejectReason.JUMP),
        ({"seconds": -1.0}, RejectReason.LATE),
        ({"seconds": 0.0}, RejectReason.DUPLICATE),
        ({"speed_m_s": 40.0}, RejectReason.IMPLAUSIBLE),
        ({"speed_m_s": math.nan}, RejectReason.IMPLAUSIBLE),
        ({"course_rad": math.inf}, RejectReason.IMPLAUSIBLE),
        ({"length_m": -5.0}, RejectReason.IMPLAUSIBLE),
        ({"north_m": math.nan}, RejectReason.IMPLAUSIBLE),
        ({"north_m": 1e9}, RejectReason.IMPLAUSIBLE),
        ({"number": "x" * 1000}, RejectReason.IMPLAUSIBLE),
        ({"seconds": 1e6}, RejectReason.TIME_JUMP),
    ],
)
def test_what_is_not_believed_is_counted_and_changes_nothing(said, why):
    picture = taken(own(), ship(1, 0, 2000.0))
    before = targets(picture, 2)
    said = {"number": 1, "seconds": 2.0, "north_m": 1990.0} | said
    assert picture.update(ship(**said)) is why
    assert picture.counts.rejected[why] == 1
    assert targets(picture, 2) == before
    assert picture.counts.pending == 0


def test_reports_that_agree_outweigh_the_track_before_them():
    picture = taken(own(), ship(1))
    refused = [picture.update(ship(1, 10 * k, 9000.0 - 50 * k)) for k in (1, 2, 3)]
    assert refused == [RejectReason.JUMP, RejectReason.JUMP, None]
    assert targets(picture, 30)["1"][1] == pytest.approx(8850, rel=2e-3)
    # Scattered ones do not.
    wild = [picture.update(ship(1, 30 + k, 3e4 * k)) for k in (1, 2, 3, 4)]
    assert set(wild) == {RejectReason.JUMP}


def test_a_ship_may_turn_and_a_stopped_ship_may_swing():
    picture = taken(own(), ship(1))
    assert picture.update(ship(1, 6, 1980.0, course_rad=math.pi - 0.7)) is None
    assert picture.update(ship(1, 60, 1900.0, course_rad=0.5)) is None
    picture.update(ship(2, 0, speed_m_s=0.1))
    assert picture.update(ship(2, 3, speed_m_s=0.1, course_rad=1.0)) is None


def test_a_recording_that_begins_anew_is_followed():
    picture = taken(*(own(s, 5.0 * s) for s in range(0, 600, 10)), ship(1, 590))
    again = [picture.update(own(s, 5.0 * s)) for s in range(0, 60, 10)]
    assert set(again) == {RejectReason.LATE}  # the other ship is still where the time was
    picture.update(ship(1, 55))
    assert picture.update(own(60, 300.0)) is None
    assert picture.latest_time == at(60)
    scenario = picture.scenario(at(60), SHIP)
    assert any("went back by 8.9 min: the picture began anew" in note for note in scenario.notes)
    assert set(targets(picture, 60)) == {"1"}  # heard anew


def test_a_gap_is_passed_over_when_most_ships_have():
    picture = taken(own(), ship(1), ship(2, 0, 3000.0))
    later = [picture.update(own(7200 + k, 36000 + 5 * k)) for k in range(5)]
    assert set(later) == {RejectReason.TIME_JUMP}
    assert "own ship (2 h ahead)" in picture.status(at(5))
    assert picture.update(ship(1, 7205)) is None
    assert picture.update(own(7210, 36050)) is None
    assert picture.latest_time == at(7210)
    assert set(targets(picture, 7210)) == {"1"}
    notes = picture.scenario(at(7210), SHIP).notes
    assert "a gap of 2 h in the time of the traffic was passed over" in notes


def test_who_has_another_clock_is_named_and_takes_nobody_along():
    """The ship of 2037: one ship, three reports of an instant, again and again."""
    picture = taken(own(), ship(1))
    for seconds in range(10, 300, 10):
        picture.update(own(seconds, 5.0 * seconds))
        picture.update(ship(1, seconds, 2000.0 - 5 * seconds))
        for _ in range(3):
            refused = picture.update(ship(257063770, 7e8 + seconds, 900.0, name="LATE RISER"))
            assert refused is RejectReason.TIME_JUMP
    scenario = picture.scenario(at(290), SHIP)
    assert picture.latest_time == at(290)
    assert set(targets(picture, 290)) == {"1"}
    assert [n for n in scenario.notes if "not believed" in n] == [
        "a clock that most others contradict is not believed: MMSI 257063770 (8,102 days ahead)"
    ]


def test_a_report_of_a_clock_somewhat_ahead_is_of_now():
    """It does not block the ship's own later ones, which come by a station with another clock."""
    picture = taken(own(), ship(1), ship(2, 0, 4000.0))
    for seconds in range(10, 100, 10):
        picture.update(own(seconds, 5.0 * seconds))
        picture.update(ship(2, seconds + 400, 4000.0 - 5 * seconds))
        assert picture.update(ship(1, seconds, 2000.0 - 5 * seconds)) is None
    assert picture.latest_time == at(90)
    picture.update(own(95, 5.0 * 95))
    assert picture.update(ship(2, 95, 4000.0 - 5 * 95)) is None
    assert targets(picture, 95)["2"][4] == pytest.approx(0)


def test_one_instant_is_one_witness_of_a_jump():
    """The same message by three stations, or three values of one instant, move nobody."""
    picture = taken(own(), ship(1))
    assert {picture.update(ship(1, 10, 9000.0)) for _ in range(5)} == {RejectReason.JUMP}
    stations = [picture.update(ship(1, 10 + k / 2, 9000.0)) for k in range(4)]
    assert set(stations) == {RejectReason.JUMP}
    assert targets(picture, 12)["1"][1] == pytest.approx(2000, rel=0.05)


def test_two_ships_with_one_number_are_both_shown():
    picture = taken(own(), ship(1, 0, 9000.0))
    for seconds in range(10, 200, 10):
        picture.update(own(seconds, 5.0 * seconds))
        picture.update(ship(1, seconds, 9000.0 - 5 * seconds))
        picture.update(ship(1, seconds + 3, 2000.0 - 5 * seconds, name="TWIN"))
    seen = targets(picture, 193)
    assert set(seen) == {"1", "1-2"}
    apart = seen["1"][1] - seen["1-2"][1]
    assert apart == pytest.approx(9000 - 5 * 193 - (2000 - 5 * 190), abs=20)
    scenario = picture.scenario(at(193), SHIP)
    assert {t.name for t in scenario.targets if t.id} == {"TWIN", "TWIN (second)"}
    assert "two ships use one number, both are shown: MMSI 1" in scenario.notes
    # One of them is heard no more: she is lost and forgotten, and nothing is remarked on.
    for seconds in range(200, 1200, 10):
        picture.update(own(seconds, 5.0 * seconds))
        picture.update(ship(1, seconds, 9000.0 - 5 * seconds))
    assert set(targets(picture, 1190)) == {"1"}
    assert not any("two ships" in n for n in picture.scenario(at(1190), SHIP).notes)


def test_the_time_of_the_stream_goes_on_when_nothing_is_heard(monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(traffic_time.time, "monotonic", lambda: clock[0])
    picture = taken(own(3.0))
    clock[0] += 40
    assert picture.now() == at(43)
    # An identity dated by another clock moves nothing.
    picture.update(Report(id="1", time=datetime(2026, 1, 1, tzinfo=UTC), name="X"))
    assert picture.latest_time == at(3)
