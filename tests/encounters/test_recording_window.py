"""What part of a recording is taken: by time, by area, whatever its size."""

import numpy as np
import pytest

from glasshelm.ais.table import OWN_SENSORS, ReportTable, StaticData
from glasshelm.core.errors import InputError
from glasshelm.encounters import recording_window
from glasshelm.encounters.own_ship_candidates import own_ship_candidates
from glasshelm.encounters.recorded_traffic import recorded_scenario
from glasshelm.encounters.scenario_factory import recording_settings
from glasshelm.encounters.snapshots import closest_approaches, ecef, snapshots
from glasshelm.ship.nomoto import SHIPS

SHIP = SHIPS["paper"]
OWN, NEAR, FAR = 211000001, 211000002, 211000003


def rows(day="2024-01-01", hour=12, ships=((OWN, 59.0, 10.5), (NEAR, 59.0, 10.6))):
    """Ships going north at 10.8 kn for half an hour, a report a minute."""
    return [
        f"{day}T{hour:02d}:{minute:02d}:00,{mmsi},{lat + 0.003 * minute:.5f},{lon},10.8,0"
        for minute in range(30)
        for mmsi, lat, lon in ships
    ]


def written(tmp_path, *lines):
    path = tmp_path / "traffic.csv"
    path.write_text("\n".join(["t,mmsi,lat,lon,sog,cog", *lines]) + "\n")
    return path


@pytest.mark.parametrize("time", ["2031-05-01T00:00:00", "2024-01-01T02:00:00", "1995-01-01 00:00"])
@pytest.mark.parametrize("mmsi", [OWN, NEAR])
def test_a_row_of_another_time_is_left_out_and_told(tmp_path, time, mmsi):
    path = written(tmp_path, *rows(), f"{time},{mmsi},59.0,10.5,10.8,0")
    s = recorded_scenario(path, SHIP, OWN)
    assert s.duration_s == 29 * 60
    assert str(s.start) == "2024-01-01 12:00:00+00:00"
    (note,) = [n for n in s.notes if "left out" in n]
    assert note.startswith(
        f"1 report of {time[:13].replace('T', ' ')}:00 left out: 6 hours or more"
    )


def test_the_stretch_of_most_ships_is_taken_not_that_of_most_reports(tmp_path):
    loud = [
        f"2024-01-02T12:{m:02d}:{s:02d},{OWN},59.0,10.5,0,0" for m in range(60) for s in range(60)
    ]
    path = written(tmp_path, *rows(), *loud)
    s = recorded_scenario(path, SHIP, OWN)
    assert str(s.start) == "2024-01-01 12:00:00+00:00"
    assert any(n.startswith("3600 reports of 2024-01-02 12:00 left out") for n in s.notes)


def test_at_chooses_a_stretch(tmp_path):
    path = written(tmp_path, *rows(), *rows("2024-01-03", ships=((OWN, 59.0, 10.5),)))
    s = recorded_scenario(path, SHIP, OWN, "2024-01-03T12:05")
    assert str(s.start) == "2024-01-03 12:05:00+00:00"
    assert (len(s.targets), s.duration_s) == (0, 24 * 60)
    assert len(recorded_scenario(path, SHIP, OWN, "12:05").targets) == 1


def test_own_ship_decides_which_stretches_there_are(tmp_path):
    path = written(tmp_path, *rows(ships=((OWN, 59.0, 10.5),)), *rows("2024-02-01", ships=(
        (NEAR, 59.0, 10.5), (FAR, 59.0, 10.6))))  # fmt: skip
    assert str(recorded_scenario(path, SHIP, OWN).start) == "2024-01-01 12:00:00+00:00"


def test_many_stretches_are_told_in_one_line(tmp_path):
    strays = [f"20{year}-01-01T00:00:00,{NEAR},59,10,0,0" for year in range(10, 20)]
    s = recorded_scenario(written(tmp_path, *rows(), *strays), SHIP, OWN)
    (note,) = [n for n in s.notes if "left out" in n]
    assert note.startswith("10 reports in 10 stretches, the first of 2010-01-01 00:00, left out")


def test_far_ships_are_no_targets(tmp_path):
    ships = ((OWN, 59.0, 179.9), (NEAR, 59.0, -179.9), (FAR, -59.0, 0.0), (4, 59.0, 178.0))
    s = recorded_scenario(written(tmp_path, *rows(ships=ships)), SHIP, OWN)
    assert [t.id for t in s.targets] == [str(NEAR)]


@pytest.mark.parametrize("settings", [recording_settings(None), recording_settings(10.0)])
@pytest.mark.parametrize("at", [None, "12:10"])
def test_a_large_file_gives_the_same_as_a_small_one(tmp_path, monkeypatch, settings, at):
    ships = ((OWN, 59.0, 10.5), (NEAR, 59.0, 10.6), (FAR, 20.0, 10.6), (OWN_SENSORS + 6, 59, 10.4))
    lines = [line for hour in range(12, 16) for line in rows(hour=hour, ships=ships)]
    lines += [f"2024-01-01T12:{m:02d}:30,{NEAR},91,181,102.3,360" for m in range(30)]
    path = written(tmp_path, *lines)
    small = recorded_scenario(path, SHIP, OWN, at, settings)
    monkeypatch.setattr(recording_window, "MAX_SINGLE_PASS", 50)
    large = recorded_scenario(path, SHIP, OWN, at, settings)
    assert [t.id for t in small.targets] == [t.id for t in large.targets] == ["5", str(NEAR)]
    assert (small.start, small.duration_s, small.ship) == (
        large.start,
        large.duration_s,
        large.ship,
    )
    for name in ("start_s", "east_m", "north_m", "course_rad", "speed_m_s"):
        kept = []
        for scenario in (small, large):
            values = np.asarray(getattr(scenario.encounter.targets, name))
            start = np.asarray(scenario.encounter.targets.start_s)
            kept.append(values[(start > -300) & np.isfinite(start)])
        np.testing.assert_allclose(*kept, atol=0.5)


