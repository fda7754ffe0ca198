"""Suites hold the encounters that they say."""

import dataclasses
import gzip

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.evaluation.cases import HEAD_ON, SHIP, SPEED, encounter

from glasshelm.ais import reading
from glasshelm.ais.table import ReportTable
from glasshelm.core.errors import InputError
from glasshelm.encounters import recording_window
from glasshelm.encounters.types import motion_at
from glasshelm.evaluation.suites.disturbed_suite import disturbed_suites
from glasshelm.evaluation.suites.random_suite import case_duration_s
from glasshelm.evaluation.suites.recorded_suite import Windows, windows
from glasshelm.evaluation.suites.suite_registry import build_suites
from glasshelm.ship.nomoto import KNOT_M_S
from glasshelm.simulation.disturbances import SHIP_SHARE


def test_a_voyage_lasts_until_its_conflicts_are_past():
    assert float(case_duration_s(encounter(HEAD_ON), SHIP)) == 2400
    # Overtaken from 3.5 km astern by a ship that is 1.3 m/s faster: the meeting is at 2700 s.
    late = encounter((200.0, -1.3 * 2700, 0.0, SPEED + 1.3))
    assert float(case_duration_s(late, SHIP)) == 3120
    nobody_near = encounter((30_000.0, -1.3 * 2700, 0.0, SPEED + 1.3))
    assert float(case_duration_s(nobody_near, SHIP)) == 2400


@pytest.mark.slow
def test_random_encounters_do_not_depend_on_how_many_there_are():
    (few,), (more,) = (build_suites(["random"], SHIP, count) for count in (3, 5))
    jax.tree.map(lambda a, b: np.testing.assert_array_equal(a, b[:3]), few.cases, more.cases)


def test_imazu_at_both_speeds_meets_after_1800_s():
    slow, fast = build_suites(["imazu"], SHIP)
    assert (slow.name, fast.name, slow.size) == ("imazu-10kn", "imazu-12kn", 24)
    for suite, knots in ((slow, 10), (fast, 12)):
        own = suite.cases.encounter.own
        assert own.speed_m_s == pytest.approx(knots * KNOT_M_S, rel=1e-5)
        at = motion_at(
            jax.tree.map(jnp.asarray, suite.cases.encounter.targets), jnp.asarray(1800.0)
        )
        met = np.hypot(at.east_m, at.north_m - knots * KNOT_M_S * 1800)
        assert np.max(met[suite.cases.encounter.present]) < 5


@pytest.mark.slow
def test_each_disturbance_is_of_the_same_encounters():
    parts = {s.name.removeprefix("disturbed-"): s.cases for s in disturbed_suites(SHIP, 40)}
    (plain,) = build_suites(["random"], SHIP, 40)
    present = plain.cases.encounter.present
    for case in parts.values():
        start = np.asarray(case.encounter.targets.east_m)[..., 0]
        np.testing.assert_array_equal(
            start[present], plain.cases.encounter.targets.east_m[..., 0][present]
        )
    stale = np.asarray(parts["stale"].disturbance.report_interval_s)[present]
    assert 2 <= stale.min() < 10
    assert 90 < stale.max() <= 180
    share = np.asarray(parts["ship"].ship.gain_1_s) / float(SHIP.gain_1_s)
    assert np.abs(share - 1).max() <= SHIP_SHARE + 1e-6
    assert np.abs(share - 1).max() > 0.15
    speed = parts["ship"].encounter.own.speed_m_s
    np.testing.assert_array_equal(speed, parts["ship"].ship.speed_m_s)


def test_an_altering_target_sails_on_from_where_she_was():
    (altering,) = [s for s in disturbed_suites(SHIP, 8) if s.name == "disturbed-altering"]
    track = jax.tree.map(jnp.asarray, altering.cases.encounter.targets)
    times = np.asarray(track.start_s)[..., 1]
    for time in times[altering.cases.encounter.present][:5]:
        before, after = (motion_at(track, jnp.asarray(time + d, jnp.float32)) for d in (-0.5, 0.5))
        step = np.hypot(after.east_m - before.east_m, after.north_m - before.north_m)
        assert np.max(np.abs(step - np.asarray(before.speed_m_s))) < 1.0


def reports(tracks):
    """Reports every 30 s for 40 minutes of ships (mmsi, degrees north at t = 0, course, kn)."""
    rows = []
    for mmsi, north, course, knots in tracks:
        for time in np.arange(0.0, 2401.0, 30.0):
            run = knots * time / 3600 / 60 * np.cos(np.radians(course))
            rows.append((time, mmsi, 40.0 + north + run, -74.0, knots, course, course))
    t, m, *rest = np.array(rows).T
    return ReportTable(t, m.astype(np.int64), *rest)


def test_windows_begin_where_a_ship_closes_another():
    """Two ships end on, 10 NM apart at 10 kn each: CPA after 30 min, in 15 min after 15."""
    found = windows(reports([(111000001, 0.0, 0.0, 10.0), (222000002, 10 / 60, 180.0, 10.0)]))
    assert [(w.mmsi, w.closing) for w in found] == [
        (111000001, (222000002,)), (222000002, (111000001,)),
    ]  # fmt: skip
    assert found[0].begins_s == pytest.approx(900, abs=60)


