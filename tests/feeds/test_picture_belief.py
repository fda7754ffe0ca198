"""What of the reports a picture believes, and which time it says it is."""

import math
from datetime import UTC, datetime

import pytest
from tests.feeds.reports import SHIP, at, own, ship, taken, targets

from glasshelm.feeds import picture as picture_module
from glasshelm.feeds.types import Refusal, Report


@pytest.mark.parametrize(
    ("said", "why"),
    [
        ({"north_m": 9000.0}, Refusal.JUMP),
        ({"course_rad": 0.5}, Refusal.JUMP),
        ({"seconds": -1.0}, Refusal.LATE),
        ({"seconds": 0.0}, Refusal.REPEATED),
        ({"speed_m_s": 40.0}, Refusal.IMPOSSIBLE),
        ({"speed_m_s": math.nan}, Refusal.IMPOSSIBLE),
        ({"course_rad": math.inf}, Refusal.IMPOSSIBLE),
        ({"length_m": -5.0}, Refusal.IMPOSSIBLE),
        ({"north_m": math.nan}, Refusal.IMPOSSIBLE),
        ({"north_m": 1e9}, Refusal.IMPOSSIBLE),
        ({"number": "x" * 1000}, Refusal.IMPOSSIBLE),
        ({"seconds": 1e6}, Refusal.TIME_JUMP),
    ],
)
def test_what_is_not_believed_is_counted_and_changes_nothing(said, why):
    picture = taken(own(), ship(1, 0, 2000.0))
    before = targets(picture, 2)
    said = {"number": 1, "seconds": 2.0, "north_m": 1990.0} | said
    assert picture.take(ship(**said)) is why
    assert picture.counts.refused[why] == 1
    assert targets(picture, 2) == before
    assert picture.counts.waiting == 0


def test_reports_that_agree_outweigh_the_track_before_them():
    picture = taken(own(), ship(1))
    refused = [picture.take(ship(1, 10 * k, 9000.0 - 50 * k)) for k in (1, 2, 3)]
    assert refused == [Refusal.JUMP, Refusal.JUMP, None]
    assert targets(picture, 30)["1"][1] == pytest.approx(8850, rel=2e-3)
    # Scattered ones do not.
    wild = [picture.take(ship(1, 30 + k, 3e4 * k)) for k in (1, 2, 3, 4)]
    assert set(wild) == {Refusal.JUMP}


def test_a_ship_may_turn_and_a_stopped_ship_may_swing():
    picture = taken(own(), ship(1))
    assert picture.take(ship(1, 6, 1980.0, course_rad=math.pi - 0.7)) is None
    assert picture.take(ship(1, 60, 1900.0, course_rad=0.5)) is None
    picture.take(ship(2, 0, speed_m_s=0.1))
    assert picture.take(ship(2, 3, speed_m_s=0.1, course_rad=1.0)) is None


def test_a_recording_that_begins_anew_is_followed():
    picture = taken(*(own(s, 5.0 * s) for s in range(0, 600, 10)), ship(1, 590))
    again = [picture.take(own(s, 5.0 * s)) for s in range(0, 60, 10)]
    assert again[:3] == [Refusal.LATE, Refusal.LATE, None]
    assert picture.heard == at(50)
    assert targets(picture, 50) == {}
    assert picture.scenario(at(50), SHIP) is not None


def test_after_a_gap_the_time_is_believed_when_three_agree():
    picture = taken(own(), ship(1))
    later = [picture.take(own(7200 + k, 36000 + 5 * k)) for k in range(3)]
    assert later == [Refusal.TIME_JUMP, Refusal.TIME_JUMP, None]
    assert picture.heard == at(7202)
    assert targets(picture, 7202) == {}


def test_the_time_of_the_stream_goes_on_when_nothing_is_heard(monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(picture_module.time, "monotonic", lambda: clock[0])
    picture = taken(own(3.0))
    clock[0] += 40
    assert picture.now() == at(43)
    # An identity dated by another clock moves nothing.
    picture.take(Report(id="1", time=datetime(2026, 1, 1, tzinfo=UTC), name="X"))
    assert picture.heard == at(3)
