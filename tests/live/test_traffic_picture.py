"""What a picture makes of reports: who is where, and who is no longer."""

import math
from datetime import UTC, datetime

import equinox as eqx
import jax
import numpy as np
import pytest
from benchmarks.feeds_fuzz import recording
from tests.live.reports import SHIP, T0, at, own, ship, taken, targets

from glasshelm.ais.limits import FORGOTTEN_S, LOST_AFTER_S
from glasshelm.ais.reports import RejectReason, Report
from glasshelm.ais.table import OWN_SENSORS
from glasshelm.env.step import EnvSettings, reset
from glasshelm.live import vessel_store
from glasshelm.live.traffic_picture import SHOWN_M, SLOTS, TrafficPicture
from glasshelm.pilots.registry import pilot_named
from glasshelm.pilots.straight import StraightPilot
from glasshelm.ship.nomoto import KNOT_M_S
from glasshelm.simulation.explained_step import explain_step, no_known_targets
from glasshelm.simulation.frame_builder import FrameBuilder
from glasshelm.simulation.voyage import simulate


def test_nothing_is_known_at_first():
    picture = TrafficPicture()
    assert picture.latest_time is None
    assert picture.now() is None
    assert picture.scenario(T0, SHIP) is None
    assert picture.status(T0) == "nothing heard yet"
    picture.update(ship(1))
    assert picture.scenario(T0, SHIP) is None
    assert picture.status(T0) == "no position of own ship yet (1 other ships heard)"


def test_a_target_is_dead_reckoned_from_her_latest_report():
    picture = taken(own(), ship(1, -30.0, 2000.0))
    east, north, course, speed, age = targets(picture)["1"]
    assert (east, north) == (pytest.approx(0, abs=1), pytest.approx(2000 - 150, rel=2e-3))
    assert (abs(course), speed, age) == (pytest.approx(math.pi), 5.0, pytest.approx(30))
    picture.update(ship(1, -10.0, 1900.0))
    assert targets(picture)["1"][1] == pytest.approx(1850, rel=2e-3)
    assert targets(picture)["1"][4] == pytest.approx(10)


def test_a_target_is_lost_by_the_limits_of_recorded_traffic_and_forgotten_later():
    picture = taken(own(), ship(1))
    for seconds in range(1, 900, 20):
        picture.update(own(seconds, 5.0 * seconds))
    assert "1" in targets(picture, LOST_AFTER_S - 1)
    assert "1" not in targets(picture, LOST_AFTER_S + 1)
    # Lost, she keeps her slot: who remembers her there can show where she was.
    scenario = picture.scenario(at(LOST_AFTER_S + 1), SHIP)
    assert np.asarray(scenario.encounter.present).sum() == 1
    assert len(picture) == 1
    assert not np.asarray(picture.scenario(at(FORGOTTEN_S + 1), SHIP).encounter.present).any()
    assert len(picture) == 0


def test_motion_that_is_not_said_is_taken_from_positions():
    silent = {"course_rad": None, "speed_m_s": None}
    picture = taken(own(), ship(1, 0, 2000, **silent))
    assert targets(picture) == {}
    picture.update(ship(1, 20, 2100, **silent))
    _, _, course, speed, _ = targets(picture, 20)["1"]
    assert (course, speed) == (pytest.approx(0, abs=1e-3), pytest.approx(5, rel=2e-3))


@pytest.mark.slow
def test_the_gulf_of_finland_is_seen_as_the_recording_has_it():
    reports = recording()
    picture = TrafficPicture("gulf")
    for i in range(len(reports)):
        r = reports
        mine = r.mmsi[i] == OWN_SENSORS
        given = {
            "speed_m_s": r.sog_kn[i].item() * KNOT_M_S,
            "course_rad": math.radians(r.cog_deg[i].item()),
        }
        picture.update(
            Report(
                id="own" if mine else str(r.mmsi[i]),
                time=datetime.fromtimestamp(r.time_s[i].item(), UTC),
                latitude_deg=r.latitude_deg[i].item(),
                longitude_deg=r.longitude_deg[i].item(),
                is_own=bool(mine),
                **{name: v for name, v in given.items() if not math.isnan(v)},
            )
        )
    scenario = picture.scenario(picture.latest_time, SHIP)
    assert int(np.asarray(scenario.encounter.present).sum()) == 94  # 95, and one is her echo
    assert "230035780" not in {info.id for info in scenario.targets}
    refused = picture.counts.rejected
    # What recorded traffic drops is refused here as well, and hardly anything else.
    assert (
        refused[RejectReason.JUMP]
        == refused[RejectReason.TIME_JUMP]
        == refused[RejectReason.IMPLAUSIBLE]
        == 0
    )
    assert picture.counts.accepted > 0.95 * picture.counts.received


def test_a_ship_keeps_her_slot():
    picture = taken(own(), *(ship(n, 0, 1000.0 + n) for n in range(1, 9)), slots=8)

    def slots(seconds=0.0):
        return [info.id for info in picture.scenario(at(seconds), SHIP).targets]

    first = slots()
    assert sorted(first) == [str(n) for n in range(1, 9)]
    # A ninth, nearer than all: the farthest gives up her slot, which stays empty once.
    picture.update(ship(9, 1, 900.0))
    k = first.index("8")
    emptied, taken_over = slots(1), slots(2)
    assert emptied == [*first[:k], "", *first[k + 1 :]]
    assert taken_over == [*first[:k], "9", *first[k + 1 :]]


