import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.core.errors import InputError
from glasshelm.core.geometry import Vector, closest_approach, velocity
from glasshelm.encounters.imazu import imazu_cases, imazu_scenario
from glasshelm.encounters.types import motion_at
from glasshelm.ship.nomoto import SHIPS

SHIP = SHIPS["paper"]


def approach(case, ship=SHIP, tcpa_s=1800.0):
    e = imazu_scenario(case, ship, tcpa_s).encounter
    now = motion_at(e.targets, jnp.zeros(()))
    target = velocity(now.course_rad, now.speed_m_s)
    relative = Vector(target.x, target.y - ship.speed_m_s)
    place = Vector(now.east_m, now.north_m)
    return place, closest_approach(place, relative)


def test_twenty_two_cases_and_two_variants():
    names = [str(i) for i in range(1, 23)] + ["8b", "12b"]
    assert set(imazu_cases()) == set(names)
    assert [len(imazu_cases()[n]) for n in names] == [1] * 4 + [2] * 7 + [3] * 11 + [2, 3]


@pytest.mark.parametrize("case", sorted(imazu_cases()))
def test_everybody_meets_own_ship(case):
    _, cpa = approach(case)
    np.testing.assert_allclose(cpa.tcpa_s, 1800.0, rtol=1e-4)
    np.testing.assert_allclose(cpa.dcpa_m, 0.0, atol=2.0)


@pytest.mark.parametrize(
    ("case", "east", "north"),
    [("1", 0, 2), ("2", 1, 1), ("3", 0, 0.3), ("4", -(0.5**0.5), 1 - 0.5**0.5)],
)
def test_single_ship_cases_are_placed_as_a_compass_would(case, east, north):
    # In units of own ship's way to the meeting point: case 2 comes from starboard.
    place, _ = approach(case)
    run = float(SHIP.speed_m_s) * 1800.0
    np.testing.assert_allclose(place.x[0] / run, east, atol=1e-5)
    np.testing.assert_allclose(place.y[0] / run, north, atol=1e-5)


def test_variants_mirror_one_ship_of_the_disputed_cases():
    for case in ("8", "12"):
        ours, variant = np.array(imazu_cases()[case]), np.array(imazu_cases()[case + "b"])
        turned = ours[:, 0] != variant[:, 0]
        assert turned.sum() == 1
        np.testing.assert_allclose((ours[turned, 0] + variant[turned, 0]) % 360, 0)
    assert imazu_cases()["8"] == imazu_cases()["5"]


def test_ship_time_and_goal_can_be_chosen():
    fast = dataclasses.replace(SHIP, speed_m_s=8.0)
    _, cpa = approach("17", fast, 900.0)
    np.testing.assert_allclose(cpa.tcpa_s, 900.0, rtol=1e-4)
    own_goal = imazu_scenario("17", fast, 900.0, waypoint_m=None)
    assert float(own_goal.encounter.route.y[0]) == pytest.approx(2 * 8 * 900)
    assert float(imazu_scenario("17", fast).encounter.route.y[0]) == pytest.approx(46_300)
    assert own_goal.duration_s == 2400
    assert imazu_scenario("1", SHIP).duration_s == 3600


@pytest.mark.parametrize("case", ["0", "23", "8c", "", "five"])
def test_unknown_case(case):
    with pytest.raises(InputError, match="choose 1 to 22"):
        imazu_scenario(case, SHIP)


@pytest.mark.parametrize("tcpa_s", [0.0, -5.0, float("nan"), float("inf")])
def test_impossible_time(tcpa_s):
    with pytest.raises(InputError, match="tcpa_s"):
        imazu_scenario("1", SHIP, tcpa_s)
