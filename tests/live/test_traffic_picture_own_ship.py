"""Own ship in the picture: her sensors, her echo, her plane, her waypoint."""

import math

import numpy as np
import pytest
from tests.live.reports import HERE, NORTH, SHIP, T0, at, own, ship, taken, targets

from glasshelm.ais.limits import LOST_AFTER_S
from glasshelm.ais.reports import Report
from glasshelm.live.traffic_picture import RECENTRE_M, TrafficPicture
from glasshelm.live.waypoint_tracker import AHEAD_M, NEAR_M, OFF_COURSE_S


def test_own_ship_is_dead_reckoned_remarked_on_and_lost():
    picture = taken(own())
    assert float(picture.scenario(at(20), SHIP).encounter.own.north_m) == pytest.approx(100)
    assert not any("s old" in note for note in picture.scenario(at(20), SHIP).notes)
    assert any("60 s old" in note for note in picture.scenario(at(60), SHIP).notes)
    assert picture.scenario(at(LOST_AFTER_S + 1), SHIP) is None
    assert "she is lost" in picture.status(at(LOST_AFTER_S + 1))


def test_own_ship_of_single_sensors():
    position = own(0, course_rad=None, speed_m_s=None)
    picture = taken(position)
    assert picture.scenario(T0, SHIP) is None
    assert picture.status(T0) == "own ship's speed is not known yet"
    said = {"rate_of_turn_rad_s": 0.01, "rudder_rad": 0.05, "heading_rad": 1.3}
    for name, value in (said | {"course_rad": 1.0, "speed_m_s": 4.0}).items():
        picture.update(Report(id="own", time=at(1), is_own=True, **{name: value}))
    state = picture.scenario(at(1), SHIP).encounter.own
    assert float(state.heading_rad) == pytest.approx(1.0)
    assert float(state.speed_m_s) == 4.0
    assert float(state.rate_of_turn_rad_s) == pytest.approx(0.01)
    assert float(state.rudder_rad) == pytest.approx(0.05)
    assert picture.scenario(at(11), SHIP).own_rudder
    # Adrift, the course over ground is noise; an old rate of turn or rudder is none.
    picture.update(Report(id="own", time=at(2), is_own=True, speed_m_s=0.2))
    assert float(picture.scenario(at(20), SHIP).encounter.own.heading_rad) == pytest.approx(1.3)
    assert float(picture.scenario(at(20), SHIP).encounter.own.rate_of_turn_rad_s) == 0
    assert not picture.scenario(at(20), SHIP).own_rudder


def test_identity_joins_position_and_own_length_scales_the_domain():
    picture = taken(
        own(),
        ship(1),
        Report(id="1", time=T0, name="ALPHA", length_m=90.0, ship_type="70"),
        Report(id="own", time=T0, is_own=True, length_m=120.0, beam_m=20.0, name="MYSELF"),
    )
    scenario = picture.scenario(T0, SHIP)
    (k,) = np.flatnonzero(np.asarray(scenario.encounter.present))
    info = scenario.targets[k]
    assert (info.name, info.length_m, info.ship_type) == ("ALPHA", 90.0, "70")
    assert (scenario.ship.loa_m, scenario.ship.beam_m) == (120.0, 20.0)
    assert scenario.own_name == "MYSELF"


def test_own_ship_under_her_own_number_is_no_target():
    picture = taken(ship(211000001, 0, 10.0), own())
    picture.update(Report(id="211000001", time=T0, heading_rad=0.0, is_own=True))
    assert targets(picture) == {}


def test_an_echo_is_found_and_a_ship_that_was_ever_apart_is_none():
    picture = taken(own(), ship(1, 0, 0.0, course_rad=0.0), ship(2, 0, 400.0))
    for seconds in range(10, 61, 10):
        north = 5.0 * seconds
        picture.update(own(seconds, north))
        picture.update(ship(1, seconds + 1, north + 10, course_rad=0.0))
        picture.update(ship(2, seconds, max(400 - 6.0 * seconds, north + 30)))
    assert set(targets(picture, 60)) == {"2"}


def told(number, seconds):
    """Own ship tells of herself under a number."""
    return Report(id=number, time=at(seconds), heading_rad=0.0, is_own=True)


def test_a_number_told_of_own_ship_by_mistake_hides_no_ship_elsewhere():
    """Once, or for as long as it lasts: she is far from own ship, so she is another."""
    for wrong in (1, 60):
        picture = taken(own(), told("230000001", 0))
        for seconds in range(10, 61, 10):
            picture.update(own(seconds, 5.0 * seconds))
            picture.update(told("230000001", seconds))
            picture.update(ship(230000001, seconds, 5.0 * seconds, course_rad=0.0))
            if seconds <= wrong * 10:
                picture.update(told("211000001", seconds))
            picture.update(ship(211000001, seconds, 5000.0 - 5 * seconds))
        assert set(targets(picture, 60)) == {"211000001"}
        assert picture.scenario(at(60), SHIP).own_name == "MMSI 230000001"


