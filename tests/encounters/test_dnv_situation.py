import gzip
import json
import math

import jax.numpy as jnp
import numpy as np
import pytest
from pyproj import Geod

from glasshelm.core.errors import InputError
from glasshelm.encounters.dnv_situation import read_situation
from glasshelm.encounters.scenario_factory import scenario_from
from glasshelm.encounters.types import motion_at
from glasshelm.ship.nomoto import KNOT_M_S, SHIPS

SHIP = SHIPS["large_ship"]
GEOD = Geod(ellps="WGS84")
HOME = (59.0, 10.5)


def away(bearing_deg, distance_m, start=HOME):
    longitude, latitude, _ = GEOD.fwd(start[1], start[0], bearing_deg, distance_m)
    return latitude, longitude


def newer(points, sog, **static):
    """A vessel of the newer layout."""
    waypoints = [
        {"position": {"lat": lat, "lon": lon}, "leg": {"sog": s}}
        for (lat, lon), s in zip(points, sog, strict=True)
    ]
    return {"initial": {"heading": 0.0}, "waypoints": waypoints, "static": {"id": 1, **static}}


def older(point, sog, cog, **static):
    """A vessel of the older layout: only her initial state."""
    initial = {
        "position": {"latitude": point[0], "longitude": point[1]},
        "sog": sog,
        "cog": cog,
        "heading": cog,
    }
    return {"initial": initial, "static": static}


def own_ship():
    size = {"dimensions": {"length": 122.0, "width": 20.0}}
    return newer([HOME, away(0, 9000)], [10.0, 10.0], name="OWN", **size)


def written(tmp_path, own, *targets, **more):
    path = tmp_path / "situation.json"
    path.write_text(json.dumps({"ownShip": own, "targetShips": list(targets), **more}))
    return path


def at(scenario, time_s):
    return motion_at(scenario.encounter.targets, jnp.asarray(float(time_s)))


def test_newer_layout(tmp_path):
    target = newer([away(45, 5000), away(0, 5000)], [12.0, 12.0], name="ALPHA")
    s = read_situation(written(tmp_path, own_ship(), target, title="CR"), SHIP)
    assert (s.title, s.own_name, s.targets[0].name) == ("CR", "OWN", "ALPHA")
    assert (s.ship.loa_m, s.ship.beam_m) == (122.0, 20.0)
    assert s.ship.speed_m_s == pytest.approx(10 * KNOT_M_S)
    assert s.ship.gain_1_s == SHIP.gain_1_s
    np.testing.assert_allclose(
        [s.encounter.route.x[0], s.encounter.route.y[0]], [0, 9000], atol=0.1
    )
    np.testing.assert_allclose(
        [at(s, 0).east_m[0], at(s, 0).north_m[0]], [5000 * 0.5**0.5] * 2, atol=0.1
    )
    assert s.origin == HOME
    assert s.duration_s == pytest.approx(9000 / (10 * KNOT_M_S), rel=1e-4)


@pytest.mark.parametrize("names", [("latitude", "longitude"), ("lat", "lon")])
def test_older_layout_means_the_same(tmp_path, names):
    place = away(30, 6000)
    target = older(place, 8.0, 200.0, length=50.0, name="BRAVO", shipType="Cargo")
    target["initial"]["position"] = dict(zip(names, place, strict=True))
    own = older(HOME, 10.0, 15.0, length=99.0, width=9.0)
    s = read_situation(written(tmp_path, own, target), SHIP)
    course = math.radians(200)
    now, later = at(s, 0), at(s, 900)
    run = 900 * 8 * KNOT_M_S
    assert float(later.east_m[0] - now.east_m[0]) == pytest.approx(run * math.sin(course), abs=0.1)
    assert float(later.north_m[0] - now.north_m[0]) == pytest.approx(
        run * math.cos(course), abs=0.1
    )
    assert s.targets[0].length_m == 50.0
    assert float(s.encounter.own.heading_rad) == pytest.approx(math.radians(15))
    assert s.ship.loa_m == 99.0
    # Without waypoints she sails straight on.
    bearing = math.atan2(float(s.encounter.route.x[0]), float(s.encounter.route.y[0]))
    assert bearing == pytest.approx(math.radians(15), abs=1e-4)
    assert any("straight on" in note for note in s.notes)


