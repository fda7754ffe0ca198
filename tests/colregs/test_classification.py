"""Encounters are called what a navigator calls them, and what was done is written down."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.evaluation.cases import SPEED

from glasshelm.colregs import compliance
from glasshelm.colregs.classification import EncounterType, classify
from glasshelm.colregs.compliance import MeetingFacts
from glasshelm.core.geometry import velocity
from glasshelm.encounters.types import Motion
from glasshelm.ship.nomoto import ShipState

TURN = 120  # steps before own ship alters, of 5 s


def sail(target, turn_deg=0.0, begins=TURN, steps=480):
    """Own ship on north at 10 kn, altering by one degree a step from a step on; one target."""
    east, north, course, speed = target
    course = np.radians(course)

    def go(carry, number):
        own_east, own_north, heading, meetings = carry
        left = jnp.abs(jnp.radians(turn_deg)) - jnp.abs(heading)
        turning = (number >= begins) & (left > 1e-4)
        change = jnp.where(turning, jnp.sign(turn_deg) * jnp.radians(1.0), 0.0)
        heading = heading + change
        v = velocity(heading, SPEED)
        own_east, own_north = own_east + 5 * v.x, own_north + 5 * v.y
        time = 5.0 * (number + 1)
        one = jnp.ones(1)
        motion = Motion(
            one * (east + time * speed * np.sin(course)),
            one * (north + time * speed * np.cos(course)),
            one * course, one * speed, 0 * one, one > 0,
        )  # fmt: skip
        zero = jnp.zeros(())
        own = ShipState(own_east, own_north, heading, zero, zero, zero + SPEED)
        return (own_east, own_north, heading, meetings.updated(own, v, change, motion, time)), None

    zero = jnp.zeros(())
    start = (zero, zero, zero, MeetingFacts.initial(1))
    (*_, meetings), _ = jax.jit(lambda s: jax.lax.scan(go, s, jnp.arange(steps)))(start)
    return {name: np.asarray(value) for name, value in vars(meetings).items()}


def meeting_at_1500_s(course, ratio=1.0):
    """A target on a course who would collide after 1500 s."""
    run = 1500 * SPEED * ratio
    angle = np.radians(course)
    return (-run * np.sin(angle), 1500 * SPEED - run * np.cos(angle), course, ratio * SPEED)


@pytest.mark.parametrize(
    ("course", "ratio", "kind"),
    [
        (180, 1.0, EncounterType.HEAD_ON),
        (170, 1.0, EncounterType.HEAD_ON),
        (270, 1.0, EncounterType.CROSSING_GIVE_WAY),
        (90, 1.0, EncounterType.CROSSING_STAND_ON),
        (
            150,
            1.0,
            EncounterType.CROSSING_STAND_ON,
        ),  # 15 degrees on the port bow: not end on any more
        (0, 0.6, EncounterType.OVERTAKING),
        (20, 0.7, EncounterType.OVERTAKING),
        (0, 1.6, EncounterType.OVERTAKEN),
        (20, 1.6, EncounterType.OVERTAKEN),
    ],
)
def test_kinds(course, ratio, kind):
    assert sail(meeting_at_1500_s(course, ratio))["kind"][0] == kind


def test_the_limit_of_overtaking_is_22_5_degrees_abaft_the_beam():
    """Own ship, faster, coming up from 23 and from 22 degrees abaft the other's beam."""
    aspects = jnp.radians(jnp.array([113.0, 112.0]))
    found = classify(jnp.zeros(2), aspects, jnp.ones(2, bool))
    assert found.tolist() == [EncounterType.OVERTAKING, EncounterType.CROSSING_GIVE_WAY]


def test_no_meeting_without_risk():
    assert sail((8000.0, 0.0, 0.0, SPEED))["kind"][0] == EncounterType.NONE
    assert sail((3000.0, 6000.0, 0.0, 2 * SPEED))["kind"][0] == EncounterType.NONE


@pytest.mark.parametrize("knots", [0.0, 0.4])
def test_no_meeting_with_a_ship_that_is_stopped(knots):
    """Rules 13-15 are for vessels under way, and her course is what a feed made of nothing."""
    for course in (0, 90, 180):
        assert sail(meeting_at_1500_s(course, knots / 10))["kind"][0] == EncounterType.NONE
    assert sail(meeting_at_1500_s(0, 0.06))["kind"][0] == EncounterType.OVERTAKING


def test_a_crossing_avoided_by_the_book():
    facts = sail(meeting_at_1500_s(270), turn_deg=40, begins=20)
    assert facts["kind"][0] == EncounterType.CROSSING_GIVE_WAY
    assert np.degrees(facts["starboard_rad"][0]) == pytest.approx(40, abs=0.1)
    assert facts["port_rad"][0] == 0
    assert facts["act_side"][0] == 1
    assert facts["ahead_m"][0] < 0  # astern of her
    judged = {
        n: bool(j(facts)[0])
        for n, j in compliance.CRITERIA[EncounterType.CROSSING_GIVE_WAY].items()
    }
    assert all(judged.values()), judged


def test_a_crossing_avoided_against_the_book():
    """Late, to port, ahead of her."""
    facts = sail(meeting_at_1500_s(270), turn_deg=-40, begins=240)
    assert facts["act_side"][0] == -1
    assert not compliance.early(facts)[0]
    assert compliance.substantial(facts)[0]
    assert not compliance.to_starboard(facts)[0]


def test_passing_ahead_is_told_from_passing_astern():
    """A target 800 m late at the crossing lets own ship pass ahead, one 800 m early astern."""
    east, north, course, speed = meeting_at_1500_s(270)
    assert sail((east + 800, north, course, speed))["ahead_m"][0] == pytest.approx(800, abs=30)
    assert sail((east - 800, north, course, speed))["ahead_m"][0] == pytest.approx(-800, abs=30)


def test_a_stand_on_ship_that_holds_and_one_that_does_not():
    target = meeting_at_1500_s(90)
    holds, alters = sail(target), sail(target, turn_deg=-40, begins=60)
    assert compliance.stood_on_to_3_nm(holds)[0]
    assert compliance.stood_on(holds)[0]
    assert not compliance.stood_on_to_3_nm(alters)[0]
    assert not compliance.not_to_port(alters)[0]


def test_head_on_to_starboard_is_port_to_port():
    facts = sail(meeting_at_1500_s(180), turn_deg=35)
    assert compliance.port_to_port(facts)[0]
    assert not compliance.port_to_port(sail(meeting_at_1500_s(180), turn_deg=-35))[0]


def test_alone_means_no_other_meeting_in_the_voyage():
    facts = {"kind": np.array([1, 1, 2]), "meetings_of_voyage": np.array([1, 2, 2])}
    assert len(compliance.of_type(facts, EncounterType.HEAD_ON)["kind"]) == 2
    assert len(compliance.of_type(facts, EncounterType.HEAD_ON, alone=True)["kind"]) == 1