def test_a_number_that_is_not_told_any_more_hides_nobody():
    picture = taken(own(), told("211000001", 0))
    for seconds in range(10, 900, 10):
        picture.update(own(seconds, 5.0 * seconds))
        picture.update(ship(211000001, seconds, 5.0 * seconds + 300, course_rad=0.0))
        picture.scenario(at(seconds), SHIP)
    assert set(targets(picture, 890)) == {"211000001"}


def test_numbers_told_of_own_ship_are_bounded_and_the_real_one_stays():
    picture = taken(own())
    for k in range(500):
        picture.update(told("230000001", k))
        picture.update(told(f"2110000{k:02d}", k))
    assert picture._identities.mmsi == "230000001"
    assert len(picture._identities._numbers) <= 8


def test_an_echo_seen_apart_by_mistake_is_an_echo_again():
    picture = taken(own())
    for seconds in range(10, 1400, 10):
        north = 5.0 * seconds
        picture.update(own(seconds, north))
        off = 200.0 if 100 <= seconds < 150 else 10.0
        picture.update(ship(1, seconds, north + off, course_rad=0.0))
        if seconds in (90, 200, 600):
            assert ("1" in targets(picture, seconds)) is (seconds != 90)
    assert targets(picture, 1390) == {}


def test_with_own_number_known_a_ship_alongside_is_shown():
    reports = [own(), Report(id="211000001", time=T0, heading_rad=0.0, is_own=True)]
    for seconds in range(10, 61, 10):
        reports.append(own(seconds, 5.0 * seconds))
        reports.append(ship(1, seconds, 5.0 * seconds + 60, course_rad=0.0))
    assert set(targets(taken(*reports), 60)) == {"1"}


@pytest.mark.parametrize(
    "place", [(-59.7, -155.3), (0.0, 179.9999), (88.9, 0.0), (-88.9, 24.7), (59.7, 24.7)]
)
def test_own_ship_may_be_anywhere(place):
    picture = taken(own())
    picture.scenario(T0, SHIP)
    for k in range(3):  # a jump, until three agree
        picture.update(
            Report(
                id="own", time=at(10 + k), is_own=True, course_rad=1.0, speed_m_s=5.0,
                latitude_deg=place[0], longitude_deg=place[1] + k * 1e-5,
            )
        )  # fmt: skip
    scenario = picture.scenario(at(12), SHIP)
    state = scenario.encounter.own
    assert all(np.isfinite(float(x)) for x in vars(state).values())
    assert math.hypot(float(state.east_m), float(state.north_m)) <= RECENTRE_M
    assert scenario.origin == pytest.approx(place, abs=1e-3)


@pytest.mark.slow
def test_the_origin_stays_until_own_ship_is_far_from_it():
    picture = taken(own())
    origin = picture.scenario(T0, SHIP).origin
    seen = []
    for seconds in range(0, 8000, 100):
        picture.update(own(seconds, 5.0 * seconds))
        scenario = picture.scenario(at(seconds), SHIP)
        seen.append((scenario.origin, float(scenario.encounter.own.north_m)))
    near = [o for o, north in seen if o == origin]
    assert len(near) == sum(5.0 * s < RECENTRE_M for s in range(0, 8000, 100))
    assert len({o for o, _ in seen}) == 2
    assert max(north for _, north in seen) < RECENTRE_M * 1.01


def test_the_waypoint_is_ahead_and_stays_through_a_manoeuvre():
    picture = taken(own())

    def waypoint(seconds):
        return tuple(float(x[0]) for x in picture.scenario(at(seconds), SHIP).encounter.route)

    ahead = waypoint(0)
    assert ahead == (pytest.approx(0, abs=1), pytest.approx(AHEAD_M, rel=1e-3))
    # She turns away; only when she means it, her waypoint is another.
    for seconds in range(20, 1400, 20):
        picture.update(own(seconds, 0.01 * seconds, course_rad=math.pi / 2))
        there = waypoint(seconds)
        if seconds <= OFF_COURSE_S:
            assert there == pytest.approx(ahead, abs=1)
    assert there[0] == pytest.approx(AHEAD_M, rel=1e-2)


def routed(seconds, east_m=0.0, north_m=0.0):
    """Her route's next waypoint, so far from HERE."""
    longitude = HERE[1] + east_m * NORTH / math.cos(math.radians(HERE[0]))
    return Report(
        id="own", time=at(seconds), is_own=True,
        waypoint_latitude_deg=HERE[0] + north_m * NORTH, waypoint_longitude_deg=longitude,
    )  # fmt: skip


