import math
from datetime import UTC, datetime, timedelta

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from benchmarks.feeds_fuzz import recording

from glasshelm.encounters.ais_table import OWN_SENSORS
from glasshelm.encounters.recorded import LOST_AFTER_S
from glasshelm.feeds import picture as picture_module
from glasshelm.feeds.destination import AHEAD_M, MEANT_S, NEAR_M
from glasshelm.feeds.picture import FORGOTTEN_S, RECENTRE_M, SHOWN_M, SLOTS, Picture
from glasshelm.feeds.types import Refusal, Report
from glasshelm.framing import Framer
from glasshelm.moment import moment_of, never_held
from glasshelm.pilots.catalogue import pilot_named
from glasshelm.pilots.straight import StraightPilot
from glasshelm.ships import KNOT_M_S, SHIPS
from glasshelm.voyage import sail
from glasshelm.world.step import WorldSettings, begin, targets_at

SHIP = SHIPS["large_ship"]
T0 = datetime(2014, 8, 15, 19, tzinfo=UTC)
HERE = (59.7, 24.7)
#: Degrees a metre northwards, near enough.
NORTH = 1 / 111_400


def at(seconds):
    return T0 + timedelta(seconds=seconds)


def own(seconds=0.0, north_m=0.0, **said):
    said = {"course_rad": 0.0, "speed_m_s": 5.0} | said
    return Report(
        id="own", time=at(seconds), latitude_deg=HERE[0] + north_m * NORTH, longitude_deg=HERE[1],
        own=True, **said,
    )  # fmt: skip


def ship(number, seconds=0.0, north_m=2000.0, **said):
    said = {"course_rad": math.pi, "speed_m_s": 5.0} | said
    return Report(
        id=str(number), time=at(seconds), latitude_deg=HERE[0] + north_m * NORTH,
        longitude_deg=HERE[1], **said,
    )  # fmt: skip


def taken(*reports, **settings):
    picture = Picture("test", **settings)
    for report in reports:
        picture.take(report)
    return picture


def targets(picture, seconds=0.0):
    """The targets there at a time: id -> (east, north, course, speed, age)."""
    scenario = picture.scenario(at(seconds), SHIP)
    m = targets_at(scenario.encounter, jnp.zeros(()))
    columns = (m.east_m, m.north_m, m.course_rad, m.speed_m_s, m.age_s)
    return {
        scenario.targets[k].id: tuple(float(x[k]) for x in columns)
        for k in np.flatnonzero(np.asarray(m.present))
    }


def test_nothing_is_known_at_first():
    picture = Picture()
    assert picture.heard is None
    assert picture.now() is None
    assert picture.scenario(T0, SHIP) is None
    assert picture.state(T0) == "nothing heard yet"
    picture.take(ship(1))
    assert picture.scenario(T0, SHIP) is None
    assert picture.state(T0) == "no position of own ship yet (1 other ships heard)"


def test_a_target_is_dead_reckoned_from_her_latest_report():
    picture = taken(own(), ship(1, -30.0, 2000.0))
    east, north, course, speed, age = targets(picture)["1"]
    assert (east, north) == (pytest.approx(0, abs=1), pytest.approx(2000 - 150, rel=2e-3))
    assert (abs(course), speed, age) == (pytest.approx(math.pi), 5.0, pytest.approx(30))
    picture.take(ship(1, -10.0, 1900.0))
    assert targets(picture)["1"][1] == pytest.approx(1850, rel=2e-3)
    assert targets(picture)["1"][4] == pytest.approx(10)


def test_a_target_is_lost_by_the_limits_of_recorded_traffic_and_forgotten_later():
    picture = taken(own(), ship(1))
    for seconds in range(1, 900, 20):
        picture.take(own(seconds, 5.0 * seconds))
    assert "1" in targets(picture, LOST_AFTER_S - 1)
    assert "1" not in targets(picture, LOST_AFTER_S + 1)
    # Lost, she keeps her slot: who remembers her there can show where she was.
    scenario = picture.scenario(at(LOST_AFTER_S + 1), SHIP)
    assert np.asarray(scenario.encounter.present).sum() == 1
    assert len(picture) == 1
    assert not np.asarray(picture.scenario(at(FORGOTTEN_S + 1), SHIP).encounter.present).any()
    assert len(picture) == 0


