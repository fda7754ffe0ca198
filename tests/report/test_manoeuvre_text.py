"""A manoeuvre in words."""

import math

import msgspec
import pytest
from tests.voyages import Other, voyage

from glasshelm.frames.schema import BySubTask, Manoeuvre
from glasshelm.report.current_sentence import current_sentence
from glasshelm.report.manoeuvre_text import manoeuvre_reasons, order_text

AURORA, BRAVO = Other("Aurora", 3000.0, 3000.0, 270.0), Other("Bravo", -3000.0, 3000.0, 90.0)


def sailed(**fields):
    frame = voyage([0.0, 0.0], [AURORA, BRAVO])[-1]
    return msgspec.structs.replace(frame, **fields)


def ids(frame, *names):
    return [t.id for t in frame.targets if t.name in names]


@pytest.mark.parametrize(
    ("manoeuvre", "text"),
    [
        (Manoeuvre(math.radians(60), 400.0), "060° for 6.7 min"),
        (Manoeuvre(math.radians(-30), 0.0), "330° to the waypoint"),
        (Manoeuvre(0.0, 100.0, math.radians(90), 1000.0), "000° for 1.7 min, then 090° for 17 min"),
    ],
)
def test_golden_orders(manoeuvre, text):
    assert order_text(manoeuvre) == text


def test_reasons_name_the_needed_ships_and_the_time_left():
    frame = sailed(priority=BySubTask(-2.0, 40.0, 37.0, -1.0), last_safe_s=240.0)
    both = msgspec.structs.replace(frame, needed=ids(frame, "Aurora", "Bravo"))
    assert manoeuvre_reasons(both) == (
        "for Aurora and Bravo: without them another course would be steered; "
        "worth 37.0 points more than keeping on; safe to wait for 4 min at most"
    )
    one = msgspec.structs.replace(frame, needed=ids(frame, "Bravo"), last_safe_s=None)
    assert manoeuvre_reasons(one).startswith("for Bravo: without it another")
    assert manoeuvre_reasons(one).endswith("no manoeuvre is safe any more")
    calm = sailed(needed=[], priority=BySubTask(0.0, 0.0, 0.0, 0.0), last_safe_s=2400.0)
    assert manoeuvre_reasons(calm) == "no ship changes the course"


def test_the_sentence_of_an_instant_says_course_and_reason():
    frame = sailed(manoeuvre=Manoeuvre(math.radians(60), 400.0), needed=[], last_safe_s=2400.0)
    sentence = current_sentence([frame])
    assert sentence.what.startswith("Steer 060° for 6.7 min (rudder")
    assert sentence.why == "No ship changes the course"
