import numpy as np
import pytest
from tests.voyages import voyage

from glasshelm.frames.episodes import Episode, advice_episodes, turn_episodes
from glasshelm.frames.series import to_series


def turned(headings):
    return [e for e in turn_episodes(to_series(voyage(headings))) if e.turn_rad]


def ramp(start, end, frames=10):
    return list(np.linspace(start, end, frames + 1)[1:])


def test_a_turn_is_found_where_it_is():
    (turn,) = turned([0.0] * 30 + ramp(0, 30) + [30.0] * 30)
    assert np.degrees(turn.turn_rad) == pytest.approx(30, abs=2)
    assert 28 <= turn.start <= 31
    assert 38 <= turn.end <= 41


def test_to_port_is_negative():
    (turn,) = turned([0.0] * 30 + ramp(0, -20) + [-20.0] * 30)
    assert turn.turn_rad < 0


def test_a_trembling_heading_is_steady():
    headings = 1.5 * np.sin(np.arange(200))
    assert turn_episodes(to_series(voyage(headings))) == [Episode(0, 199)]


def test_out_and_back_are_two_turns():
    found = turned([0.0] * 30 + ramp(0, 40) + ramp(40, 0) + [0.0] * 30)
    assert [np.sign(e.turn_rad) for e in found] == [1, -1]


def test_a_long_rest_makes_two_turns_of_one_swing():
    found = turned([0.0] * 20 + ramp(0, 15) + [15.0] * 40 + ramp(15, 30) + [30.0] * 20)
    assert len(found) == 2
    assert sum(np.degrees(e.turn_rad) for e in found) == pytest.approx(30, abs=3)


def test_a_short_rest_does_not():
    assert len(turned([0.0] * 20 + ramp(0, 15) + [15.0] * 5 + ramp(15, 30) + [30.0] * 20)) == 1


def test_a_turn_through_north_is_one_turn():
    headings = [350.0] * 20 + [x % 360 for x in ramp(350, 370)] + [10.0] * 20
    (turn,) = turned(headings)
    assert np.degrees(turn.turn_rad) == pytest.approx(20, abs=2)


@pytest.mark.parametrize("seed", range(5))
def test_episodes_cover_the_voyage_in_order(seed):
    steps = np.random.default_rng(seed).normal(0, 2, 300)
    v = to_series(voyage(np.cumsum(steps)))
    for cut in (turn_episodes, advice_episodes):
        found = cut(v)
        assert found[0].start == 0
        assert found[-1].end == len(v.time_s) - 1
        starts = [e.start for e in found]
        assert starts == sorted(starts)
        assert all(e.end >= e.start for e in found)


def advised(rudder):
    frames = voyage([0.0] * len(rudder), rudder_deg=lambda k: rudder[k], applied=False)
    return [e for e in advice_episodes(to_series(frames)) if e.turn_rad]


def test_advice_begins_above_one_angle_and_ends_below_a_smaller():
    rudder = [0.0] * 5 + [1.2] + [0.7] * 10 + [0.3] * 5
    (found,) = advised(rudder)
    assert (found.start, found.end) == (5, 15)


def test_small_rudder_is_no_advice():
    assert advised([0.7] * 20) == []


def test_a_flick_is_no_advice():
    assert advised([0.0] * 5 + [4.0] * 2 + [0.0] * 10) == []


def test_advice_to_the_other_side_is_another():
    found = advised([3.0] * 6 + [-3.0] * 6)
    assert [round(np.degrees(e.turn_rad)) for e in found] == [3, -3]


def test_one_frame_is_one_steady_episode():
    assert turn_episodes(to_series(voyage([0.0]))) == [Episode(0, 0)]