def test_own_ship_is_dead_reckoned_remarked_on_and_lost():
    picture = taken(own())
    assert float(picture.scenario(at(20), SHIP).encounter.own.north_m) == pytest.approx(100)
    assert not any("s old" in note for note in picture.scenario(at(20), SHIP).notes)
    assert any("60 s old" in note for note in picture.scenario(at(60), SHIP).notes)
    assert picture.scenario(at(LOST_AFTER_S + 1), SHIP) is None
    assert "she is lost" in picture.state(at(LOST_AFTER_S + 1))


def test_own_ship_of_single_sensors():
    position = own(0, course_rad=None, speed_m_s=None)
    picture = taken(position)
    assert picture.scenario(T0, SHIP) is None
    assert picture.state(T0) == "own ship's speed is not known yet"
    said = {"rate_of_turn_rad_s": 0.01, "rudder_rad": 0.05, "heading_rad": 1.3}
    for name, value in (said | {"course_rad": 1.0, "speed_m_s": 4.0}).items():
        picture.take(Report(id="own", time=at(1), own=True, **{name: value}))
    state = picture.scenario(at(1), SHIP).encounter.own
    assert float(state.heading_rad) == pytest.approx(1.0)
    assert float(state.speed_m_s) == 4.0
    assert float(state.rate_of_turn_rad_s) == pytest.approx(0.01)
    assert float(state.rudder_rad) == pytest.approx(0.05)
    assert picture.scenario(at(11), SHIP).own_rudder
    # Adrift, the course over ground is noise; an old rate of turn or rudder is none.
    picture.take(Report(id="own", time=at(2), own=True, speed_m_s=0.2))
    assert float(picture.scenario(at(20), SHIP).encounter.own.heading_rad) == pytest.approx(1.3)
    assert float(picture.scenario(at(20), SHIP).encounter.own.rate_of_turn_rad_s) == 0
    assert not picture.scenario(at(20), SHIP).own_rudder


def test_motion_that_is_not_said_is_taken_from_positions():
    silent = {"course_rad": None, "speed_m_s": None}
    picture = taken(own(), ship(1, 0, 2000, **silent))
    assert targets(picture) == {}
    picture.take(ship(1, 20, 2100, **silent))
    _, _, course, speed, _ = targets(picture, 20)["1"]
    assert (course, speed) == (pytest.approx(0, abs=1e-3), pytest.approx(5, rel=2e-3))


def test_identity_joins_position_and_own_length_scales_the_domain():
    picture = taken(
        own(),
        ship(1),
        Report(id="1", time=T0, name="ALPHA", length_m=90.0, kind="70"),
        Report(id="own", time=T0, own=True, length_m=120.0, beam_m=20.0, name="MYSELF"),
    )
    scenario = picture.scenario(T0, SHIP)
    (k,) = np.flatnonzero(np.asarray(scenario.encounter.present))
    info = scenario.targets[k]
    assert (info.name, info.length_m, info.kind) == ("ALPHA", 90.0, "70")
    assert (scenario.ship.loa_m, scenario.ship.beam_m) == (120.0, 20.0)
    assert scenario.own_name == "MYSELF"


def test_own_ship_under_her_own_number_is_no_target():
    picture = taken(ship(211000001, 0, 10.0), own())
    picture.take(Report(id="211000001", time=T0, heading_rad=0.0, own=True))
    assert targets(picture) == {}


def test_an_echo_is_found_and_a_ship_that_was_ever_apart_is_none():
    picture = taken(own(), ship(1, 0, 0.0, course_rad=0.0), ship(2, 0, 400.0))
    for seconds in range(10, 61, 10):
        north = 5.0 * seconds
        picture.take(own(seconds, north))
        picture.take(ship(1, seconds + 1, north + 10, course_rad=0.0))
        picture.take(ship(2, seconds, max(400 - 6.0 * seconds, north + 30)))
    assert set(targets(picture, 60)) == {"2"}


def test_with_own_number_known_a_ship_alongside_is_shown():
    reports = [own(), Report(id="211000001", time=T0, heading_rad=0.0, own=True)]
    for seconds in range(10, 61, 10):
        reports.append(own(seconds, 5.0 * seconds))
        reports.append(ship(1, seconds, 5.0 * seconds + 60, course_rad=0.0))
    assert set(targets(taken(*reports), 60)) == {"1"}


