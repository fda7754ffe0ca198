import gzip

import numpy as np
import pytest

from glasshelm.ais.csv_file import read_csv
from glasshelm.ais.table import OWN_SENSORS
from glasshelm.errors import InputError


def csv_file(tmp_path, *lines, name="traffic.csv"):
    path = tmp_path / name
    text = "\n".join(lines) + "\n"
    path.write_bytes(gzip.compress(text.encode()) if name.endswith(".gz") else text.encode())
    return path


@pytest.mark.parametrize("name", ["traffic.csv", "traffic.csv.gz"])
def test_full_dialect(tmp_path, name):
    path = csv_file(
        tmp_path,
        "t,mmsi,lat,lon,sog,cog,heading,name,type,nav_status,length_m,beam_m,draught_m",
        "2020-06-30T00:00:00,338531000,40.64,-74.05,10.4,100.7,96,GENESIS,31,0,30,10,5.0",
        "2020-06-30T00:01:00,338531000,40.64,-74.04,,,,,,,,,",
        name=name,
    )
    recording = read_csv(path)
    r = recording.reports
    assert r.mmsi.tolist() == [338531000] * 2
    assert r.time_s[1] - r.time_s[0] == 60
    assert r.time_s[0] == 1593475200
    assert (r.sog_kn[0], r.cog_deg[0], r.heading_deg[0]) == (10.4, 100.7, 96)
    assert np.isnan(r.sog_kn[1])
    ship = recording.ships[338531000]
    assert (ship.name, ship.length_m, ship.beam_m, ship.kind) == ("GENESIS", 30.0, 10.0, "31")


def test_position_only_dialect(tmp_path):
    recording = read_csv(
        csv_file(tmp_path, "t,mmsi,lat,lon", "2020-06-30 17:29:27,338926303,37.2,-76.4")
    )
    assert np.isnan(recording.reports.sog_kn[0])
    assert recording.reports.time_s[0] == 1593538167
    assert recording.ships[338926303].name is None


def test_own_sensor_dialect(tmp_path):
    recording = read_csv(
        csv_file(
            tmp_path,
            "t,kind,mmsi,lat,lon,sog_kn,cog_deg,heading_deg",
            "2014-08-15T19:00:00.363Z,ais,230035780,59.7,24.7,6.2,199.0,",
            "2014-08-15T19:00:00.540Z,own,,59.7,24.7,,,",
        )
    )
    assert recording.reports.mmsi.tolist() == [230035780, OWN_SENSORS]
    assert recording.reports.time_s[1] - recording.reports.time_s[0] == pytest.approx(0.177)


def test_column_names_of_marine_cadastre(tmp_path):
    header = "MMSI,BaseDateTime,LAT,LON,SOG,COG,Heading,VesselName,IMO,VesselType,Length,Width"
    row = "368,2020-06-30T00:00:00,40.6,-74.0,1.0,2.0,3.0,ABC,IMO1,70,100,20"
    recording = read_csv(csv_file(tmp_path, header, row))
    assert recording.ships[368].length_m == 100.0
    assert recording.reports.cog_deg[0] == 2.0


def test_unreadable_rows_are_counted(tmp_path):
    recording = read_csv(
        csv_file(
            tmp_path,
            "t,mmsi,lat,lon,sog",
            "2020-06-30T00:00:00,1,40.6,-74.0,5",
            "yesterday,1,40.6,-74.0,5",
            "2020-06-30T00:00:10,none,40.6,-74.0,5",
            "2020-06-30T00:00:20,1,forty,-74.0,fast",
            "2020-06-30T00:00:30,1,40.6",
        )
    )
    assert len(recording.reports) == 2
    assert np.isnan(recording.reports.latitude_deg[1])
    assert recording.notes == ("3 reports unreadable (cut off, or no time or MMSI)",)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (["t,mmsi,lat", "x,1,2"], r"no longitude column \(called lon or longitude\)"),
        ([""], "no time column"),
        (["t,mmsi,lat,lon"], "no report can be read"),
        (["t,mmsi,lat,lon", "13/12/2021 10:00,1,2,3"], "times must be ISO 8601"),
    ],
)
def test_unusable_csv(tmp_path, lines, message):
    with pytest.raises(InputError, match=message):
        read_csv(csv_file(tmp_path, *lines))


def test_damaged_gzip(tmp_path):
    path = csv_file(tmp_path, "t,mmsi,lat,lon", name="cut.csv.gz")
    path.write_bytes(path.read_bytes()[:20])
    with pytest.raises(InputError, match="cannot be read"):
        read_csv(path)
