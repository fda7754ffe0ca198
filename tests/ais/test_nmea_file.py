import gzip
import math
from datetime import UTC, datetime

import numpy as np
import pytest
from tests.ais.nmea_lines import POSITION, STATIC, TIME, ais, sentence, tagged

from glasshelm.ais.nmea_file import iter_nmea
from glasshelm.ais.reading import all_reports, read_recording_file
from glasshelm.ais.table import OWN_SENSORS
from glasshelm.core.errors import InputError


def nmea_file(tmp_path, *lines, name="traffic.nmea"):
    path = tmp_path / name
    text = b"\r\n".join(lines) + b"\r\n"
    path.write_bytes(gzip.compress(text) if name.endswith(".gz") else text)
    return path


def test_positions_and_identities(tmp_path):
    lines = [*ais(POSITION), *ais(STATIC), *ais(POSITION, TIME * 1000 + 10_500)]
    recording = read_recording_file(nmea_file(tmp_path, *lines))
    r = recording.reports
    assert r.mmsi.tolist() == [211000001] * 2
    assert r.time_s.tolist() == [TIME, TIME + 10.5]
    np.testing.assert_allclose(
        [r.latitude_deg[0], r.longitude_deg[0], r.sog_kn[0], r.cog_deg[0], r.heading_deg[0]],
        [59.5, 24.5, 12.3, 45.6, 44],
    )
    ship = recording.ships[211000001]
    assert (ship.name, ship.length_m, ship.beam_m, ship.ship_type) == (
        "ALPHA BRAVO",
        150.0,
        22.0,
        "70",
    )
    assert recording.notes == ()


def test_every_kind_of_position_report_is_read(tmp_path):
    class_b = POSITION | {"type": 18, "mmsi": 211000002}
    long_range = {"type": 27, "mmsi": 211000003, "lat": 59.5, "lon": 24.5, "speed": 10}
    lines = [*ais(POSITION), *ais(class_b), *ais(long_range | {"course": 45})]
    assert read_recording_file(nmea_file(tmp_path, *lines)).reports.mmsi.tolist() == [
        211000001, 211000002, 211000003,
    ]  # fmt: skip


def test_own_ships_sensors_are_her_own_track(tmp_path):
    rmc = "GPRMC,190001.00,A,5930.00,N,02430.00,E,7.0,180.0,150814,,,A"
    recording = read_recording_file(nmea_file(tmp_path, sentence(rmc), *ais(POSITION, None)))
    r = recording.reports
    assert r.mmsi.tolist() == [OWN_SENSORS, 211000001]
    assert r.time_s.tolist() == [TIME + 1, TIME + 1]
    assert (r.sog_kn[0], r.cog_deg[0]) == (pytest.approx(7.0), pytest.approx(180.0))
    assert math.isnan(r.heading_deg[0])


def test_what_cannot_be_used_is_counted_by_its_reason(tmp_path):
    wrong = ais(POSITION)[0][:-1] + b"G"
    lines = [
        wrong,
        *ais(POSITION),
        *ais(POSITION, 5),
        b"hello",
        b"world",
        *ais({"type": 4, "mmsi": 3}),
    ]
    assert read_recording_file(nmea_file(tmp_path, *lines)).notes == (
        "2 sentences not of the form of a sentence or message",
        "1 sentence with a wrong checksum",
        "1 sentence with a time that is none (before 1990 or after 2100)",
    )


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([b"hello", b"world"], "no NMEA 0183 sentence"),
        (ais(POSITION, None) * 3 + [b"hello"], "of 4 sentences, 3 are without a time"),
        ([ais(POSITION)[0][:-1] + b"G"] * 2, "2 are with a wrong checksum"),
        (ais(STATIC), "none of its 2 sentences tells a position"),
        (ais(POSITION, 2024), "with a time that is none"),
    ],
)
def test_a_file_without_a_position_says_what_most_of_it_is(tmp_path, lines, message):
    with pytest.raises(InputError, match=message):
        list(iter_nmea(nmea_file(tmp_path, *lines), all_reports, []))


def test_batches_are_bounded(monkeypatch, tmp_path):
    monkeypatch.setattr("glasshelm.ais.nmea_file.BATCH", 10)
    lines = [line for k in range(25) for line in ais(POSITION, TIME + k)]
    batches = list(iter_nmea(nmea_file(tmp_path, *lines), all_reports, []))
    assert [len(batch.reports) for batch in batches] == [10, 10, 5]


def test_a_tag_with_a_wrong_checksum_is_not_believed(tmp_path):
    good = tagged(ais(POSITION, None)[0])
    bad = good.replace(b"c:1", b"c:2")
    assert len(read_recording_file(nmea_file(tmp_path, good, bad)).reports) == 1


def at(k, message=POSITION, **more):
    """A message at ``k`` seconds; of a station, if one is named."""
    return [tagged(line, TIME + k, **more) for line in ais(message, None)]


@pytest.mark.parametrize("off", [3600, -3600, -1024 * 7 * 86_400])
@pytest.mark.parametrize("first", ["own ship", "the others"])
def test_lines_with_a_time_are_not_refused_for_a_wrong_calendar_of_own_ship(tmp_path, off, first):
    """One station is one witness, and so is own ship: which of them is first decides nothing."""
    when = datetime.fromtimestamp(TIME + off, UTC)
    rmc = f"GPRMC,{when:%H%M%S},A,5930.00,N,02430.00,E,7.0,180.0,{when:%d%m%y},,,A"
    lines = []
    for k in range(0, 60, 10):
        ships = [line for n in range(3) for line in at(
            k, POSITION | {"mmsi": 211000001 + n}, source_station="rx1"
        )]  # fmt: skip
        lines += [sentence(rmc), *ships] if first == "own ship" else [*ships, sentence(rmc)]
    recording = read_recording_file(nmea_file(tmp_path, *lines))
    assert np.sum(recording.reports.mmsi != OWN_SENSORS) == 18
    own = recording.reports.take(recording.reports.mmsi == OWN_SENSORS)
    assert np.all(np.abs(own.time_s[1:] - TIME) < 60)
    assert recording.notes == ()


def test_reports_that_came_late_or_ship_by_ship_are_all_read(tmp_path):
    late = [line for k in range(0, 600, 60) for line in (
        *at(k + 1200), *at(k, POSITION | {"mmsi": 211000002}, source_station="satellite")
    )]  # fmt: skip
    by_ship = [line for n in range(3) for k in range(0, 1200, 60)
               for line in at(k, POSITION | {"mmsi": 211000001 + n})]  # fmt: skip
    for lines in (late, by_ship):
        recording = read_recording_file(nmea_file(tmp_path, *lines))
        assert len(recording.reports) == len(lines)
        assert recording.notes == ()


def test_a_receiver_that_has_not_found_its_date_tells_none(tmp_path):
    rmc = "GPRMC,000010.00,A,5930.00,N,02430.00,E,7.0,180.0,060180,,,A"
    right = "GPRMC,190001.00,A,5930.00,N,02430.00,E,7.0,180.0,150814,,,A"
    recording = read_recording_file(
        nmea_file(tmp_path, *[sentence(rmc)] * 3, *[sentence(right)] * 3)
    )
    assert recording.reports.time_s.min() == TIME + 1
    assert "without a time" in recording.notes[0]