def test_targets_follow_their_waypoints_at_leg_speeds(tmp_path):
    # 2 km north at 10 kn, then 1 km east at 5 kn, then on to the east for ever.
    start = away(90, 3000)
    turn = away(0, 2000, start)
    end = away(90, 1000, turn)
    target = newer([start, turn, end], [10.0, 5.0, 20.0])
    s = read_situation(written(tmp_path, own_ship(), target), SHIP)
    first = 2000 / (10 * KNOT_M_S)
    second = first + 1000 / (5 * KNOT_M_S)
    for time_s, east, north in [
        (0.5 * first, 3000, 1000),
        (first + 1, 3000 + 5 * KNOT_M_S, 2000),
        (second, 4000, 2000),
        (second + 600, 4000 + 600 * 5 * KNOT_M_S, 2000),
    ]:
        now = at(s, time_s)
        np.testing.assert_allclose([now.east_m[0], now.north_m[0]], [east, north], atol=4.0)
        assert bool(now.present[0])


def test_initial_position_off_the_route_leads_to_its_first_waypoint(tmp_path):
    target = older(away(90, 3000), 10.0, 0.0)
    target["waypoints"] = [{"position": dict(zip(("lat", "lon"), away(90, 5000), strict=True))}]
    s = read_situation(written(tmp_path, own_ship(), target), SHIP)
    assert float(at(s, 0).course_rad[0]) == pytest.approx(math.pi / 2, abs=1e-2)


def test_a_ship_at_anchor_stays(tmp_path):
    s = read_situation(written(tmp_path, own_ship(), older(away(90, 3000), 0.0, 10.0)), SHIP)
    assert float(at(s, 1000).east_m[0]) == float(at(s, 0).east_m[0])


def test_no_targets_is_an_empty_sea(tmp_path):
    s = read_situation(written(tmp_path, own_ship()), SHIP)
    assert s.encounter.present.shape == (0,)
    assert "no target ships" in s.notes[0]
    for targets in ({}, {"targetShips": None}, {"targetShip": None}):
        path = tmp_path / "silent.json"
        path.write_text(json.dumps({"ownShip": own_ship(), **targets}))
        with pytest.raises(InputError, match="no targetShips: a situation without any says so"):
            read_situation(path, SHIP)


def test_keys_that_are_not_used_are_told(tmp_path):
    s = read_situation(written(tmp_path, own_ship(), title="T", environment={}, wind=3), SHIP)
    assert "not used in the file: environment, wind" in s.notes


def test_forty_targets(tmp_path):
    targets = [older(away(9 * i, 4000), 10.0, 9.0 * i) for i in range(40)]
    s = read_situation(written(tmp_path, own_ship(), *targets), SHIP)
    assert at(s, 0).present.shape == (40,)
    assert bool(at(s, 0).present.all())


def change(vessel, *path, to=None):
    """The vessel with one field set, or removed."""
    inner = vessel
    for key in path[:-1]:
        inner = inner[key]
    if to is None:
        del inner[path[-1]]
    else:
        inner[path[-1]] = to
    return vessel


FAR = away(45, 5000)


