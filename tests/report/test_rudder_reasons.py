import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.report.adding import ROUNDED_DEG, told_sum
from tests.voyages import Other, plain, voyage

from glasshelm.colregs.classification import EncounterType
from glasshelm.frames.episodes import Episode
from glasshelm.frames.series import to_series
from glasshelm.report.rudder_reasons import disagreement_text, reason_text

TURN = Episode(0, 9, 0.3)


def told(
    *shares, alone=None, attention=None, gain=0.0, ahead=True, course=180.0, east=0.0, speed=4.0
):
    """Ships ahead who move the rudder by these shares [deg]; ``alone`` does the rest of 3°."""
    alone = 3.0 - sum(shares) if alone is None else alone
    others = [
        Other(f"ship {i}", east + 200.0 * i, 6000 if ahead else -6000, course if ahead else 0,
              speed, share_deg=lambda k, p=p: p,
              attention=(lambda k, a=attention[i]: a) if attention else None)
        for i, p in enumerate(shares)
    ]  # fmt: skip
    rudder = alone + sum(shares)
    return to_series(
        voyage(
            [0.0] * 10,
            others,
            waypoint_priority=lambda k: gain,
            rudder_deg=lambda k: rudder,
            alone_deg=lambda k: alone,
        )
    )


@pytest.mark.parametrize(
    ("alone", "shares", "words"),
    [
        (0.0, [3.0], ": 3.0° of rudder for ship 0 (CPA 0.00 NM in 11 min)"),
        (1.0, [2.0], ": 2.0° of rudder for ship 0 (CPA 0.00 NM in 11 min), 1.0° for the waypoint"),
        (2.5, [0.5], ": 2.5° of rudder for the waypoint, 0.5° for ship 0 (CPA"),
        (-1.2, [4.2], "(CPA 0.00 NM in 11 min); with nobody there it would be 1.2° to port"),
        (3.0, [0.0], ": 3.0° of rudder for the waypoint"),
        (0.0, [4.0, -1.0], "; ship 1 (CPA 0.11 NM in 11 min) holds it back by 1.0°"),
        (0.0, [3.2, -0.2], "ship 0 (CPA 0.00 NM in 11 min); ship 1 holds it back by 0.2°"),
        (0.0, [2.0, 0.5, 0.4], "for ship 0 (CPA 0.00 NM in 11 min), 0.9° for 2 others"),
        (5.0, [-0.9, -0.5], ": 5.0° of rudder for the waypoint; 2 ships hold it back by 1.4°"),
        (5.0, [-2.0, -0.5, -0.5], "; ship 0 (CPA 0.00 NM in 11 min) holds it back by 2.0°, 2 o"),
        (-0.2, [0.09] * 10, ": 0.9° of rudder for 10 ships; with nobody there it would be 0.2°"),
        (0.0, [2.0, 0.7, *[0.005] * 5], "), 0.7° for ship 1"),
    ],
)
def test_reason(alone, shares, words):
    assert words in reason_text(told(*shares, alone=alone), TURN)


def test_a_rudder_away_from_the_waypoint_is_not_for_it():
    """With nobody there she would turn away too: the network's doing, and said as that."""
    turning = voyage([30.0] * 10, [], rudder_deg=lambda k: 2.0, alone_deg=lambda k: 2.0)
    assert reason_text(to_series(turning), TURN) == ": 2.0° of rudder also with nobody there"
    back = voyage([-30.0] * 10, [], rudder_deg=lambda k: 2.0, alone_deg=lambda k: 2.0)
    assert reason_text(to_series(back), TURN) == ": 2.0° of rudder for the waypoint"


def test_what_hardly_moves_the_rudder_is_not_named():
    assert "ship 1" not in reason_text(told(3.2, -0.04), TURN)
    assert "waypoint" not in reason_text(told(3.0, alone=0.04), TURN)


def test_the_leading_ships_are_named_in_order_and_together():
    text = reason_text(told(1.0, 1.8, 0.2), TURN)
    assert re.search(r"2.8° of rudder for ship 1 \(.*\) and ship 0 \(", text)
    assert text.endswith(", 0.2° for ship 2")


def test_a_turn_to_port_is_told_the_same_way():
    assert ": 3.0° of rudder for ship 0" in reason_text(told(-3.0, alone=0.0), Episode(0, 9, -0.3))


def test_a_ship_that_is_past_is_said_to_be():
    assert "ship 0 (past her CPA" in reason_text(told(3.0, ahead=False), TURN)


def test_frames_with_the_rudder_against_the_turn_do_not_count():
    other = Other("A", 0.0, 6000, 180, 4.0, share_deg=lambda k: 3.0 if k < 5 else -1.0)
    v = to_series(
        voyage([0.0] * 10, [other], alone_deg=lambda k: 0.0 if k < 5 else -2.0,
               rudder_deg=lambda k: 3.0 if k < 5 else -3.0)
    )  # fmt: skip
    assert "3.0° of rudder for A" in reason_text(v, TURN)
    assert "2.0° of rudder for the waypoint, 1.0° for A" in reason_text(v, Episode(0, 9, -0.3))