def test_memory_is_bounded_with_any_number_of_ships(monkeypatch):
    monkeypatch.setattr(vessel_store, "MAX_SHIPS", 100)
    picture = taken(own())
    for n in range(1, 1000):
        picture.update(ship(n, 0, 10.0 * n))
    assert len(picture) <= 110
    assert picture.counts.pending == 0
    nearest = {str(n) for n in range(30, 80)}  # those nearer are as near as an echo is not
    assert nearest <= set(targets(picture))


def test_a_new_far_ship_takes_no_near_one_s_place(monkeypatch):
    monkeypatch.setattr(vessel_store, "MAX_SHIPS", 100)
    picture = taken(own(), *(ship(n, 0, 500.0 + 10.0 * n) for n in range(1, 51)))
    refused = [picture.update(ship(n, 1, 3000.0 + n)) for n in range(100, 1000)]
    assert refused.count(RejectReason.TOO_FAR) > 700
    assert {str(n) for n in range(1, 51)} <= set(targets(picture, 1))
    assert picture.update(ship(2000, 1, 600.0)) is None  # a near one always has room
    assert "2000" in targets(picture, 1)
    notes = picture.scenario(at(1), SHIP).notes
    assert any(note.startswith("more ships are heard than are kept") for note in notes)
    # Who tells no place is not kept while there are too many, and the notes go as they go.
    assert picture.update(Report(id="3000", time=at(1), name="X")) is RejectReason.TOO_FAR
    for seconds in range(100, 1100, 100):
        picture.update(own(seconds, 5.0 * seconds))
    picture.scenario(at(1000), SHIP)
    assert picture.update(ship(4000, 1001, 80_000.0)) is None
    assert not any("more ships" in note for note in picture.scenario(at(1001), SHIP).notes)


def test_where_own_ship_is_not_known_the_ships_heard_last_are_kept(monkeypatch):
    monkeypatch.setattr(vessel_store, "MAX_SHIPS", 100)
    picture = TrafficPicture()
    for n in range(1, 1000):
        picture.update(ship(n, n / 10, 10.0 * n))
    assert len(picture) <= 110
    assert "999" in picture._others.ships
    assert "1" not in picture._others.ships


def test_ships_out_of_sight_are_known_and_not_shown():
    picture = taken(own(), ship(1, 0, SHOWN_M + 2000), ship(2))
    assert set(targets(picture)) == {"2"}
    assert len(picture) == 2


@pytest.mark.slow
@pytest.mark.parametrize("name", ["straight", "large-ship-mpc", "large-ship-attention"])
def test_pilots_take_it_and_nothing_is_compiled_anew(name):
    """Ships come, go and change; what was compiled for the first scenario serves all."""
    pilot, settings = pilot_named(name), EnvSettings()
    traced = []

    @eqx.filter_jit
    def look(encounter, ship):
        traced.append(name)
        state = reset(encounter, ship, settings)
        held, memory = no_known_targets(encounter), pilot.start()
        return explain_step(pilot, encounter, state, held, memory, ship, settings, 0.0)[0]

    picture = taken(own(), ship(1))
    for k in range(5):
        picture.update(own(10 * k, 50.0 * k, speed_m_s=5.0 + 0.1 * k))
        for n in range(1, 2 + 7 * k):
            picture.update(ship(n, 10 * k, 3000.0 + 300 * n, speed_m_s=4.0))
        scenario = picture.scenario(at(10 * k), SHIP)
        moment = jax.device_get(look(scenario.encounter, scenario.ship))
        frame = FrameBuilder(scenario, pilot, applied=False).frame(moment, 0.0, None)
        assert {target.id for target in frame.targets} == set(targets(picture, 10 * k))
        assert all(target.tcpa_s > 0 and target.age_s is not None for target in frame.targets)
        assert frame.time_utc == f"2014-08-15T19:00:{10 * k:02d}Z"
        assert frame.own.speed_m_s == pytest.approx(5.0 + 0.1 * k, abs=1e-4)
        assert scenario.encounter.present.shape == (SLOTS,)
    assert len(traced) == 1


@pytest.mark.slow
def test_a_scenario_can_be_sailed_with_advice():
    picture = taken(own(), ship(1))
    frames = list(simulate(picture.scenario(T0, SHIP), StraightPilot(), steps=3, advise=True))
    assert len(frames) == 4
    assert frames[-1].own.north_m == pytest.approx(75, rel=1e-3)
    assert frames[-1].targets[0].age_s == pytest.approx(15)


def test_a_course_that_nothing_tells_is_no_direction():
    """She is shown where she is; it is not made up that she goes north at 5 m/s."""
    silent = {"course_rad": None, "heading_rad": None}
    picture = taken(own(), ship(1, 0, 2000.0, speed_m_s=5.0, **silent))
    first, later = (targets(picture, seconds)["1"] for seconds in (0, 20))
    assert first[:2] == later[:2]
    assert first[3] == 0.0
    picture.update(ship(1, 20, 1900.0, speed_m_s=5.0, **silent))
    _, _, course, speed, _ = targets(picture, 20)["1"]
    assert (abs(course), speed) == (pytest.approx(math.pi, abs=1e-3), 5.0)


def test_senders_of_distress_are_named_so():
    numbers = {
        "970012345": "SART 970012345",
        "972012345": "MOB 972012345",
        "974012345": "EPIRB 974012345",
        "230012345": "MMSI 230012345",
        "urn:x": "urn:x",
    }
    picture = taken(own(), *(ship(n, north_m=500.0 * (k + 1)) for k, n in enumerate(numbers)))
    scenario = picture.scenario(at(0), SHIP)
    assert {t.id: t.name for t in scenario.targets if t.id} == numbers
    picture.update(Report(id="970012345", time=at(1), name="RAFT"))
    assert "RAFT" in [t.name for t in picture.scenario(at(1), SHIP).targets]