def test_the_gulf_of_finland_is_seen_as_the_recording_has_it():
    reports = recording()
    picture = Picture("gulf")
    for i in range(len(reports)):
        r = reports
        mine = r.mmsi[i] == OWN_SENSORS
        given = {
            "speed_m_s": r.sog_kn[i].item() * KNOT_M_S,
            "course_rad": math.radians(r.cog_deg[i].item()),
        }
        picture.take(
            Report(
                id="own" if mine else str(r.mmsi[i]),
                time=datetime.fromtimestamp(r.time_s[i].item(), UTC),
                latitude_deg=r.latitude_deg[i].item(),
                longitude_deg=r.longitude_deg[i].item(),
                own=bool(mine),
                **{name: v for name, v in given.items() if not math.isnan(v)},
            )
        )
    scenario = picture.scenario(picture.heard, SHIP)
    assert int(np.asarray(scenario.encounter.present).sum()) == 94  # 95, and one is her echo
    assert "230035780" not in {info.id for info in scenario.targets}
    refused = picture.counts.refused
    # What recorded traffic drops is refused here as well, and hardly anything else.
    assert refused[Refusal.JUMP] == refused[Refusal.TIME_JUMP] == refused[Refusal.IMPOSSIBLE] == 0
    assert picture.counts.understood > 0.95 * picture.counts.heard


@pytest.mark.parametrize(
    ("said", "why"),
    [
        ({"north_m": 9000.0}, Refusal.JUMP),
        ({"course_rad": 0.5}, Refusal.JUMP),
        ({"seconds": -1.0}, Refusal.LATE),
        ({"seconds": 0.0}, Refusal.REPEATED),
        ({"speed_m_s": 40.0}, Refusal.IMPOSSIBLE),
        ({"speed_m_s": math.nan}, Refusal.IMPOSSIBLE),
        ({"course_rad": math.inf}, Refusal.IMPOSSIBLE),
        ({"length_m": -5.0}, Refusal.IMPOSSIBLE),
        ({"north_m": math.nan}, Refusal.IMPOSSIBLE),
        ({"north_m": 1e9}, Refusal.IMPOSSIBLE),
        ({"number": "x" * 1000}, Refusal.IMPOSSIBLE),
        ({"seconds": 1e6}, Refusal.TIME_JUMP),
    ],
)
def test_what_is_not_believed_is_counted_and_changes_nothing(said, why):
    picture = taken(own(), ship(1, 0, 2000.0))
    before = targets(picture, 2)
    said = {"number": 1, "seconds": 2.0, "north_m": 1990.0} | said
    assert picture.take(ship(**said)) is why
    assert picture.counts.refused[why] == 1
    assert targets(picture, 2) == before
    assert picture.counts.waiting == 0


def test_reports_that_agree_outweigh_the_track_before_them():
    picture = taken(own(), ship(1))
    refused = [picture.take(ship(1, 10 * k, 9000.0 - 50 * k)) for k in (1, 2, 3)]
    assert refused == [Refusal.JUMP, Refusal.JUMP, None]
    assert targets(picture, 30)["1"][1] == pytest.approx(8850, rel=2e-3)
    # Scattered ones do not.
    wild = [picture.take(ship(1, 30 + k, 3e4 * k)) for k in (1, 2, 3, 4)]
    assert set(wild) == {Refusal.JUMP}


def test_a_ship_may_turn_and_a_stopped_ship_may_swing():
    picture = taken(own(), ship(1))
    assert picture.take(ship(1, 6, 1980.0, course_rad=math.pi - 0.7)) is None
    assert picture.take(ship(1, 60, 1900.0, course_rad=0.5)) is None
    picture.take(ship(2, 0, speed_m_s=0.1))
    assert picture.take(ship(2, 3, speed_m_s=0.1, course_rad=1.0)) is None


def test_a_recording_that_begins_anew_is_followed():
    picture = taken(*(own(s, 5.0 * s) for s in range(0, 600, 10)), ship(1, 590))
    again = [picture.take(own(s, 5.0 * s)) for s in range(0, 60, 10)]
    assert again[:3] == [Refusal.LATE, Refusal.LATE, None]
    assert picture.heard == at(50)
    assert targets(picture, 50) == {}
    assert picture.scenario(at(50), SHIP) is not None