@pytest.mark.parametrize(
    ("target", "message"),
    [
        (older(away(0, 100), 5.0, 0.0, name="C"), r"targetShips\[0\] \(C\) starts 100 m from own"),
        (change(older(FAR, 5.0, 0.0), "initial", "position"), r"targetShips\[0\].initial.position"),
        (
            change(older(FAR, 5.0, 0.0), "initial", "sog"),
            r"targetShips\[0\].initial.sog is missing",
        ),
        (
            change(
                older(FAR, 5.0, 0.0),
                "initial",
                to={"position": {"lat": 59.0, "lon": 10.6}, "sog": 5},
            ),
            r"targetShips\[0\].initial.cog is missing",
        ),
        (
            change(older(FAR, 5.0, 0.0), "initial", "position", "latitude"),
            r"lat is missing - at `\$.targetShips\[0\].initial.position`",
        ),
        (
            change(older(FAR, 5.0, 0.0), "initial", "position", "latitude", to=91.0),
            r"`float` <= 90.0 - at `\$.targetShips\[0\].initial.position.latitude`",
        ),
        (
            change(older(FAR, 5.0, 0.0), "initial", "cog", to=409.5),
            r"`float` <= 360.0 - at .*\.cog`",
        ),
        (change(older(FAR, 5.0, 0.0), "initial", "sog", to=-1.0), r"`float` >= 0.0 - at .*\.sog`"),
        (change(older(FAR, 5.0, 0.0), "initial", "sog", to="fast"), r"sog`"),
        (
            change(newer([FAR, HOME], [5.0, 5.0]), "waypoints", 1, "position", "lon", to=400.0),
            r"`float` <= 180.0 - at `\$.targetShips\[0\].waypoints\[1\].position.lon`",
        ),
    ],
)
def test_bad_targets_are_named_with_file_and_field(tmp_path, target, message):
    with pytest.raises(InputError, match=message) as error:
        read_situation(written(tmp_path, own_ship(), target), SHIP)
    assert "situation.json" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{}", "ownShip"),
        ('{"ownShip": {}, "targetShips": []}', "ownShip.initial.position is missing"),
        ('{"ownShip": {"initial": {"position": {"lat": NaN', "not JSON, or cut off"),
        ("", "not JSON, or cut off"),
        ("{" * 9, "not JSON, or cut off"),
        ('{"ownShip": ' + "[" * 100_000, "nested too deep"),
        ('{"ownShip": {}, "encounters": []}', r"input of the generator \(encounters\), not a sit"),
        ('{"time_s": 0, "own": {}, "targets": []}\n{"time_s": 5}', "a log of frames"),
        ('{"type": "FeatureCollection", "features": []}', "GeoJSON"),
        ('{"name": "x", "version": "2", "self": "y"}\n{"updates": []}', "Signal K deltas"),
        ('{"a": 1, "b": 2}', "no ownShip in it, but a, b"),
        ("[1, 2]", "not a DNV traffic situation"),
        (json.dumps({"ownShip": older(HOME, 0.0, 0.0), "targetShips": []}), "stands still"),
        (
            json.dumps({"ownShip": own_ship(), "targetShips": [], "startTime": "noon"}),
            "startTime 'noon'",
        ),
    ],
)
def test_bad_files(tmp_path, text, message):
    path = tmp_path / "bad.json"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as error:
        read_situation(path, SHIP)
    assert "bad.json" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
@pytest.mark.parametrize("pack", [bytes, gzip.compress])
def test_any_packing_and_encoding(tmp_path, encoding, pack):
    path = written(tmp_path, own_ship(), title="Ø")
    path.write_bytes(pack(path.read_text().encode(encoding)))
    assert read_situation(path, SHIP).title == "Ø"
    assert scenario_from(str(path), SHIP).title == "Ø"


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        read_situation(tmp_path / "none.json", SHIP)


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_one_long_line_is_a_document(tmp_path, encoding):
    ship = {"initial": {"position": {"lat": 58.0, "lon": 10.0}, "sog": 10.0, "cog": 90.0}}
    place = {"position": {"lat": 58.1, "lon": 10.0}, "sog": 10.0, "cog": 180.0}
    other = {"initial": place}
    document = {"ownShip": ship, "targetShips": [other], "title": "Ø", "description": "x" * 100_000}
    path = tmp_path / "situation.json"
    path.write_bytes(json.dumps(document, ensure_ascii=False).encode(encoding))
    assert scenario_from(str(path), SHIPS["paper"]).title.startswith("Ø")


@pytest.mark.parametrize("year", ["0001", "1969", "2101", "9999"])
def test_a_start_that_is_none_is_told(tmp_path, year):
    ship = {"initial": {"position": {"lat": 58.0, "lon": 10.0}, "sog": 10.0, "cog": 90.0}}
    document = {"ownShip": ship, "targetShips": [], "startTime": f"{year}-12-31T23:59:59Z"}
    path = tmp_path / "situation.json"
    path.write_text(json.dumps(document))
    with pytest.raises(InputError, match=r"startTime .* must be between 1970 and 2100"):
        read_situation(path, SHIPS["paper"])
