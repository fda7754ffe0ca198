"""One file is the same traffic, played as a live feed or read as a recording."""

import asyncio
import math

import pytest
from tests.ais.nmea_lines import POSITION, STATIC, TIME, ais, cut, sentence, tagged

from glasshelm.ais.table import OWN_SENSORS
from glasshelm.encounters.projection import LocalProjection
from glasshelm.encounters.recording_window import read_recording
from glasshelm.feeds.nmea_transport import FileFeed
from glasshelm.live.traffic_picture import TrafficPicture
from glasshelm.ship.nomoto import KNOT_M_S, ship_named

OWN = 211000001
LASTS_S = 300


def moved(message, k, **more):
    """The message after ``k`` seconds on its way."""
    north = message["speed"] * k / 3600 / 60 * math.cos(math.radians(message["course"]))
    east = message["speed"] * k / 3600 / 60 * math.sin(math.radians(message["course"]))
    latitude = message["lat"] + north
    return message | {
        "lat": latitude, "lon": message["lon"] + east / math.cos(math.radians(latitude)), **more,
    }  # fmt: skip


def ship(number, lat, lon, course, speed=10.0, **more):
    return POSITION | {
        "mmsi": number, "lat": lat, "lon": lon, "course": course, "speed": speed,
        "heading": round(course), **more,
    }  # fmt: skip


SHIPS = [
    ship(211000002, 59.52, 24.6, 250.0),
    ship(211000003, 59.48, 24.4, 70.0, type=18),
    ship(211000004, 59.55, 24.5, 180.0, 8.0, type=27),
    ship(970012345, 59.51, 24.52, 90.0, 1.0),  # a sender of distress is met as a ship is
]
NO_SHIPS = [
    ship(111257500, 59.5, 24.55, 90.0, 55.0),
    ship(992571234, 59.5, 24.56, 0.0, 0.0),
    ship(2570001, 59.5, 24.57, 0.0, 0.0),
]


def traffic():
    """Lines in order of time: sound ones, and every kind of bad one among them."""
    own = ship(OWN, 59.5, 24.5, 90.0, 12.0)
    yield from ais(STATIC)[::-1]  # the parts in the wrong order
    yield from ais(STATIC | {"mmsi": 211000002, "shipname": "SECOND", "to_bow": 30})
    for k in range(0, LASTS_S, 10):
        t = TIME + k
        yield from ais(moved(own, k), t)
        for one in SHIPS:
            yield from ais(moved(one, k), t)
        for one in NO_SHIPS:
            yield from ais(moved(one, k), t)
        wrong = ais(ship(211000009, 59.49, 24.49, 0.0), t)[0]
        yield wrong[:-1] + (b"0" if wrong[-1:] != b"0" else b"1")
        yield tagged(cut(moved(SHIPS[0], k), 100), t)
        yield b"\\c:%d*00\\%s" % (t, ais(moved(SHIPS[1], k, lat=58.0), None)[0])
        if k == 100:
            yield from ais(moved(SHIPS[0], k, lat=60.5), t + 1)  # one wild position
            yield from ais(moved(SHIPS[1], k), t * 10**6 + 10**11)  # 28 h ahead, in microseconds
            yield from ais(moved(SHIPS[2], k), 86_400)  # 1970
        yield b"%s,%d" % (ais(ship(211000005, 59.53, 24.45, 0.0, 0.0), None)[0], t)
        yield b"hello, world"


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("one") / "traffic.nmea"
    path.write_bytes(b"\xef\xbb\xbf" + b"\r\n".join(traffic()) + b"\r\n")
    return path


def played(path, own):
    """Own ship, and the ships around her, as the live picture has them at the end of a file."""

    async def play():
        feed, picture = FileFeed(path, own, pace=math.inf), TrafficPicture()
        async for report in feed.reports():
            picture.update(report)
        return picture

    picture = asyncio.run(play())
    scenario = picture.scenario(picture.latest_time, ship_named("paper"))
    tracks = scenario.encounter.targets
    ships = {}
    for k, info in enumerate(scenario.targets):
        if info.id:
            place = float(tracks.east_m[k, 0]), float(tracks.north_m[k, 0])
            ships[info.id] = (info.name, info.length_m, place, float(tracks.speed_m_s[k, 0]))
    return scenario, ships


def test_a_file_played_and_read_is_the_same_traffic(file):
    scenario, live = played(file, str(OWN))
    recording = read_recording(file)
    numbers = set(recording.reports.mmsi.tolist())
    assert {int(n) for n in live} | {OWN} == numbers
    assert OWN_SENSORS not in numbers
    plane = LocalProjection(*scenario.origin)
    for number, (name, length, place, speed) in live.items():
        rows = recording.reports.take(recording.reports.mmsi == int(number))
        rows = rows.take(rows.time_s < TIME + 3600)  # a scenario leaves the row of another day out
        last = int(rows.time_s.argmax())
        east, north = plane.to_plane(rows.latitude_deg[[last]], rows.longitude_deg[[last]])
        assert math.hypot(east[0] - place[0], north[0] - place[1]) < 50.0, number
        assert rows.sog_kn[last] * KNOT_M_S == pytest.approx(speed, abs=0.1), number
        known = recording.ships.get(int(number))
        told = (known.name, known.length_m) if known else (None, None)
        assert (name if told[0] else None, length) == told, number
    assert live["211000002"][:2] == ("SECOND", 80.0)


def test_own_ships_sensors_are_read_both_ways(tmp_path):
    path = tmp_path / "own.nmea"
    rows = []
    for k in range(0, 120, 10):
        place = f"59{30.0 + 7.0 * k / 3600:08.5f},N,02430.00,E"
        rmc = f"GPRMC,19{k // 60:02d}{k % 60:02d}.00,A,{place},7.0,0.0,150814,,,A"
        rows += [sentence(rmc), *ais(moved(SHIPS[0], k), None)]
    path.write_bytes(b"\r\n".join(rows))
    scenario, live = played(path, None)
    recording = read_recording(path)
    assert set(recording.reports.mmsi.tolist()) == {OWN_SENSORS, 211000002}
    assert set(live) == {"211000002"}
    assert float(scenario.ship.speed_m_s) == pytest.approx(7 * KNOT_M_S)
    mine = recording.reports.take(recording.reports.mmsi == OWN_SENSORS)
    assert mine.sog_kn.tolist() == pytest.approx([7.0] * len(mine))