def test_after_a_gap_the_time_is_believed_when_three_agree():
    picture = taken(own(), ship(1))
    later = [picture.take(own(7200 + k, 36000 + 5 * k)) for k in range(3)]
    assert later == [Refusal.TIME_JUMP, Refusal.TIME_JUMP, None]
    assert picture.heard == at(7202)
    assert targets(picture, 7202) == {}


def test_the_time_of_the_stream_goes_on_when_nothing_is_heard(monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(picture_module.time, "monotonic", lambda: clock[0])
    picture = taken(own(3.0))
    clock[0] += 40
    assert picture.now() == at(43)
    # An identity dated by another clock moves nothing.
    picture.take(Report(id="1", time=datetime(2026, 1, 1, tzinfo=UTC), name="X"))
    assert picture.heard == at(3)


def test_a_ship_keeps_her_slot():
    picture = taken(own(), *(ship(n, 0, 1000.0 + n) for n in range(1, 9)), slots=8)

    def slots(seconds=0.0):
        return [info.id for info in picture.scenario(at(seconds), SHIP).targets]

    first = slots()
    assert sorted(first) == [str(n) for n in range(1, 9)]
    # A ninth, nearer than all: the farthest gives up her slot, which stays empty once.
    picture.take(ship(9, 1, 900.0))
    k = first.index("8")
    emptied, taken_over = slots(1), slots(2)
    assert emptied == [*first[:k], "", *first[k + 1 :]]
    assert taken_over == [*first[:k], "9", *first[k + 1 :]]


def test_memory_is_bounded_with_any_number_of_ships(monkeypatch):
    monkeypatch.setattr(picture_module, "MOST_SHIPS", 100)
    picture = taken(own())
    for n in range(1, 1000):
        picture.take(ship(n, 0, 10.0 * n))
    assert len(picture) <= 100
    assert picture.counts.waiting == 0
    nearest = {str(n) for n in range(30, 80)}  # those nearer are as near as an echo is not
    assert nearest <= set(targets(picture))


def test_ships_out_of_sight_are_known_and_not_shown():
    picture = taken(own(), ship(1, 0, SHOWN_M + 2000), ship(2))
    assert set(targets(picture)) == {"2"}
    assert len(picture) == 2


@pytest.mark.parametrize(
    "place", [(-59.7, -155.3), (0.0, 179.9999), (88.9, 0.0), (-88.9, 24.7), (59.7, 24.7)]
)
def test_own_ship_may_be_anywhere(place):
    picture = taken(own())
    picture.scenario(T0, SHIP)
    for k in range(3):  # a jump, until three agree
        picture.take(
            Report(
                id="own", time=at(10 + k), own=True, course_rad=1.0, speed_m_s=5.0,
                latitude_deg=place[0], longitude_deg=place[1] + k * 1e-5,
            )
        )  # fmt: skip
    scenario = picture.scenario(at(12), SHIP)
    state = scenario.encounter.own
    assert all(np.isfinite(float(x)) for x in vars(state).values())
    assert math.hypot(float(state.east_m), float(state.north_m)) <= RECENTRE_M
    assert scenario.origin == pytest.approx(place, abs=1e-3)


def test_the_origin_stays_until_own_ship_is_far_from_it():
    picture = taken(own())
    origin = picture.scenario(T0, SHIP).origin
    seen = []
    for seconds in range(0, 8000, 100):
        picture.take(own(seconds, 5.0 * seconds))
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
        picture.take(own(seconds, 0.01 * seconds, course_rad=math.pi / 2))
        there = waypoint(seconds)
        if seconds <= MEANT_S:
            assert there == pytest.approx(ahead, abs=1)
    assert there[0] == pytest.approx(AHEAD_M, rel=1e-2)


@pytest.mark.parametrize("name", ["straight", "large-ship-planner", "large-ship-attention"])
def test_pilots_take_it_and_nothing_is_compiled_anew(name):
    """Ships come, go and change; what was compiled for the first scenario serves all."""
    pilot, settings = pilot_named(name), WorldSettings()
    traced = []

    @eqx.filter_jit
    def look(encounter, ship):
        traced.append(name)
        state = begin(encounter, ship, settings)
        held, memory = never_held(encounter), pilot.start()
        return moment_of(pilot, encounter, state, held, memory, ship, settings, 0.0)[0]

    picture = taken(own(), ship(1))
    for k in range(5):
        picture.take(own(10 * k, 50.0 * k, speed_m_s=5.0 + 0.1 * k))
        for n in range(1, 2 + 7 * k):
            picture.take(ship(n, 10 * k, 3000.0 + 300 * n, speed_m_s=4.0))
        scenario = picture.scenario(at(10 * k), SHIP)
        moment = jax.device_get(look(scenario.encounter, scenario.ship))
        frame = Framer(scenario, pilot, applied=False).frame(moment, 0.0, None)
        assert {target.id for target in frame.targets} == set(targets(picture, 10 * k))
        assert all(target.tcpa_s > 0 and target.age_s is not None for target in frame.targets)
        assert frame.time_utc == f"2014-08-15T19:00:{10 * k:02d}Z"
        assert frame.own.speed_m_s == pytest.approx(5.0 + 0.1 * k, abs=1e-4)
        assert scenario.encounter.present.shape == (SLOTS,)
    assert len(traced) == 1


def test_a_scenario_can_be_sailed_with_advice():
    picture = taken(own(), ship(1))
    frames = list(sail(picture.scenario(T0, SHIP), StraightPilot(), steps=3, advise=True))
    assert len(frames) == 4
    assert frames[-1].own.north_m == pytest.approx(75, rel=1e-3)
    assert frames[-1].targets[0].age_s == pytest.approx(15)


def routed(seconds, east_m=0.0, north_m=0.0):
    """Her route's next waypoint, so far from HERE."""
    longitude = HERE[1] + east_m * NORTH / math.cos(math.radians(HERE[0]))
    return Report(
        id="own", time=at(seconds), own=True,
        waypoint_latitude_deg=HERE[0] + north_m * NORTH, waypoint_longitude_deg=longitude,
    )  # fmt: skip


def shown(picture, seconds):
    """The waypoint shown to pilots, from own ship: range [m] and bearing [°]."""
    scenario = picture.scenario(at(seconds), SHIP)
    route, here = scenario.encounter.route, scenario.encounter.own
    east, north = float(route.x[0] - here.east_m), float(route.y[0] - here.north_m)
    return math.hypot(east, north), math.degrees(math.atan2(east, north))


def test_a_route_that_is_told_is_steered_for():
    picture = Picture()
    picture.take(own())
    assert any("no route" in note for note in picture.scenario(at(0), SHIP).notes)
    assert picture.take(routed(1, east_m=20_000.0, north_m=20_000.0)) is None
    range_m, bearing = shown(picture, 1)
    assert range_m == pytest.approx(28_284, rel=0.01)
    assert bearing == pytest.approx(45.0, abs=0.5)
    assert not any("no route" in note for note in picture.scenario(at(1), SHIP).notes)


@pytest.mark.parametrize("away", [2_000.0, 90_000.0])
def test_a_told_waypoint_is_shown_at_a_distance_that_pilots_know(away):
    picture = Picture()
    picture.take(own())
    picture.take(routed(1, east_m=away))
    range_m, bearing = shown(picture, 1)
    assert range_m * 1.001 >= NEAR_M
    assert range_m <= AHEAD_M * 1.001
    assert bearing == pytest.approx(90.0, abs=1.0)


def test_a_waypoint_that_is_reached_or_given_up_is_no_aim_any_more():
    picture = Picture()
    picture.take(own())
    picture.take(routed(1, north_m=300.0))
    assert shown(picture, 1)[1] == pytest.approx(0.0, abs=0.5)
    assert any("no route" in note for note in picture.scenario(at(1), SHIP).notes)
    picture.take(routed(2, east_m=20_000.0))  # abeam: she does not steer for it
    for seconds in range(10, int(MEANT_S) + 60, 10):
        picture.take(own(seconds, north_m=5.0 * seconds))
        _, bearing = shown(picture, seconds)
    assert bearing == pytest.approx(0.0, abs=1.0)
