"""Tables as they are published, and what is wrong with them."""

import gzip
import warnings
from datetime import UTC, datetime

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from glasshelm.ais import csv_file
from glasshelm.ais.reading import iter_recording, read_recording_file
from glasshelm.ais.table import NOT_A_SHIP, OWN_SENSORS
from glasshelm.core.errors import InputError

NOON = datetime(2024, 6, 1, 12, tzinfo=UTC).timestamp()
SHIP = 257111110


def table(tmp_path, *lines, name="traffic.csv", end="\n"):
    path = tmp_path / name
    text = (end.join(lines) + end).encode()
    path.write_bytes(gzip.compress(text) if name.endswith(".gz") else text)
    return path


def read(path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # none may reach a user
        return read_recording_file(path)


def one(tmp_path, header, row):
    """The report and the particulars of a table of one row."""
    recording = read(table(tmp_path, header, row))
    assert recording.notes == ()
    assert len(recording.reports) == 1
    r = recording.reports
    mmsi = int(r.mmsi[0])
    report = (r.time_s[0] - NOON, mmsi, r.latitude_deg[0], r.longitude_deg[0], r.sog_kn[0])
    return (*report, r.cog_deg[0], r.heading_deg[0]), recording.ships[mmsi]


DIALECTS = {
    "own": (
        "t,mmsi,lat,lon,sog,cog,heading,name,type,nav_status,length_m,beam_m,draught_m",
        f"2024-06-01T12:00:00,{SHIP},58.5,10.25,12.5,90.5,91,ALFA,70,0,180,30,5.0",
    ),
    "Danish": (
        "# Timestamp,Type of mobile,MMSI,Latitude,Longitude,Navigational status,ROT,SOG,COG,Heading"
        ",IMO,Callsign,Name,Ship type,Cargo type,Width,Length,Type of position fixing device",
        f"01/06/2024 12:00:00,Class A,{SHIP},58.5,10.25,Under way,,12.5,90.5,91,Unknown,Unknown"
        ",ALFA,70,,30,180,GPS",
    ),
    "Norwegian": (
        "mmsi;imo;callsign;name;ship_type;length;width;date_time_utc;lon;lat;sog;cog;true_heading",
        f"{SHIP};;;ALFA;70;180;30;2024-06-01 12:00:00;10.25;58.5;12.5;90.5;91",
    ),
    "BarentsWatch": (
        "courseOverGround,latitude,longitude,name,shipType,speedOverGround,trueHeading,mmsi,msgtime"
        ",shipLength,shipWidth",
        f"90.5,58.5,10.25,ALFA,70,12.5,91,{SHIP},2024-06-01T12:00:00+00:00,180,30",
    ),
    "American until 2024": (
        "MMSI,BaseDateTime,LAT,LON,SOG,COG,Heading,VesselName,IMO,CallSign,VesselType,Status,Length"
        ",Width,Draft,Cargo,TransceiverClass",
        f"{SHIP},2024-06-01T12:00:00,58.5,10.25,12.5,90.5,91.0,ALFA,,,70,0,180,30,8.0,70,A",
    ),
    "American since 2025": (
        "mmsi,base_date_time,longitude,latitude,sog,cog,heading,vessel_name,imo,call_sign"
        ",vessel_type,status,length,width,draft,cargo,transceiver",
        f"{SHIP},2024-06-01 12:00:00,10.25,58.5,12.5,90.5,91,ALFA,,,70,0,180,30,8,70,A",
    ),
    "decimal commas": (
        "MMSI;Time (UTC);Latitude;Longitude;SOG [kn];COG;Heading;Name;Type;Length;Beam",
        f"{SHIP};01.06.2024 12:00;58,5;10,25;12,5;90,5;91;ALFA;70;180,0;30,0",
    ),
    "quoted, tabs": (
        '"MMSI"\t"TIMESTAMP"\t"LAT"\t"LON"\t"SOG"\t"COG"\t"HEADING"\t"SHIPNAME"\t"SHIPTYPE"'
        '\t"LENGTH"\t"WIDTH"',
        f'"{SHIP}"\t"2024-06-01 12:00:00 UTC"\t"58.5"\t"10.25"\t"12.5"\t"90.5"\t"91"\t"ALFA"\t"70"'
        '\t"180"\t"30"',
    ),
}  # fmt: skip


@pytest.mark.parametrize("dialect", DIALECTS)
def test_columns_as_they_are_published(tmp_path, dialect):
    report, ship = one(tmp_path, *DIALECTS[dialect])
    assert report == (0.0, SHIP, 58.5, 10.25, 12.5, 90.5, 91.0)
    assert (ship.name, ship.ship_type, ship.length_m, ship.beam_m) == ("ALFA", "70", 180.0, 30.0)


@pytest.mark.parametrize("name", ["a.csv", "b.CSV.GZ", "c.txt", "d.tsv", "e"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", [",", ";", "\t", "|"])
def test_any_name_line_end_and_delimiter(tmp_path, name, end, mark):
    lines = ["mmsi,t,lat,lon", f"{SHIP},{NOON:.0f},58.5,10.25"]
    path = table(tmp_path, *(x.replace(",", mark) for x in lines), name=name, end=end)
    assert read(path).reports.latitude_deg.tolist() == [58.5]


@pytest.mark.parametrize(
    ("column", "text", "seconds"),
    [
        ("timestamp", "2024-06-01T12:00:00Z", 0),
        ("timestamp", "2024-06-01T14:00:00+02:00", 0),
        ("timestamp", "2024-06-01 12:00", 0),
        ("t", "2024-06-01T12:00:00.500", 0.5),
        ("date_time_utc", "2024-06-01T12:00:00.123456789", 0.123456),
        ("time", "1/6/2024 12:00:30", 30),
        ("time", f"{NOON:.0f}", 0),
        ("t", f"{NOON:.0f}250", 0.25),
        ("unixtime", f"{NOON + 0.5}", 0.5),
        ("timestamp", f"{NOON:.0f}000000", 0),
        ("timestamp", f"{NOON:.0f}000000000", 0),
    ],
)
def test_times(tmp_path, column, text, seconds):
    report, _ = one(tmp_path, f"mmsi,{column},lat,lon", f"{SHIP},{text},58.5,10.25")
    assert report[0] == pytest.approx(seconds, abs=1e-5)


@pytest.mark.parametrize(
    "text",
    ["2024", "yesterday", "1970-01-01 00:00:00", "2024-06-01", "31/31/2024 12:00:00", "12:00:00",
     "", "-5", "1e300", "nan", "45444.5", "0001-01-01T00:00:00+14:00", "2024-06-31 12:00:00"],
)  # fmt: skip
def test_no_times(tmp_path, text):
    rows = [f"{SHIP},{text},58.5,10.25"] * 3
    with pytest.raises(InputError, match=r"no report can be read: 3 of 3 rows: time .* \(row 2\)"):
        read(table(tmp_path, "mmsi,time,lat,lon", *rows))


@pytest.mark.parametrize(
    ("mmsi", "says"),
    [
        ("a3f9c0ffee", "MMSI 'a3f9c0ffee' is no number"),
        ("9" * 60, f"MMSI '{'9' * 24}…' is none"),
        ("-5", "MMSI '-5' is none"),
        ("-1", "MMSI '-1' is none"),
        ("1e300", "MMSI '1e300' is none"),
        ("257111110.5", "MMSI '257111110.5' is none"),
        ("1000000000", "MMSI '1000000000' is none"),
        ("inf", "MMSI 'inf' is no"),
        ("", "without MMSI"),
        ("0", "without MMSI"),
        ("nan", "without MMSI"),
    ],
)
def test_identities_that_are_none(tmp_path, mmsi, says):
    rows = [f"{mmsi},{NOON},58.5,10.25"] * 3
    with pytest.raises(InputError) as error:
        read(table(tmp_path, "mmsi,time,lat,lon", *rows))
    assert f"3 of 3 rows: {says}" in str(error.value)
    recording = read(table(tmp_path, "mmsi,time,lat,lon", *rows, f"{SHIP},{NOON},58.5,10.25"))
    assert recording.reports.mmsi.tolist() == [SHIP]
    (note,) = recording.notes
    assert note.startswith(f"3 rows unreadable: {says}")


@pytest.mark.parametrize("mmsi", ["257111110.0", " 257111110 ", "2.5711111e8", '"257111110"'])
def test_identities_written_otherwise(tmp_path, mmsi):
    report, _ = one(tmp_path, "mmsi,time,lat,lon", f"{mmsi},{NOON},58.5,10.25")
    assert report[1] == SHIP


def test_own_sensors_are_named_by_their_kind_alone(tmp_path):
    rows = [f"ais,{SHIP},{NOON},58.5,10.25", f"own,,{NOON},58.5,10.25", f"own,5,{NOON},58.5,10.25"]
    recording = read(table(tmp_path, "kind,mmsi,time,lat,lon", *rows))
    assert recording.reports.mmsi.tolist() == [SHIP, OWN_SENSORS, OWN_SENSORS]
    assert not 1 <= OWN_SENSORS <= 999_999_999


@pytest.mark.parametrize(
    ("column", "texts"),
    [
        (
            "Type of mobile",
            ("Base Station", "AtoN", "SAR Airborne", "sar airborne", "BASE STATION"),
        ),
        ("message_nr", ("4", "9", "11", "21")),
    ],
)
def test_stations_and_aircraft_are_no_ships(tmp_path, column, texts):
    rows = [f"{text},{SHIP},{NOON},58.5,10.25" for text in (*texts, "Class A", "")]
    recording = read(table(tmp_path, f"{column},mmsi,time,lat,lon", *rows))
    assert recording.reports.mmsi.tolist() == [NOT_A_SHIP] * len(texts) + [SHIP] * 2


GOOD = f"{SHIP},{NOON},58.5,10.25,"


@pytest.mark.parametrize(
    ("bad", "says"),
    [
        (f'{SHIP},{NOON},58.5,10.25,"OPEN', "a quote that does not close"),
        (f'{SHIP},{NOON},58.5,"10.25,ALFA', "a quote that does not close"),
        (f"{SHIP},{NOON},58.5", "3 fields, the header has 5"),
        (f"{SHIP},{NOON},58.5,10.25,ALFA,BRAVO", "6 fields, the header has 5"),
        (GOOD + '"' + "X" * 200_000, "a quote that does not close"),
        ("junk", "1 fields, the header has 5"),
    ],
)
@pytest.mark.parametrize("place", [0, 7, 20])
def test_a_bad_row_costs_itself_alone(tmp_path, bad, says, place):
    rows = [GOOD + f"SHIP {i}" for i in range(20)]
    rows.insert(place, bad)
    recording = read(table(tmp_path, "mmsi,time,lat,lon,name", *rows))
    assert len(recording.reports) == 20
    assert recording.notes == (f"1 row unreadable: {says} (row {place + 2})",)


@pytest.mark.parametrize(
    "row",
    [GOOD + "ALFA,", GOOD + "ALFA,,,", GOOD + '"ALFA"', GOOD + '"A ""B"" C"', GOOD + '"A, B"',
     GOOD + 'A "B" C', GOOD + 'A 12" B', GOOD + "AL\0FA"],
)  # fmt: skip
@pytest.mark.parametrize("count", [1, 3])
def test_rows_that_are_odd_and_can_be_read(tmp_path, row, count):
    rows = [GOOD + "ALFA", *[row] * count, GOOD + "ALFA"]
    recording = read(table(tmp_path, "mmsi,time,lat,lon,name", *rows))
    assert (len(recording.reports), recording.notes) == (count + 2, ())


def test_a_comma_at_the_end_of_every_row(tmp_path):
    lines = ["mmsi,time,lat,lon,name", *[GOOD + "ALFA,"] * 5, GOOD + "ALFA"]
    recording = read(table(tmp_path, *lines))
    assert (len(recording.reports), recording.ships[SHIP].name) == (6, "ALFA")
    assert len(read(table(tmp_path, lines[0] + ",", *lines[1:])).reports) == 6


def test_what_is_no_row_is_passed_over(tmp_path):
    header = "mmsi,time,lat,lon,name"
    lines = ["", "sep=,", header, GOOD, "", header, header.upper(), GOOD, ""]
    recording = read(table(tmp_path, *lines))
    assert (len(recording.reports), recording.notes) == (2, ())


def test_a_table_of_many_blocks(tmp_path, monkeypatch):
    monkeypatch.setattr(csv_file, "BLOCK", 200_000)
    rows = [f"{SHIP + i % 7},{NOON + i},58.5,10.25,SHIP {i}" for i in range(15_000)]
    rows[10_000] = "torn"
    recording = read(table(tmp_path, "mmsi,time,lat,lon,name", *rows, name="big.csv"))
    assert (tmp_path / "big.csv").stat().st_size > 2 * csv_file.BLOCK
    assert len(recording.reports) == 14_999
    assert recording.notes == ("1 row unreadable: 1 fields, the header has 5 (row 10002)",)
    assert recording.ships[SHIP + 14_999 % 7].name == "SHIP 14999"


def test_numbers_that_are_none_are_not_known(tmp_path):
    header = "mmsi,time,lat,lon,sog,cog,heading,length"
    rows = [f"{SHIP},{NOON},58.5,10.25,fast,,null,-3", f"{SHIP},{NOON},58.5,10.25,5,Unknown,,1e9"]
    recording = read(table(tmp_path, header, *rows))
    r = recording.reports
    np.testing.assert_array_equal(r.latitude_deg, [58.5, 58.5])
    np.testing.assert_array_equal(r.sog_kn, [np.nan, 5])
    assert np.isnan(r.cog_deg).all()
    assert recording.ships[SHIP].length_m is None


def test_the_reason_that_holds_for_most_is_told(tmp_path):
    rows = [f"{SHIP},2024,58.5,10.25", *["0,1717243200,58.5,10.25"] * 2]
    with pytest.raises(InputError, match="2 of 3 rows: without MMSI"):
        read(table(tmp_path, "mmsi,time,lat,lon", *rows))
    recording = read(table(tmp_path, "mmsi,time,lat,lon", *rows, f"{SHIP},{NOON},58.5,10.25"))
    assert recording.notes[0].startswith("2 rows unreadable: without MMSI (the first: row 3)")
    assert recording.notes[1].startswith("1 row unreadable: time '2024' is none")


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (
            ["t,mmsi,lat", "x,1,2"],
            r"no longitude column \(called lon or longitude .* among t, mmsi",
        ),
        (["t,mmsi,lat,lon"], "no report can be read: no row is in it"),
        (["t,mmsi,lat,lon", "t,mmsi,lat,lon"], "no row is in it"),
        (["1,2,3,4", "1,2,3,4"], "no time column .* among 1, 2, 3, 4"),
        (["a,b"], "no time column"),
    ],
)
def test_unusable_tables(tmp_path, lines, message):
    with pytest.raises(InputError, match=message) as error:
        read(table(tmp_path, *lines))
    assert "\n" not in str(error.value)


def wkb(longitude, latitude, order="<"):
    head = (b"\x01" if order == "<" else b"\x00") + np.array([1], f"{order}u4").tobytes()
    return head + np.array([longitude, latitude], f"{order}f8").tobytes()


COUNT = 5
TIMES = {
    "timestamp": pa.array([int(NOON) + i for i in range(COUNT)], pa.timestamp("s")),
    "with a zone": pa.array(
        [(int(NOON) + i) * 1000 for i in range(COUNT)], pa.timestamp("ms", "Europe/Oslo")
    ),
    "nanoseconds": pa.array(
        [int(NOON + i) * 10**9 + (0 if i else 1) for i in range(COUNT)], pa.timestamp("ns")
    ),
    "binary": pa.array([b"2024-06-01T12:00:0%d" % i for i in range(COUNT)]),
    "text": pa.array([f"2024-06-01T12:00:0{i}" for i in range(COUNT)]),
    "number": pa.array([NOON + i for i in range(COUNT)]),
    "dictionary": pa.array([f"01/06/2024 12:00:0{i}" for i in range(COUNT)]).dictionary_encode(),
}


@pytest.mark.parametrize("time", TIMES)
@pytest.mark.parametrize("mmsi", [pa.int64(), pa.int32(), pa.string(), pa.float64()])
def test_parquet(tmp_path, time, mmsi):
    columns = {
        "MMSI": pa.array([SHIP] * COUNT, pa.int64()).cast(mmsi),
        "base_date_time": TIMES[time],
        "longitude": pa.array([10.25] * COUNT),
        "latitude": pa.array([58.5] * COUNT, pa.float32()),
        "vessel_name": pa.array([None, "ALFA", "", "Unknown", None]),
        "length": pa.array([180] * COUNT, pa.int16()),
        "sog": pa.array([12.5, None, 12.5, 12.5, 12.5]),
    }
    path = tmp_path / "ais.parquet"
    pq.write_table(pa.table(columns), path, row_group_size=2)
    recording = read(path)
    r = recording.reports
    assert (r.time_s - NOON).round(6).tolist() == [0, 1, 2, 3, 4]
    assert set(r.mmsi.tolist()) == {SHIP}
    assert np.isnan(r.sog_kn[1])
    ship = recording.ships[SHIP]
    assert (ship.name, ship.length_m) == ("ALFA", 180.0)


@pytest.mark.parametrize("unit", ["ms", "us", "ns"])
@pytest.mark.parametrize("bad", [2**63 - 2, -(2**63) + 2, 0])
def test_one_impossible_instant_costs_one_row(tmp_path, unit, bad):
    scale = {"ms": 10**3, "us": 10**6, "ns": 10**9}[unit]
    columns = {
        "mmsi": pa.array([SHIP] * COUNT),
        "timestamp": pa.array(
            [bad, *(int(NOON + i) * scale for i in range(1, COUNT))], pa.timestamp(unit)
        ),
        "longitude": pa.array([10.25] * COUNT),
        "latitude": pa.array([58.5] * COUNT),
        "vessel_name": pa.array(["ÆGIR".encode("latin-1")] * COUNT),
    }
    path = tmp_path / "ais.parquet"
    pq.write_table(pa.table(columns), path)
    recording = read(path)
    assert (recording.reports.time_s - NOON).tolist() == [1, 2, 3, 4]
    assert recording.ships[SHIP].name == "ÆGIR"
    assert len(recording.notes) == 1


def test_points_of_geoparquet(tmp_path):
    points = [wkb(10.25, 58.5), wkb(-10.25, -58.5, ">"), b"junk", None]
    columns = {"mmsi": [SHIP] * 4, "time": [NOON] * 4, "geometry": pa.array(points, pa.binary())}
    pq.write_table(pa.table(columns), tmp_path / "p")
    r = read(tmp_path / "p").reports
    np.testing.assert_array_equal(r.latitude_deg, [58.5, -58.5, np.nan, np.nan])
    np.testing.assert_array_equal(r.longitude_deg, [10.25, -10.25, np.nan, np.nan])


def test_groups_of_rows_of_another_time_are_not_read(tmp_path):
    times = [datetime.fromtimestamp(NOON + 60 * i, UTC).replace(tzinfo=None) for i in range(100)]
    columns = {"mmsi": [SHIP] * 100, "time": times, "lat": [58.5] * 100, "lon": [10.25] * 100}
    pq.write_table(pa.table(columns), tmp_path / "p", row_group_size=10)
    seen = []

    def wanted(reports):
        seen.extend(reports.time_s.tolist())
        return np.ones(len(reports), bool)

    list(iter_recording(tmp_path / "p", [], wanted, NOON + 600, NOON + 660))
    assert (min(seen) - NOON, max(seen) - NOON) == (600, 1140)
    assert list(iter_recording(tmp_path / "p", [], wanted, NOON - 600, NOON - 60)) == []


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"PAR1" + bytes(40) + b"PAR1", "a Parquet table that cannot be read"),
        ({"a": [1]}, "no time column"),
        ({"mmsi": [0], "t": [NOON], "lat": [1.0], "lon": [1.0]}, "1 of 1 rows: without MMSI"),
        ({"mmsi": pa.array([], pa.int64()), "t": [], "lat": [], "lon": []}, "no row is in it"),
    ],
)
def test_unusable_parquet(tmp_path, data, says):
    path = tmp_path / "p.parquet"
    if isinstance(data, bytes):
        path.write_bytes(data)
    else:
        pq.write_table(pa.table(data), path)
    with pytest.raises(InputError, match=says) as error:
        read(path)
    assert "\n" not in str(error.value)


def test_read_csv_reads_it_all(tmp_path):
    recording = read_recording_file(
        table(tmp_path, "mmsi,t,lat,lon", f"{SHIP},{NOON},58.5,10.25", "x,x,x,x")
    )
    assert len(recording.reports) == len(recording.notes) == 1


def test_a_rounded_mmsi_and_a_latitude_in_words_are_named(tmp_path):
    rows = [f"2.57E+08,{NOON},58.5,10.25", f"2.57000001E+08,{NOON},58.5,10.25"]
    rows += [f"{SHIP},{NOON},north,10.25"]
    recording = read(table(tmp_path, "mmsi,t,lat,lon", *rows))
    assert recording.reports.mmsi.tolist() == [257000001]
    assert recording.notes == (
        "1 row unreadable: MMSI '2.57E+08' is rounded: its last digits are lost (row 2)",
        "1 row unreadable: latitude 'north' is no number (row 4)",
    )
