import dataclasses
import math
import time
from importlib.resources import files
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.core.errors import InputError
from glasshelm.encounters.own_ship_candidates import own_ship_candidates
from glasshelm.encounters.recorded_traffic import RecordingSettings, recorded_scenario
from glasshelm.encounters.recording_window import read_recording
from glasshelm.encounters.types import motion_at
from glasshelm.ship.nomoto import KNOT_M_S, SHIPS

SHIP = SHIPS["paper"]
DATA = Path(str(files("glasshelm") / "data"))
GULF, HARBOUR = DATA / "gulf_of_finland.csv.gz", DATA / "new_york.csv.gz"
OWN, OTHER, LATE = 211000001, 211000002, 211000003
SPEED_KN = 10.8  # 0.05 minutes of latitude every 10 s, at 0.003° a minute


def recording(tmp_path, *extra, kind="csv"):
    """Own ship north at 10.8 kn, another 2 NM east abreast of her; both once a minute."""
    rows = ["t,kind,mmsi,lat,lon,sog,cog,heading,name,length_m,beam_m"]
    for minute in range(31):
        t = f"2024-01-01T00:{minute:02d}:00"
        lat = 59 + 0.003 * minute
        rows.append(f"{t},ais,{OWN},{lat:.5f},10.5,{SPEED_KN},0,5,OWN SHIP,200,30")
        rows.append(f"{t},ais,{OTHER},{lat:.5f},10.565,{SPEED_KN},0,0,OTHER,80,12")
    path = tmp_path / f"made.{kind}"
    path.write_text("\n".join([*rows, *extra]) + "\n")
    return path


def at(scenario, time_s):
    return motion_at(scenario.encounter.targets, jnp.asarray(float(time_s)))


def own_at(scenario, time_s):
    assert scenario.own_track is not None
    return motion_at(scenario.own_track, jnp.asarray(float(time_s)))


def test_any_ship_can_be_own_ship(tmp_path):
    settings = RecordingSettings(min_waypoint_m=0.0)
    s = recorded_scenario(recording(tmp_path), SHIP, str(OWN), settings=settings)
    assert (s.own_name, [t.name for t in s.targets]) == ("OWN SHIP", ["OTHER"])
    assert (s.ship.loa_m, s.ship.beam_m, s.ship.gain_1_s) == (200.0, 30.0, SHIP.gain_1_s)
    assert s.ship.speed_m_s == pytest.approx(SPEED_KN * KNOT_M_S)
    assert float(s.encounter.own.heading_rad) == pytest.approx(math.radians(5))
    assert float(s.encounter.own.east_m) == float(s.encounter.own.north_m) == 0
    assert s.duration_s == 1800
    assert s.start is not None
    assert s.start.isoformat() == "2024-01-01T00:00:00+00:00"
    # 0.003° of latitude a minute is 334.2 m; her waypoint is her last position, 10.03 km north.
    np.testing.assert_allclose(
        [s.encounter.route.x[0], s.encounter.route.y[0]], [0, 10_026], atol=10
    )
    for time_s in (0.0, 90.0, 1799.0):
        own, target = own_at(s, time_s), at(s, time_s)
        assert float(own.north_m) == pytest.approx(334.2 / 60 * time_s, abs=5)
        # Abreast at the same latitude: the plane's parallel bends by 2 m here.
        assert float(target.north_m[0]) == pytest.approx(float(own.north_m), abs=5)
        assert float(target.east_m[0]) == pytest.approx(3734, abs=15)


def test_reports_are_legs_and_silence_is_lost(tmp_path):
    extra = [f"2024-01-01T00:10:00,ais,{LATE},59.05,10.6,6,270,,,,"]
    s = recorded_scenario(recording(tmp_path, *extra), SHIP, OWN)
    slot = [t.id for t in s.targets].index(str(LATE))
    there = {599: False, 600: True, 959: True, 961: False}
    for time_s, expected in there.items():
        assert bool(at(s, time_s).present[slot]) == expected
    run = float(at(s, 600).east_m[slot] - at(s, 900).east_m[slot])
    assert run == pytest.approx(300 * 6 * KNOT_M_S, rel=1e-3)
    assert float(at(s, 900).age_s[slot]) == pytest.approx(300, abs=0.1)
    patient = recorded_scenario(
        recording(tmp_path, *extra), SHIP, OWN, settings=RecordingSettings(lost_after_s=700.0)
    )
    assert bool(at(patient, 1250).present[slot])


