import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.voyages import Other, plain, voyage

from glasshelm.figures.series import series
from glasshelm.report.episodes import Episode
from glasshelm.report.reasons import focus, why

TURN = Episode(0, 9, 0.3)


def told(waypoint, *ships, attention=None, tcpa_ahead=True):
    course = 180 if tcpa_ahead else 0
    others = [
        Other(f"ship {i}", 200.0 * i, 6000 if tcpa_ahead else -6000, course, 4.0,
              priority=lambda k, p=p: p,
              attention=(lambda k, a=attention[i]: a) if attention else None)
        for i, p in enumerate(ships)
    ]  # fmt: skip
    return series(
        voyage(
            [0.0] * 10,
            others,
            waypoint_priority=lambda k: waypoint,
            rudder_deg=lambda k: 3.0,
        )
    )


@pytest.mark.parametrize(
    ("waypoint", "ships", "words"),
    [
        (-0.05, [0.2], "danger from ship 0 (CPA 0.00 NM in 11 min) outweighs 0.05 of course value"),
        (0.0, [0.2], "at no cost of course value"),
        (0.03, [0.2], "it also gains 0.03 of course value"),
        (-0.3, [0.2], "is less than the 0.30 of course value that it costs"),
        (0.05, [-0.2], "the critic does not say why: 0.05 of course value is less than the 0.20"),
        (0.3, [-0.2], ": 0.30 of course value outweighs 0.20 for the ships"),
        (0.3, [], ": 0.30 of course value; no ship's priority is positive"),
        (-0.1, [-0.2], "does not say why: the priority of the ships is −0.200"),
    ],
)
def test_reason(waypoint, ships, words):
    assert words in why(told(waypoint, *ships), TURN)


def test_the_leading_ships_are_named_in_order():
    text = why(told(-0.01, 0.2, 0.3, 0.01), TURN)
    assert re.search(r"danger from ship 1 \(.*\) and ship 0 \(", text)
    assert "ship 2" not in text


def test_a_ship_that_is_past_is_no_danger_to_come():
    text = why(told(-0.01, 0.2, tcpa_ahead=False), TURN)
    assert "danger" not in text
    assert "the gain with ship 0" in text


def test_frames_with_the_rudder_against_the_turn_do_not_count():
    other = Other("A", 0.0, 6000, 180, 4.0, priority=lambda k: 0.5 if k < 5 else -0.5)
    v = series(
        voyage([0.0] * 10, [other], waypoint_priority=lambda k: 0.0,
               rudder_deg=lambda k: 3.0 if k < 5 else -3.0)
    )  # fmt: skip
    assert "danger from A" in why(v, TURN)
    assert "danger from A" not in why(v, Episode(0, 9, -0.3))


def test_a_pilot_without_a_critic_gives_no_reasons():
    text = why(series(plain()), TURN)
    assert "gives no reasons" in text
    assert "Aurora (CPA" in text
    assert focus(series(plain()), TURN) == ""


def test_attention_and_intention_may_disagree():
    text = focus(told(0.0, 0.01, 0.2, attention=[0.8, 0.2]), TURN)
    assert "mostly on ship 0 (80%)" in text
    assert "largest intention belongs to ship 1" in text
    assert "also has the largest" in focus(told(0.0, 0.2, 0.01, attention=[0.8, 0.2]), TURN)


def test_attention_without_positive_intention_is_said():
    assert "no ship has a positive" in focus(told(0.0, -0.2, attention=[1.0]), TURN)


priorities = st.floats(-0.5, 0.5).map(lambda x: round(x, 3))


@settings(max_examples=25)
@given(priorities, st.lists(priorities, max_size=4))
def test_sentences_claim_no_more_than_the_numbers(waypoint, ships):
    text = why(told(waypoint, *ships), TURN)
    total = sum(ships)
    for i, priority in enumerate(ships):
        if f"ship {i} (" in text:
            assert priority > 0
    if "no ship's priority is positive" in text:
        assert all(p <= 0.0005 for p in ships)
    if "outweighs" in text and "danger" in text:
        assert total > -waypoint > 0
    if "does not say why" in text:
        assert total + waypoint <= 0.0011
    if "at no cost" in text:
        assert abs(waypoint) <= 0.0006
