"""An hour cut from a day of recorded traffic of a country: rows a second, and the memory it takes.

The day is made of the bundled recording of New York, shifted in place, time and MMSI, so that its
rows are as many and as mixed as those of a national day file. Each format is read in a process
of its own. ``python benchmarks/recordings.py --rows 8000000 --formats csv csv.gz parquet``;
``--format bomb`` is a small packed file of ten million rows.
"""

import argparse
import gzip
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from importlib.resources import as_file, files
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pa_csv
import pyarrow.parquet as pq

from glasshelm.ais.reading import read_recording_file
from glasshelm.ais.table import ReportTable

FORMATS = ("csv", "csv.gz", "csv.zst", "parquet", "nmea", "bomb")
#: The day begins, and the recording it is made of lasts [s].
DAY = datetime(2024, 6, 1, tzinfo=UTC).timestamp()
LASTS_S = 1500.0
OWN = 367000190
#: Places in which the recording is repeated: rows and columns of a grid of harbours [deg].
STEP_DEG = 1.5


def traffic(rows: int) -> Iterator[pa.Table]:
    """The reports of a day in order of time, in pieces of one repetition of the recording."""
    with as_file(files("glasshelm") / "data" / "new_york.csv.gz") as path:
        reports = read_recording_file(path).reports
    reports = reports.take(np.argsort(reports.time_s, kind="stable"))
    times = int(86_400 // LASTS_S)
    harbours = max(rows // (times * len(reports)), 1)
    for i in range(times):
        yield _piece(reports, i, harbours)


def _piece(r: ReportTable, repetition: int, harbours: int) -> pa.Table:
    """The traffic of all harbours in one repetition; ships keep their numbers through the day."""
    harbour = np.arange(harbours)
    east, north = harbour % 20 * STEP_DEG, harbour // 20 * STEP_DEG
    time = np.round(r.time_s - r.time_s[0] + DAY + repetition * LASTS_S)
    columns = {
        "MMSI": (r.mmsi[:, None] % 1_000_000 + 201_000_000 + 1_000_000 * (harbour % 700)).ravel(),
        "BaseDateTime": pa.array(np.repeat(time, harbours).astype("datetime64[s]")),
        "LAT": np.clip(r.latitude_deg[:, None] + north - 10, -80, 80).ravel().round(5),
        "LON": (r.longitude_deg[:, None] + east).ravel().round(5),
        "SOG": np.repeat(r.sog_kn, harbours),
        "COG": np.repeat(r.cog_deg, harbours),
        "Heading": np.repeat(r.heading_deg, harbours),
        "VesselName": pa.array(["SOME SHIP"] * len(time)).take(
            np.repeat(np.arange(len(time)), harbours)
        ),
        "Length": np.full(len(time) * harbours, 180),
        "Width": np.full(len(time) * harbours, 30),
        "TransceiverClass": pa.array(["A"]).take(np.zeros(len(time) * harbours, int)),
    }
    own = r.mmsi == OWN
    columns["MMSI"].reshape(len(r), harbours)[own, 0] = OWN
    return pa.table(columns)


def written(folder: Path, form: str, rows: int) -> tuple[Path, int]:
    """A day in a format, and how many reports it has."""
    path, count = folder / f"day.{form}", 0
    if form == "bomb":
        path = folder / "bomb.csv.gz"
        row = b"367000190,2024-06-01T12:00:00,40.5,-74.0\n"
        with gzip.open(path, "wb", 9) as file:
            file.write(b"mmsi,t,lat,lon\n")
            for _ in range(1000):
                file.write(row * 10_000)
        return path, 10_000_000
    if form == "nmea":
        return path, _nmea(path, rows)
    if form == "parquet":
        writer = None
        for table in traffic(rows):
            writer = writer or pq.ParquetWriter(path, table.schema, compression="zstd")
            writer.write_table(table, row_group_size=200_000)
            count += len(table)
        assert writer is not None
        writer.close()
        return path, count
    packing = {"csv": None, "csv.gz": "gzip", "csv.zst": "zstd"}[form]
    with pa.output_stream(path, compression=packing) as sink:
        for i, table in enumerate(traffic(rows)):
            form_of = pa_csv.WriteOptions(include_header=i == 0, quoting_style="needed")
            pa_csv.write_csv(table, sink, form_of)
            count += len(table)
    return path, count


def _nmea(path: Path, rows: int) -> int:
    from pyais.encode import encode_dict

    count = 0
    with path.open("w") as file:
        for table in traffic(rows):
            for row in table.to_pylist():
                seconds = int(row["BaseDateTime"].replace(tzinfo=UTC).timestamp())
                message = {
                    "type": 1, "mmsi": row["MMSI"], "lat": row["LAT"], "lon": row["LON"],
                    "speed": row["SOG"] if row["SOG"] == row["SOG"] else 102.3,
                    "course": row["COG"] if row["COG"] == row["COG"] else 360.0,
                }  # fmt: skip
                tag = f"c:{seconds}"
                check = 0
                for character in tag:
                    check ^= ord(character)
                (line,) = encode_dict(message, talker_id="AI", sentence_type="VDM")
                file.write(f"\\{tag}*{check:02X}\\{line}\n")
                count += 1
    return count


def cut(path: Path) -> None:
    """An hour around noon as a scenario; prints what it took."""
    from glasshelm.core.errors import InputError
    from glasshelm.encounters.recorded_traffic import recorded_scenario
    from glasshelm.encounters.scenario_factory import recording_settings as minutes
    from glasshelm.ship.nomoto import SHIPS

    imported = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    begun = time.perf_counter()
    try:
        found = recorded_scenario(path, SHIPS["paper"], OWN, "12:00", minutes(60.0))
        told = f"{len(found.targets)} ships, {found.duration_s:.0f} s"
    except InputError as error:
        told = str(error).removeprefix(str(path))
    took = time.perf_counter() - begun
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{took:.1f} {peak:.0f} {imported:.0f} {told}")


def main() -> None:
    """Make each file, and read it in a process of its own."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--rows", type=int, default=8_000_000)
    options.add_argument("--formats", nargs="+", choices=FORMATS, default=FORMATS)
    options.add_argument("--cut", type=Path, help=argparse.SUPPRESS)
    given = options.parse_args()
    if given.cut is not None:
        cut(given.cut)
        return
    for form in given.formats:
        with tempfile.TemporaryDirectory() as folder:
            path, rows = written(Path(folder), form, given.rows)
            size = path.stat().st_size / 1e6
            command = [sys.executable, __file__, "--cut", str(path)]
            out = subprocess.run(command, capture_output=True, text=True, check=True).stdout
            took, peak, imported, told = out.strip().split(" ", 3)
            print(
                f"{form}: {rows:,} rows, {size:,.0f} MB: {took} s, {rows / float(took):,.0f} "
                f"rows/s, peak {peak} MB (of which the program itself {imported} MB): {told}",
                flush=True,
            )


if __name__ == "__main__":
    main()
