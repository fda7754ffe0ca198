"""The CPA rule does what Rules 13 to 17 ask of each part in a meeting."""

import dataclasses

import jax
import jax.numpy as jnp
import pytest
from tests.pilots.scenes import colliding, observed

from glasshelm.colregs.classification import EncounterType, classify_targets
from glasshelm.pilots.cpa_rule import CpaSettings, cpa_course
from glasshelm.planning.situation import situation_of
from glasshelm.ship.nomoto import SHIPS

SHIP = SHIPS["paper"]
SETTINGS = CpaSettings()

_chosen = jax.jit(lambda s, o: cpa_course(s, o, SHIP, SETTINGS))


@jax.jit
def _kinds(observation):
    at = situation_of(observation, SHIP)
    return classify_targets(at.position, at.velocity, jnp.zeros(()))


def course(*rows, steered_deg=0.0) -> float:
    """The course [deg] off the waypoint's bearing; one row, so that one program serves all."""
    (row,) = rows
    return float(jnp.degrees(_chosen(observed(row), jnp.radians(jnp.float32(steered_deg)))))


@pytest.mark.parametrize(
    ("row", "part"),
    [
        (colliding(180.0), EncounterType.HEAD_ON),
        (colliding(172.0), EncounterType.HEAD_ON),
        (colliding(270.0), EncounterType.CROSSING_GIVE_WAY),
        (colliding(90.0), EncounterType.CROSSING_STAND_ON),
        (colliding(0.0, 2.0), EncounterType.OVERTAKING),
        (colliding(10.0, 2.0), EncounterType.OVERTAKING),
        (colliding(10.0, 9.0), EncounterType.OVERTAKEN),
    ],
)
def test_her_part_in_a_meeting(row, part):
    assert int(_kinds(observed(row))[0]) == part


def test_in_the_mirror_who_gives_way_changes_and_nothing_else():
    crossing = colliding(250.0)
    mirrored = (-crossing[0], crossing[1], -crossing[2], crossing[3])
    assert int(_kinds(observed(crossing))[0]) == EncounterType.CROSSING_GIVE_WAY
    assert int(_kinds(observed(mirrored))[0]) == EncounterType.CROSSING_STAND_ON


@pytest.mark.parametrize("course_deg", [180.0, 225.0, 270.0, 300.0])
def test_head_on_and_from_starboard_she_alters_to_starboard_and_enough_to_be_seen(course_deg):
    assert course(colliding(course_deg)) >= 30.0


@pytest.mark.parametrize("course_deg", [60.0, 90.0])
def test_she_stands_on_until_the_last_moment_and_then_does_not_turn_to_port(course_deg):
    waits, acts = SETTINGS.last_moment_s + 100.0, SETTINGS.last_moment_s - 100.0
    assert course(colliding(course_deg, tcpa_s=waits)) == 0.0
    assert course(colliding(course_deg, tcpa_s=acts)) > 0.0  # Rule 17 c


def test_a_meeting_far_in_the_future_or_past_is_none():
    assert course(colliding(270.0, tcpa_s=SETTINGS.tcpa_s + 200.0)) == 0.0
    assert course((-2000.0, -2000.0, 225.0, 5.0)) == 0.0


def test_an_alteration_is_held_until_clear_by_the_wider_limit():
    """Passing at 1.07 times the limit starts nothing, and ends nothing that has begun."""
    between = 0.5 * (1.0 + SETTINGS.hysteresis) * SETTINGS.dcpa_m
    clear = 1.05 * SETTINGS.hysteresis * SETTINGS.dcpa_m
    passing = (-between, 6000.0, 180.0, 5.0)
    assert course(passing) == 0.0
    assert course(passing, steered_deg=45.0) == pytest.approx(45.0, abs=1e-3)
    assert course((-clear, 6000.0, 180.0, 5.0), steered_deg=45.0) == 0.0


def test_overtaking_the_side_is_free():
    """The slow ship is to starboard: 30° to port clear her, 30° to starboard do not (Rule 13)."""
    row = (1200.0, 4000.0, 0.0, 2.0)
    assert course(row) == pytest.approx(-30.0, abs=1e-3)
    assert course((-1200.0, 4000.0, 0.0, 2.0)) == pytest.approx(30.0, abs=1e-3)


def test_settings_are_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        SETTINGS.dcpa_m = 1.0  # pyright: ignore[reportAttributeAccessIssue]
