"""AIS reports from CSV: a header line, one report a row, plain or gzipped.

Columns are known by name, in any order and case. Needed: a time (ISO 8601,
UTC), MMSI, latitude, longitude. Used if there: speed [kn], course, heading,
name, type, length, beam. Rows whose ``kind`` is ``own`` are own ship's sensors.
"""

import csv
import gzip
import io
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from glasshelm.encounters.ais_table import OWN_SENSORS, Particulars, Recording, Reports, counted
from glasshelm.errors import InputError

#: What each column may be called.
NAMES = {
    "time": ("t", "time", "time_utc", "timestamp", "basedatetime", "base_date_time"),
    "mmsi": ("mmsi",),
    "latitude": ("lat", "latitude"),
    "longitude": ("lon", "longitude"),
    "sog": ("sog", "sog_kn"),
    "cog": ("cog", "cog_deg"),
    "heading": ("heading", "heading_deg"),
    "name": ("name", "vesselname", "vessel_name"),
    "type": ("type", "vesseltype", "vessel_type"),
    "length": ("length", "length_m"),
    "beam": ("beam", "beam_m", "width"),
    "kind": ("kind",),
}
NEEDED = ("time", "mmsi", "latitude", "longitude")


def read_text(path: Path) -> str:
    """The text of a file, unzipped if its name ends in .gz; InputError if it cannot be had."""
    try:
        data = path.read_bytes()
        if path.suffix == ".gz":
            data = gzip.decompress(data)
    except (OSError, EOFError, zlib.error) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: cannot be read ({reason})") from None
    return data.decode("utf-8-sig", errors="replace")


def read_csv(path: Path) -> Recording:
    """The recording of a CSV file; rows that cannot be read are counted in its notes.

    InputError if a needed column is missing or no row can be read.
    """
    try:
        rows = list(csv.reader(io.StringIO(read_text(path), newline="")))
    except csv.Error as error:
        raise InputError(f"{path}: not a table ({error})") from None
    header = [name.strip().lower() for name in rows[0]] if rows else []
    place = {
        column: next((header.index(n) for n in names if n in header), None)
        for column, names in NAMES.items()
    }
    missing = [column for column in NEEDED if place[column] is None]
    if missing:
        wanted = " or ".join(NAMES[missing[0]])
        raise InputError(
            f"{path}: no {missing[0]} column (called {wanted}) among {', '.join(header) or 'none'}"
        )
    whole = [row for row in rows[1:] if len(row) == len(header)]
    cut = sum(1 for row in rows[1:] if row) - len(whole)

    def column(name: str) -> Sequence[str]:
        index = place[name]
        return [""] * len(whole) if index is None else [row[index] for row in whole]

    own = np.array([kind.strip().lower() == "own" for kind in column("kind")], bool)
    time_s = _times(column("time"))
    mmsi = np.where(own, OWN_SENSORS, _numbers(column("mmsi")))
    latitude, longitude = _numbers(column("latitude")), _numbers(column("longitude"))
    readable = np.isfinite(time_s) & np.isfinite(mmsi)
    reports = Reports(
        time_s,
        np.where(readable, mmsi, -1).astype(np.int64),
        latitude,
        longitude,
        _numbers(column("sog")),
        _numbers(column("cog")),
        _numbers(column("heading")),
    ).take(readable)
    if len(reports) == 0:
        raise InputError(f"{path}: no report can be read; times must be ISO 8601 (UTC)")
    who = [
        [text for text, kept in zip(column(name), readable, strict=True) if kept]
        for name in ("name", "length", "beam", "type")
    ]
    return Recording(
        reports,
        _particulars(reports.mmsi, who),
        counted(cut + int(np.sum(~readable)), "unreadable (cut off, or no time or MMSI)"),
    )


def _numbers(texts: Sequence[str]) -> np.ndarray:
    """Numbers of texts; NaN where a text is none."""
    try:
        return np.array([text or "nan" for text in texts], dtype=np.float64)
    except ValueError:
        return np.array([_number(text) for text in texts], dtype=np.float64)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return np.nan


def _times(texts: Sequence[str]) -> np.ndarray:
    """Seconds since 1970 of ISO 8601 texts (UTC); NaN where a text is none."""
    plain = [text.strip().removesuffix("Z").removesuffix("+00:00") for text in texts]
    try:
        times = np.array(plain, dtype="datetime64[ms]")
    except ValueError:
        times = np.array([_time(text) for text in plain], dtype="datetime64[ms]")
    return np.where(np.isnat(times), np.nan, times.astype(np.int64) / 1000.0)


def _time(text: str) -> np.datetime64:
    try:
        return np.datetime64(text, "ms")
    except ValueError:
        return np.datetime64("NaT", "ms")


def _particulars(mmsi: np.ndarray, columns: Sequence[Sequence[str]]) -> dict[int, Particulars]:
    """Of each ship the last particulars that say something."""
    found: dict[int, list[str]] = {}
    for ship, *fields in zip(mmsi.tolist(), *columns, strict=True):
        known = found.setdefault(ship, [""] * len(fields))
        for i, text in enumerate(fields):
            if text:
                known[i] = text
    return {
        ship: Particulars(name.strip() or None, _size(length), _size(beam), kind or None)
        for ship, (name, length, beam, kind) in found.items()
    }


def _size(text: str) -> float | None:
    value = _number(text)
    return value if value > 0 else None