def test_a_later_start_knows_what_was_heard_before(tmp_path):
    s = recorded_scenario(recording(tmp_path), SHIP, OWN, at="00:10:30")
    assert s.duration_s == 1170
    assert s.start is not None
    assert s.start.minute == 10
    # Half a minute after the last report both are dead-reckoned to the instant of the start.
    now = at(s, 0)
    assert bool(now.present[0])
    assert float(now.age_s[0]) == pytest.approx(30, abs=0.1)
    assert float(own_at(s, 0).north_m) == pytest.approx(0, abs=1)
    assert float(now.north_m[0]) == pytest.approx(0, abs=5)


@pytest.mark.parametrize("when", ["00:45", "2023-12-31T23:59:00", "2024-01-01T00:30:00"])
def test_a_start_when_she_is_not_heard(tmp_path, when):
    with pytest.raises(InputError, match="heard from 2024-01-01T00:00:00 to 2024-01-01T00:30:00"):
        recorded_scenario(recording(tmp_path), SHIP, OWN, at=when)


def test_a_start_that_is_no_time(tmp_path):
    with pytest.raises(InputError, match="'soon': must be ISO 8601"):
        recorded_scenario(recording(tmp_path), SHIP, OWN, at="soon")


def test_candidates_are_listed_when_no_own_ship_is_named(tmp_path):
    with pytest.raises(InputError, match="no own ship in it; choose --own MMSI") as error:
        recorded_scenario(recording(tmp_path), SHIP)
    assert f"{OWN} OWN SHIP (30 min, 11 kn, meets 0 ships)" in str(error.value)
    with pytest.raises(InputError, match="no usable report of MMSI 5 in it; choose"):
        recorded_scenario(recording(tmp_path), SHIP, 5)
    with pytest.raises(InputError, match="no recorded own ship"):
        recorded_scenario(recording(tmp_path), SHIP, "recorded")
    with pytest.raises(InputError, match="must be an MMSI or 'recorded'"):
        recorded_scenario(recording(tmp_path), SHIP, "me")


def test_candidates_prefer_ships_that_meet_others(tmp_path):
    extra = [
        f"2024-01-01T00:{m:02d}:00,ais,{LATE},{59 + 0.003 * m:.5f},10.59,{SPEED_KN},0,,,,"
        for m in range(31)
    ]
    cleaned = read_recording(recording(tmp_path, *extra))
    best = own_ship_candidates(cleaned.reports, cleaned.ships)
    # OTHER has LATE 0.8 NM to the east of her and OWN 2.0 NM to the west; OWN has nobody nearer.
    assert [c.mmsi for c in best[:2]] == [OTHER, LATE]
    assert [c.n_meetings for c in best] == [1, 1, 0]


def test_a_ship_that_goes_nowhere_cannot_be_own_ship(tmp_path):
    extra = [f"2024-01-01T00:{m:02d}:00,ais,{LATE},59.05,10.6,0,0,,MOORED,," for m in range(31)]
    with pytest.raises(InputError, match=f"MMSI {LATE} stays within 0 m of her start"):
        recorded_scenario(recording(tmp_path, *extra), SHIP, LATE)


def test_a_ship_that_comes_back_has_her_farthest_point_as_waypoint(tmp_path):
    extra = [
        f"2024-01-01T00:{m:02d}:00,ais,{LATE},59.0,{10.6 + 0.01 * (15 - abs(m - 15)):.4f},18,90,,,,"
        for m in range(31)
    ]
    settings = RecordingSettings(min_waypoint_m=0.0)
    s = recorded_scenario(recording(tmp_path, *extra), SHIP, LATE, settings=settings)
    assert float(s.encounter.route.x[0]) == pytest.approx(8608, rel=0.01)
    assert any("comes back" in note for note in s.notes)


def test_nearest_waypoint_and_length_can_be_chosen(tmp_path):
    settings = RecordingSettings(min_waypoint_m=20_000.0, loa_m=50.0)
    s = recorded_scenario(recording(tmp_path), SHIP, OWN, settings=settings)
    assert float(s.encounter.route.y[0]) == pytest.approx(20_000, rel=1e-4)
    assert s.ship.loa_m == 50.0


def test_stops_do_not_count_to_the_speed(tmp_path):
    # North at 10.8 kn for 10 min, stopped for 15, at 10.8 kn again for 15: a mean of 6.75 kn.
    rows = ["t,mmsi,lat,lon,sog,cog"]
    for minute in range(41):
        sailed = min(minute, 10) + max(minute - 25, 0)
        sog = 0.2 if 10 <= minute < 25 else SPEED_KN
        rows.append(f"2024-01-01T00:{minute:02d}:00,{OWN},{59 + 0.003 * sailed:.5f},10.5,{sog},0")
    path = tmp_path / "stops.csv"
    path.write_text("\n".join(rows))
    s = recorded_scenario(path, SHIP, OWN)
    assert s.ship.speed_m_s == pytest.approx(SPEED_KN * KNOT_M_S)
    assert any("stops or drifts for 15 of 40 min" in note for note in s.notes)


