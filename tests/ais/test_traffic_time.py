"""Which time it is: by a majority of witnesses, and no verdict is for ever."""

import random
from datetime import UTC, datetime

import pytest

from glasshelm.ais import traffic_time
from glasshelm.ais.reports import Counts
from glasshelm.ais.traffic_time import (
    MAX_REJECTED,
    MAX_SOURCES,
    MAX_TIMELINES,
    StreamClock,
    TrafficTime,
)

T0 = 1_408_129_200.0
HOUR = 3600.0
YEAR_2037 = 2_133_435_904.0 - T0
#: GPS receivers that count weeks with ten bits come out 1,024 weeks early.
ROLL_OVER = -1024 * 7 * 86400.0


class Stream:
    """Tells a TrafficTime what witnesses claim; no time passes by itself."""

    def __init__(self):
        self.time = TrafficTime()

    def tell(self, witness, seconds, off=0.0):
        return self.time.update(T0 + seconds + off, witness)

    def hear(self, first, last, every=5, off=0.0, ships=("own", "a", "b", "c")):
        """All ships in turn; whether each claim was believed."""
        return [
            self.tell(ship, float(second), off)
            for second in range(first, last, every)
            for ship in ships
        ]

    @property
    def now(self):
        """Seconds since T0."""
        return self.time.latest_s - T0


@pytest.fixture(autouse=True)
def still(monkeypatch):
    """A monotonic clock that stands, and a wall clock of another year than the streams'."""
    clock = type("Clock", (), {"now": 0.0, "wall": T0 + 12 * 365 * 86400.0})()
    monkeypatch.setattr(traffic_time.time, "monotonic", lambda: clock.now)
    monkeypatch.setattr(traffic_time.time, "time", lambda: clock.wall)
    return clock


@pytest.mark.parametrize("off", [12 * HOUR, -12 * HOUR, YEAR_2037, -T0, ROLL_OVER, 700.0])
@pytest.mark.parametrize(("burst", "witnesses"), [(1, 1), (3, 1), (30, 1), (3, 3), (30, 30)])
def test_a_burst_of_a_few_moves_nothing(off, burst, witnesses):
    stream = Stream()
    stream.hear(0, 60)
    for k in range(burst):
        assert not stream.tell(f"bad{k % witnesses}", 60 + k, off)
    assert stream.now == 55
    assert all(stream.hear(60, 300))
    assert stream.now == 295


def test_three_things_said_at_one_instant_are_said_once():
    stream = Stream()
    stream.tell("own", 0.0)
    assert [stream.tell("own", 0.0, YEAR_2037) for _ in range(5)] == [False] * 5
    assert stream.now == 0


@pytest.mark.parametrize("off", [300.0, 500.0])
def test_a_clock_some_minutes_ahead_ages_nobody(off):
    """Its reports are taken; the time stays that of most, or all others would be old."""
    stream = Stream()
    for second in range(0, 300, 5):
        assert stream.tell("bad", second, off) or second == 0
        assert all(stream.hear(second, second + 1))
    assert stream.now == 295


@pytest.mark.parametrize("off", [12 * HOUR, -12 * HOUR, YEAR_2037, -T0, ROLL_OVER, 400.0])
def test_who_is_wrong_first_is_outvoted(off):
    stream = Stream()
    stream.tell("bad", 0, off)
    stream.hear(0, 20)
    assert stream.now == 15
    assert all(stream.hear(20, 60))
    assert stream.tell("bad", 60, off) is (off == 400.0)


@pytest.mark.parametrize("off", [12 * HOUR, -12 * HOUR, YEAR_2037])
def test_a_wrong_majority_heals_when_it_is_over(off):
    stream = Stream()
    stream.hear(0, 60)
    bad = [f"bad{k}" for k in range(9)]
    stream.hear(60, 150, off=off, ships=bad)
    assert stream.now == pytest.approx(145 + off)
    # Only the first ones speak on, fewer than those before.
    stream.hear(150, 350)
    assert stream.now == 345


@pytest.mark.parametrize("off", [12 * HOUR, -12 * HOUR])
def test_ships_that_a_wrong_station_told_of_come_back_at_once(off):
    stream = Stream()
    stream.hear(0, 60)
    stream.hear(60, 120, off=off)
    stream.hear(120, 130)
    assert stream.now == 125


def test_of_two_stations_the_one_of_more_ships_is_believed():
    stream = Stream()
    few, many = ["x", "y"], ["own", "a", "b", "c"]
    for second in range(0, 600, 10):
        stream.hear(second, second + 1, off=12 * HOUR, ships=few)
        stream.hear(second, second + 1, ships=many)
    assert stream.now == 590


@pytest.mark.parametrize("gap", [3 * HOUR, 86400.0, 400.0])
@pytest.mark.parametrize("ships", [("own", "a", "b", "c"), ("own", "d"), ("d", "e", "f", "g", "h")])
def test_a_gap_is_followed_soon(gap, ships):
    stream = Stream()
    stream.hear(0, 60)
    refused = stream.hear(60, 300, off=gap, ships=ships).count(False)
    assert stream.now == 295 + gap
    assert refused <= len(ships) * 190 / 5