def shown(picture, seconds):
    """The waypoint shown to pilots, from own ship: range [m] and bearing [°]."""
    scenario = picture.scenario(at(seconds), SHIP)
    route, here = scenario.encounter.route, scenario.encounter.own
    east, north = float(route.x[0] - here.east_m), float(route.y[0] - here.north_m)
    return math.hypot(east, north), math.degrees(math.atan2(east, north))


def test_a_route_that_is_told_is_steered_for():
    picture = TrafficPicture()
    picture.update(own())
    assert any("no route" in note for note in picture.scenario(at(0), SHIP).notes)
    assert picture.update(routed(1, east_m=20_000.0, north_m=20_000.0)) is None
    range_m, bearing = shown(picture, 1)
    assert range_m == pytest.approx(28_284, rel=0.01)
    assert bearing == pytest.approx(45.0, abs=0.5)
    assert not any("no route" in note for note in picture.scenario(at(1), SHIP).notes)


@pytest.mark.parametrize("away", [2_000.0, 90_000.0])
def test_a_told_waypoint_is_shown_at_a_distance_that_pilots_know(away):
    picture = TrafficPicture()
    picture.update(own())
    picture.update(routed(1, east_m=away))
    range_m, bearing = shown(picture, 1)
    assert range_m * 1.001 >= NEAR_M
    assert range_m <= AHEAD_M * 1.001
    assert bearing == pytest.approx(90.0, abs=1.0)


def test_a_waypoint_that_is_reached_or_given_up_is_no_aim_any_more():
    picture = TrafficPicture()
    picture.update(own())
    picture.update(routed(1, north_m=300.0))
    assert shown(picture, 1)[1] == pytest.approx(0.0, abs=0.5)
    assert any("no route" in note for note in picture.scenario(at(1), SHIP).notes)
    picture.update(routed(2, east_m=20_000.0))  # abeam: she does not steer for it
    for seconds in range(10, int(OFF_COURSE_S) + 60, 10):
        picture.update(own(seconds, north_m=5.0 * seconds))
        _, bearing = shown(picture, seconds)
    assert bearing == pytest.approx(0.0, abs=1.0)


def test_a_route_that_has_ended_is_no_aim_and_it_is_said():
    picture = taken(own(), routed(1, east_m=20_000.0))
    assert shown(picture, 1)[1] == pytest.approx(90.0, abs=1.0)
    picture.update(Report(id="own", time=at(2), is_own=True, route_ended=True))
    range_m, bearing = shown(picture, 2)
    assert (range_m, bearing) == (pytest.approx(AHEAD_M, rel=1e-3), pytest.approx(0.0, abs=1.0))
    notes = picture.scenario(at(2), SHIP).notes
    assert any(note.startswith("her route has ended: the waypoint is assumed") for note in notes)
    picture.update(routed(3, east_m=20_000.0))
    assert shown(picture, 3)[1] == pytest.approx(90.0, abs=1.0)


def test_values_that_are_not_available_any_more_are_not_held():
    said = {"rate_of_turn_rad_s": 0.01, "rudder_rad": 0.05, "heading_rad": 1.3}
    picture = taken(own(0, course_rad=None, speed_m_s=0.0), told("own", 0))
    picture.update(Report(id="own", time=at(1), is_own=True, **said))
    state = picture.scenario(at(1), SHIP).encounter.own
    assert float(state.heading_rad) == pytest.approx(1.3)
    picture.update(Report(id="own", time=at(2), is_own=True, cleared=tuple(said)))
    scenario = picture.scenario(at(2), SHIP)
    assert float(scenario.encounter.own.rate_of_turn_rad_s) == 0.0
    assert not scenario.own_rudder
    assert any("heading is not known" in note for note in scenario.notes)
    # A speed or a course goes on until the positions tell another.
    picture = taken(own(0), ship(1, 0, 2000.0))
    ended = ("course_rad", "speed_m_s")
    picture.update(Report(id="1", time=at(1), cleared=ended))
    assert targets(picture, 1)["1"][3] == 5.0
    picture.update(ship(1, 20, 1960.0, course_rad=None, speed_m_s=None))
    assert targets(picture, 20)["1"][3] == pytest.approx(2.0, rel=0.02)


def test_own_ship_s_heading_is_not_made_up_while_she_makes_way():
    silent = {"course_rad": None, "speed_m_s": 4.0}
    picture = taken(own(0, **silent))
    assert picture.scenario(at(0), SHIP) is None
    assert picture.status(at(0)) == "own ship's course is not known yet"
    picture.update(own(10, 40.0, **silent))
    assert picture.scenario(at(10), SHIP) is not None
    moored = taken(own(0, course_rad=None, speed_m_s=0.0)).scenario(at(0), SHIP)
    assert "own ship's heading is not known: she is shown heading north" in moored.notes