def test_a_slow_ship_is_under_way_too(tmp_path):
    rows = ["t,mmsi,lat,lon,sog,cog"]
    for minute in range(60):
        rows.append(f"2024-01-01T00:{minute:02d}:00,{OWN},{59 + 0.0006 * minute:.5f},10.5,2.16,0")
    path = tmp_path / "slow.csv"
    path.write_text("\n".join(rows))
    s = recorded_scenario(path, SHIP, OWN)
    assert s.ship.speed_m_s == pytest.approx(2.16 * KNOT_M_S)
    assert not any("stops" in note for note in s.notes)


def test_gulf_of_finland_has_its_recorded_own_ship():
    s = recorded_scenario(GULF, SHIP)
    assert len(s.targets) == 94
    assert "230035780" not in {t.id for t in s.targets}
    assert any("230035780 is own ship's echo" in note for note in s.notes)
    assert s.ship.speed_m_s == pytest.approx(6.7 * KNOT_M_S, rel=0.05)
    assert 599 < s.duration_s < 601
    for time_s in np.arange(0.0, 599.0, 30.0):
        own, traffic = own_at(s, time_s), at(s, time_s)
        assert bool(own.present)
        range_m = np.hypot(traffic.east_m - own.east_m, traffic.north_m - own.north_m)
        assert range_m[np.asarray(traffic.present)].min() > 150, "nobody sails on own ship"


def test_dead_reckoning_of_the_recorded_own_ship_joins_her_track():
    # Each 1 Hz leg leads to the beginning of the next within the scatter of the receiver.
    track = recorded_scenario(GULF, SHIP).own_track
    assert track is not None
    start, east, north, course, speed = (
        np.asarray(x)
        for x in (track.start_s, track.east_m, track.north_m, track.course_rad, track.speed_m_s)
    )
    lasts = np.diff(start)
    off = np.hypot(
        east[:-1] + speed[:-1] * lasts * np.sin(course[:-1]) - east[1:],
        north[:-1] + speed[:-1] * lasts * np.cos(course[:-1]) - north[1:],
    )
    assert np.median(off) < 0.5


def test_the_recorder_is_not_there_twice_when_another_ship_is_own():
    s = recorded_scenario(GULF, SHIP, 276813000)
    ids = {t.id for t in s.targets}
    assert "230035780" in ids
    assert "recorded" not in ids
    assert "276813000" not in ids


def test_new_york_loads_fast_and_finite():
    begun = time.process_time()
    s = recorded_scenario(HARBOUR, SHIP, 367000190)
    assert time.process_time() - begun < 2.0
    assert (s.own_name, s.ship.loa_m) == ("JOHN F KENNEDY", 84.0)
    assert len(s.targets) > 250
    for field in dataclasses.fields(s.encounter.targets):
        values = np.asarray(getattr(s.encounter.targets, field.name))
        assert not np.any(np.isnan(values))
    now = at(s, 600)
    assert int(now.present.sum()) > 200


def test_dead_reckoning_in_the_harbour_meets_the_next_report():
    # The course convention, the units and the projection in one: from each report of a moving
    # ship to her next one within two minutes the median miss is small against the way made.
    s = recorded_scenario(HARBOUR, SHIP, 367000190)
    t = s.encounter.targets
    start, east, north, course, speed = (
        np.asarray(x, np.float64)
        for x in (t.start_s, t.east_m, t.north_m, t.course_rad, t.speed_m_s)
    )
    start[~np.isfinite(start)] = np.nan
    lasts = np.diff(start)
    there_east = east[:, :-1] + speed[:, :-1] * lasts * np.sin(course[:, :-1])
    there_north = north[:, :-1] + speed[:, :-1] * lasts * np.cos(course[:, :-1])
    off = np.hypot(there_east - east[:, 1:], there_north - north[:, 1:])
    way = speed[:, :-1] * lasts
    moving = (way > 100) & (lasts < 120)
    assert moving.sum() > 300
    # Ferries and tugs turn and slow down meanwhile; a wrong convention would miss by the way made.
    assert np.median(off[moving] / way[moving]) < 0.2


def test_a_file_without_a_usable_report(tmp_path):
    path = tmp_path / "bad.csv"
    path.write_text("t,mmsi,lat,lon,sog,cog\n2024-01-01T00:00:00,1,91,181,102.3,360\n")
    with pytest.raises(InputError, match=r"no usable report \(1 report dropped: impossible"):
        recorded_scenario(path, SHIP, 1)