@pytest.mark.parametrize("lasts", [120, 300, 900, 7200])
@pytest.mark.parametrize("ships", [("own",), ("own", "a", "b", "c")])
def test_a_recording_that_is_played_again_and_again(lasts, ships):
    stream = Stream()
    for _ in range(3):
        stream.hear(0, lasts, ships=ships)
        assert stream.now == lasts - 5
        stream.hear(0, 20, ships=ships)
        assert stream.now == 15


@pytest.mark.parametrize("off", [HOUR, -HOUR, ROLL_OVER, -ROLL_OVER, 300.0, -300.0, -90.0])
def test_own_ship_alone_may_correct_her_clock(off, still):
    for wall in (T0, T0 + off, still.wall):
        still.wall = wall
        stream = Stream()
        stream.hear(0, 60, 1, ships=["own"])
        stream.hear(60, 70, 1, off=off, ships=["own"])
        assert stream.now == 69 + off


def test_a_single_wrong_time_of_own_ship_alone_is_passed_over():
    stream = Stream()
    stream.hear(0, 60, 1, ships=["own"])
    assert not stream.tell("own", 60, YEAR_2037)
    assert all(stream.hear(61, 90, 1, ships=["own"]))
    assert stream.now == 89


def test_a_slow_way_is_no_wrong_clock():
    """A second station that is 90 s late, and tells of the same ships."""
    stream = Stream()
    stream.hear(0, 100)
    for second in range(100, 400, 5):
        assert all(stream.hear(second, second + 1))
        assert all(stream.hear(second, second + 1, off=-90.0))
    assert stream.now == 395


def test_a_sparse_recording_goes_on():
    stream = Stream()
    claims = [stream.tell("ab"[k % 2], 250.0 * k) for k in range(40)]
    assert all(claims)
    assert stream.now >= 250.0 * 38
    alone = Stream()
    assert [alone.tell("a", 500.0 * k) for k in range(40)] == [True] * 40
    assert alone.now == 500.0 * 39


def test_this_machine_s_clock_is_one_more_witness_and_never_needed(still):
    for wall, decides in ((T0, True), (T0 - 12 * HOUR, False)):
        still.wall = wall
        stream = Stream()
        stream.hear(0, 10, ships=["bad"], off=12 * HOUR)
        stream.hear(10, 60, ships=["good"])
        assert (stream.now == 55) is decides


def test_time_that_passes_in_silence_is_no_jump(still):
    stream = Stream()
    stream.hear(0, 60)
    still.now = 3 * HOUR
    assert stream.time.now_s == T0 + 55 + 3 * HOUR
    assert stream.tell("z", 3 * HOUR)


def test_memory_is_bounded_and_nothing_is_refused_for_good():
    stream, chance = Stream(), random.Random(0)
    stream.hear(0, 60)
    for k in range(5 * MAX_SOURCES):
        stream.tell(str(k), 60, chance.choice([0.0, 1e9, chance.uniform(-1e9, 1e9)]))
    time = stream.time
    assert len(time._timelines) <= MAX_TIMELINES
    assert len(time._timeline_of) == sum(len(line.sources) for line in time._timelines)
    assert len(time._believed_times) <= 2 * MAX_SOURCES
    assert len(time._rejected) <= MAX_REJECTED
    assert all(len(line.sources) <= MAX_SOURCES for line in time._timelines)
    stream.hear(60, 400)
    assert stream.now == 395


def test_whose_clock_is_wrong_is_said_in_one_line():
    stream = Stream()
    stream.hear(0, 60)
    assert stream.time.rejected_clocks() is None
    stream.tell("station:HARBOR", 60, 12 * HOUR)
    stream.tell("257000001", 60, -2 * HOUR)  # perhaps an old report: not named yet
    assert stream.time.rejected_clocks() == (
        "a clock that most others contradict is not believed: station HARBOR (12 h ahead)"
    )
    stream.tell("257000001", 65, -2 * HOUR)
    for k in range(3):
        stream.tell(f"25700001{k}", 65, YEAR_2037)
    told = stream.time.rejected_clocks()
    assert "\n" not in told
    assert told.endswith("and 2 more")
    stream.tell("station:HARBOR", 70)
    assert "HARBOR" not in stream.time.rejected_clocks()
    stream.hear(70, 800)
    assert stream.time.rejected_clocks() is None


def test_the_clock_of_a_stream_is_moved_by_no_time_that_is_not_believed():
    counts = Counts()
    clock = StreamClock(live=False, counts=counts)
    assert clock.now() is None

    def at(seconds):
        return datetime.fromtimestamp(T0 + seconds, UTC)

    for second in range(10):
        for ship in ("a", "b"):
            assert clock.update(at(second), ship) == at(second)
    assert clock.update(at(12 * HOUR), "station:HARBOR") is None
    assert clock.now() == at(9)
    assert "station HARBOR (12 h ahead)" in counts.summary()
    assert StreamClock(live=True).now().year >= 2026