def test_a_pilot_without_shares_gives_no_reasons():
    text = reason_text(to_series(plain()), TURN)
    assert "gives no reasons" in text
    assert "Aurora (CPA" in text
    assert disagreement_text(to_series(plain()), TURN) == ""


def test_attention_is_said_to_agree_or_not():
    agreed = disagreement_text(told(2.0, 1.0, attention=[0.8, 0.2]), TURN)
    assert agreed == "Attention is mostly on ship 0 too (80%)."
    assert "But attention is mostly on ship 1 (80%)." in disagreement_text(
        told(2.0, 1.0, attention=[0.2, 0.8]), TURN
    )
    assert (
        disagreement_text(told(3.0, attention=[1.0]), TURN) == ""
    )  # a single ship has it all anyhow


def test_a_critic_who_would_have_no_rudder_is_heard():
    text = disagreement_text(told(3.0, gain=-0.3), TURN)
    assert text == "The critic rates the rudder amidships better."
    assert disagreement_text(told(3.0, gain=0.3), TURN) == ""


@pytest.mark.parametrize(
    ("course", "east", "share", "words"),
    [
        (180.0, 0.0, -3.0, "Rule 14 asks for starboard: ship 0 is head-on."),
        (180.0, 0.0, 3.0, ""),
        (270.0, 6500.0, -3.0, "Rule 15 gives way to ship 0, by custom to starboard"),
        (270.0, 6500.0, 3.0, ""),
        (90.0, -6500.0, 3.0, "Rule 17 has own ship stand on: ship 0 is to give way."),
        (180.0, 5000.0, -3.0, ""),  # no risk of collision
    ],
)
def test_the_rules_are_quoted_where_they_ask_for_something_else(course, east, share, words):
    text = disagreement_text(
        told(share, alone=0.0, course=course, east=east), Episode(0, 9, share / 10)
    )
    assert words in text
    assert bool(words) == bool(text)


def test_the_rules_are_those_of_the_meeting_where_it_is_known():
    """She has come to own ship's port side since, but that makes no new meeting."""
    voyage = told(3.0, alone=0.0, course=90.0, east=-6500.0)
    assert "Rule 17" in disagreement_text(voyage, TURN)
    (ship,) = voyage.ships
    assert disagreement_text(voyage, TURN, kinds={ship.id: EncounterType.CROSSING_GIVE_WAY}) == ""
    assert disagreement_text(voyage, TURN, kinds={}) == ""
    assert "Rule 17" in disagreement_text(
        voyage, TURN, kinds={ship.id: EncounterType.CROSSING_STAND_ON}
    )


def test_no_rule_is_quoted_for_a_ship_that_is_stopped():
    """Rules 13-15 are for vessels under way."""
    port = Episode(0, 9, -0.3)
    assert "Rule 14" in disagreement_text(told(-3.0, alone=0.0, speed=0.3), port)
    assert disagreement_text(told(-3.0, alone=0.0, speed=0.2), port) == ""


def test_means_over_a_turn_add_up_though_a_ship_comes_late():
    late = Other("B", 0.0, 6000, 180, 4.0, share_deg=lambda k: 2.0, here=lambda k: k >= 5)
    turn = voyage([0.0] * 10, [late], alone_deg=lambda k: 1.0,
                  rudder_deg=lambda k: 3.0 if k >= 5 else 1.0)  # fmt: skip
    text = reason_text(to_series(turn), TURN)
    assert text.startswith(": 1.0° of rudder for B (")
    assert text.endswith(", 1.0° for the waypoint")
    assert told_sum(text) == 2.0


shares = st.floats(-3, 3).map(lambda x: round(x, 2))


@settings(max_examples=25, deadline=None)
@given(shares, st.lists(shares, max_size=4))
def test_sentences_claim_no_more_than_the_numbers(alone, moved):
    rudder = alone + sum(moved)
    way = 1 if rudder >= 0 else -1
    text = reason_text(told(*moved, alone=alone), Episode(0, 9, 0.3 * way))
    before, _, after = text.partition("holds it back")
    for i, share in enumerate(moved):
        name = f"ship {i} ("
        if name in before and not (after and before.rindex(name) == before.rindex("ship ")):
            assert share * way > 0.09
    if "for the waypoint" in text:
        assert alone * way > 0.049
    if ") holds it back" in text:
        assert min(m * way for m in moved) < -0.24 * abs(rudder)
    if "hardly any rudder" in text:
        assert max([alone * way, *(m * way for m in moved)]) < 0.11
    else:
        assert told_sum(text) == pytest.approx(abs(rudder), abs=ROUNDED_DEG)