def test_too_many_reports_are_told_in_one_line(tmp_path, monkeypatch):
    path = written(tmp_path, *rows())
    monkeypatch.setattr(recording_window, "MAX_SINGLE_PASS", 20)
    monkeypatch.setattr(recording_window, "MAX_REPORTS", 40)
    with pytest.raises(InputError, match=r"more than 40 reports in that time .* choose --at and"):
        recorded_scenario(path, SHIP, OWN)
    assert len(recorded_scenario(path, SHIP, OWN, settings=recording_settings(5.0)).targets) == 1
    monkeypatch.setattr(recording_window, "MAX_REPORTS", 25)
    with pytest.raises(InputError, match="more than 25 reports of own ship"):
        recorded_scenario(path, SHIP, OWN)
    with pytest.raises(InputError, match="cut it into hours"):
        recording_window.read_recording(path)


@pytest.mark.parametrize("kept", [20, 10_000])
def test_own_ships_of_a_large_file_are_proposed_by_an_hour(tmp_path, monkeypatch, kept):
    monkeypatch.setattr(recording_window, "MAX_SINGLE_PASS", kept)
    path = written(tmp_path, *rows())
    with pytest.raises(InputError, match=f"no own ship in it; .* {OWN} \\(29 min, 11 kn, meets 0"):
        recorded_scenario(path, SHIP)
    with pytest.raises(InputError, match="no usable report of MMSI 5 in it; choose --own"):
        recorded_scenario(path, SHIP, 5)


@pytest.mark.parametrize("mmsi", ["0", "-1", "-5", "1e300", ""])
def test_no_number_of_a_file_is_own_ship(tmp_path, mmsi):
    path = written(
        tmp_path, *rows(), *(f"2024-01-01T12:{m:02d}:00,{mmsi},59,10.5,9,0" for m in range(30))
    )
    with pytest.raises(InputError, match="no own ship in it"):
        recorded_scenario(path, SHIP)
    s = recorded_scenario(path, SHIP, OWN)
    assert [t.id for t in s.targets] == [str(NEAR)]
    assert any("30 rows unreadable" in note for note in s.notes)


@pytest.mark.parametrize("own", ["0", "-1", "1234567890", "²", "٣"])
def test_an_own_ship_that_is_no_mmsi(tmp_path, own):
    with pytest.raises(InputError, match="must be an MMSI or 'recorded'"):
        recorded_scenario(written(tmp_path, *rows()), SHIP, own)


def table(ships, count=30, every_s=60.0):
    """Reports of ships (mmsi, latitude, longitude, kn, course), the first positions kept."""
    parts = [
        ReportTable(
            1e9 + every_s * np.arange(count),
            np.full(count, mmsi),
            *(np.full(count, float(x)) for x in (lat, lon, kn, course, course)),
        )
        for mmsi, lat, lon, kn, course in ships
    ]
    return ReportTable.concat(parts)


@pytest.mark.parametrize("latitude", [0.0, 60.0, -75.0, 85.0])
@pytest.mark.parametrize("longitude", [0.0, 100.0, 180.0])
def test_an_approach_is_the_same_anywhere_on_the_globe(latitude, longitude):
    """North of one another by a minute and a half, and 0.2 NM to the side: end on at 10 kn each."""
    north, side = 9 / 60, 0.2 / 60 / np.cos(np.radians(latitude + 4.5 / 60))
    other = (longitude + side + 180) % 360 - 180
    reports = table([(1, latitude, longitude, 10, 0), (2, latitude + north, other, 10, 180)])
    first = next(snapshots(reports, 1.0))
    range_m, tcpa, dcpa = closest_approaches(first, first.pairs(50_000.0))
    assert range_m == pytest.approx(9 * 1852, rel=0.01)
    assert tcpa == pytest.approx(9 / 20 * 3600, rel=0.01)
    assert dcpa == pytest.approx(0.2 * 1852, rel=0.02)


def test_places_are_metres():
    one, other = ecef(np.array([59.0, 59.0]), np.array([179.99, -179.99]))
    assert np.linalg.norm(one - other) == pytest.approx(1149, rel=0.01)


def test_a_hole_of_years_takes_no_time():
    later = table([(2, 0, 0, 5, 0)])
    holed = ReportTable.concat([table([(1, 0, 0, 5, 0)]), later.take(np.arange(3))])
    holed.time_s[30:] += 2e9
    times = [instant.time_s for instant in snapshots(holed, 60.0)]
    assert len(times) < 60
    assert times == sorted(times)
    assert [c.name for c in own_ship_candidates(holed, {1: StaticData("A")})] == ["A"]


def test_candidates_of_a_continent_meet_across_the_date_line():
    ships = [(1, 60.0, 179.99, 10, 0), (2, 60.0, -179.99, 10, 0), (3, -60.0, -179.99, 10, 0),
             (4, 60.0, 0.0, 10, 0)]  # fmt: skip
    found = {c.mmsi: c.n_meetings for c in own_ship_candidates(table(ships), {})}
    assert found == {1: 1, 2: 1, 3: 0, 4: 0}
