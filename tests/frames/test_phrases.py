import math

import pytest
from tests.voyages import voyage

from glasshelm.core.geometry import CPA_HORIZON_S
from glasshelm.frames import phrases
from glasshelm.frames.series import to_series


@pytest.mark.parametrize(
    ("degrees", "text"),
    [
        (0, "ahead"),
        (-9, "ahead"),
        (45, "on the starboard bow"),
        (-45, "on the port bow"),
        (90, "on the starboard beam"),
        (-135, "on the port quarter"),
        (175, "astern"),
        (-175, "astern"),
    ],
)
def test_bearing_in_words(degrees, text):
    assert phrases.relative_bearing(math.radians(degrees)) == text


def test_distances_are_nautical():
    assert phrases.miles(1852.0) == "1.00 NM"
    assert phrases.miles(555.6) == "0.30 NM"
    assert phrases.miles(46_300.0) == "25.0 NM"


@pytest.mark.parametrize(
    ("seconds", "text"), [(45.0, "45 s"), (150.0, "2.5 min"), (480.0, "8 min")]
)
def test_durations(seconds, text):
    assert phrases.duration(seconds) == text


def test_cpa_in_words():
    assert phrases.cpa_words(555.6, 480.0) == "CPA 0.30 NM in 8 min"
    assert phrases.cpa_words(555.6, -1.0) == "past her CPA"
    assert phrases.cpa_words(555.6, CPA_HORIZON_S) == "no CPA within the hour"


def test_course_has_three_digits_and_wraps():
    assert phrases.course(math.radians(5)) == "005°"
    assert phrases.course(math.radians(-5)) == "355°"
    assert phrases.course(math.radians(359.8)) == "000°"


def test_clock_is_utc_where_the_source_has_one():
    long = voyage([0.0] * 400, time_utc=lambda k: "2020-06-30T09:42:00+00:00")
    assert phrases.clock(to_series(long), 12) == "09:43"
    short = voyage([0.0] * 20, time_utc=lambda k: "2020-06-30T09:42:00Z")
    assert phrases.clock(to_series(short), 1) == "09:42:05"
    assert phrases.clock(to_series(voyage([0.0] * 20)), 12) == "1.0 min"


def test_lists_of_names():
    assert phrases.joined(["a"]) == "a"
    assert phrases.joined(["a", "b", "c"]) == "a, b and c"