def test_no_window_for_ships_that_lie_still_or_are_alongside():
    still = reports([(111000001, 0.0, 0.0, 10.0), (222000002, 6 / 60, 180.0, 1.0)])
    assert windows(still) == []
    alongside = reports([(111000001, 0.0, 0.0, 10.0), (222000002, 0.3 / 60, 0.0, 8.0)])
    assert windows(alongside) == []
    wide = dataclasses.replace(Windows(), slowest_m_s=0.1)
    assert windows(still, wide) != []


def placed(latitude, longitude, first=111000001):
    """Two ships end on across a place, 10 NM apart at 10 kn each, reports as above."""
    east = 5 / 60 / np.cos(np.radians(latitude))
    run = 10 / 3600 / 60 / np.cos(np.radians(latitude))
    rows = [
        (1.6e9 + t, first + i, latitude, longitude - side * (east - run * t), 10.0, course, course)
        for i, (side, course) in enumerate(((1, 90.0), (-1, 270.0)))
        for t in np.arange(0.0, 2401.0, 30.0)
    ]
    t, mmsi, lat, lon, *rest = np.array(rows).T
    return ReportTable(t, mmsi.astype(np.int64), lat, (lon + 180) % 360 - 180, *rest)


@pytest.mark.parametrize("latitude", [0.0, 58.3, -60.0, 84.0])
@pytest.mark.parametrize("longitude", [-152.0, 0.0, 179.99, -180.0])
def test_windows_are_the_same_alone_and_in_the_file_of_a_continent(latitude, longitude):
    alone = placed(latitude, longitude)
    others = [
        placed(lat, lon, 200000000 + 10 * i)
        for i, (lat, lon) in enumerate([(25.0, -80.0), (40.0, -74.0), (-33.0, 151.0), (70.0, 20.0)])
    ]
    # Others are heard before and after: the minutes are those of the clock, not of the file.
    early = placed(10.0, 10.0, 300000000)
    early = dataclasses.replace(early, time_s=early.time_s - 997.0)
    found = windows(alone)
    assert [w.mmsi for w in found] == [111000001, 111000002]
    assert [w.closing for w in found] == [(111000002,), (111000001,)]
    assert found[0].begins_s == pytest.approx(1.6e9 + 900, abs=60)
    national = windows(ReportTable.concat([early, *others, alone]))
    assert [w for w in national if w.mmsi < 200000000] == found
    assert len(national) == 2 * 6


def test_a_row_of_another_year_makes_no_work_and_no_other_window():
    alone = placed(58.3, -152.0)
    stray = alone.take(np.array([0]))
    stray = dataclasses.replace(stray, time_s=stray.time_s - 8e8)
    assert windows(ReportTable.concat([stray, alone])) == windows(alone)


def as_csv(path, reports):
    columns = np.stack([getattr(reports, f.name) for f in dataclasses.fields(reports)], 1)
    np.savetxt(path, columns, "%.6f", ",", header="t,mmsi,lat,lon,sog,cog,heading", comments="")
    return path


def test_a_recording_is_read_once(tmp_path, monkeypatch):
    path = as_csv(tmp_path / "strait.csv", placed(58.3, 179.99, 211000001))
    opened = []
    real = reading.iter_recording
    monkeypatch.setattr(
        recording_window, "iter_recording", lambda *given: opened.append(given) or real(*given)
    )
    (suite,) = build_suites([f"recorded:{path}"], SHIP)
    assert suite.size == 2
    assert len(opened) == 1
    met = [[info.id for info in infos] for infos in suite.targets]
    assert met == [["211000002"], ["211000001"]]


GOOD = (
    '{"ownShip": {"initial": {"position": {"lat": 0, "lon": 0}, "sog": 9, "cog": 0}},'
    ' "targetShips": []}'
)


def test_a_folder_of_situations_says_which_files_are_wrong(tmp_path):
    (tmp_path / "a.json").write_text(GOOD)
    (tmp_path / "c.JSON.gz").write_bytes(gzip.compress(GOOD.encode()))
    (tmp_path / "notes.txt").write_text("no situation")
    (suite,) = build_suites([f"situations:{tmp_path}"], SHIP)
    assert suite.size == 2
    (tmp_path / "b.json").write_text('{"ownShip": {}, "encounters": []}')
    (tmp_path / "d.json").write_text("{}")
    with pytest.raises(InputError, match=r"b.json: an input of the generator .*2 of 4.*b.json, d"):
        build_suites([f"situations:{tmp_path}"], SHIP)


@pytest.mark.parametrize(
    ("names", "count", "says"),
    [
        (["nowhere"], None, "unknown suite 'nowhere': choose one of random"),
        (["situations"], None, "unknown suite 'situations'"),
        (["random"], 0, "0 encounters"),
        ([], None, "no suite"),
        (["situations:/nowhere"], None, "nowhere"),
    ],
)
def test_bad_suites_are_told(names, count, says):
    with pytest.raises(InputError, match=says):
        build_suites(names, SHIP, count)
