import numpy as np
import pytest
from tests.voyages import Other, voyage

from glasshelm.core.errors import InputError
from glasshelm.figures.situation_maps import choose, describe_rudder
from glasshelm.frames.series import to_series


def of(ships, waypoint, rudder=lambda k: -3.0):
    other = Other("A", 3000, 3000, 270, priority=ships)
    headings = [20.0] * 60  # the waypoint lies to port
    return to_series(voyage(headings, [other], waypoint_priority=waypoint, rudder_deg=rudder))


def test_largest_collision_priority_then_the_return():
    v = of(lambda k: 0.3 if k == 10 else 0.0, lambda k: {5: 0.9, 15: 0.8, 40: 0.5}.get(k, 0.0))
    assert choose(v) == [10, 40]  # frame 5 is before, frame 15 less than a minute after


def test_no_return_where_the_rudder_never_turns_to_the_waypoint():
    v = of(lambda k: 0.3 if k == 10 else 0.0, lambda k: 0.5, rudder=lambda k: 3.0)
    assert choose(v) == [10]


def test_given_times_are_taken_as_given():
    v = of(lambda k: 0.0, lambda k: 0.0)
    assert choose(v, [100.0, 50.0]) == [10, 20]


def test_a_time_outside_the_voyage_is_refused():
    with pytest.raises(InputError, match="outside the voyage"):
        choose(of(lambda k: 0.0, lambda k: 0.0), [9999.0])


@pytest.mark.parametrize(
    ("angle", "words"),
    [(3.0, "rudder 3.0° to starboard"), (-2.5, "rudder 2.5° to port"), (0.0, "rudder amidships")],
)
def test_rudder_in_words(angle, words):
    assert describe_rudder(to_series(voyage([0.0] * 3, rudder_deg=lambda k: angle)), 0) == words


def test_advice_is_called_advice():
    v = to_series(voyage([0.0] * 3, rudder_deg=lambda k: 3.0, applied=False))
    assert describe_rudder(v, 0).startswith("advised")


def test_unknown_rudder_is_said_to_be_unknown():
    v = to_series(voyage([0.0] * 3, rudder_deg=lambda k: np.nan))
    assert describe_rudder(v, 0) == "rudder not known"
