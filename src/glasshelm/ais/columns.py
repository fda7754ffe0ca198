"""From the columns of a published table to reports: what they may be called, and what they hold.

Columns are known by name, in any order and case. Needed: a time, an MMSI, latitude and longitude
(or a point as WKB). Used if there: speed [kn], course, heading, name, type, length, beam, kind
of station. Rows whose ``kind`` is ``own`` are own ship's sensors.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute

from glasshelm.ais.limits import epoch_seconds, is_mmsi, is_size_m
from glasshelm.ais.table import NOT_A_SHIP, OWN_SENSORS, Recording, ReportTable, StaticData
from glasshelm.ais.tally import RowErrors

#: Its functions are made when it is imported: no checker of types knows them.
pc: Any = pyarrow.compute

#: What each column may be called, in small letters and digits alone: those of the Danish Maritime
#: Authority, Kystverket and BarentsWatch, MarineCadastre (until 2024, since 2025), open research
#: sets, and our own.
COLUMN_NAMES: dict[str, tuple[str, ...]] = {
    "time": (
        "timestamp", "timestamputc", "basedatetime", "datetimeutc", "datetime", "msgtime",
        "unixtime", "timeutc", "epoch", "time", "ts", "t",  # the last may be a time of day
    ),
    "mmsi": ("mmsi", "sourcemmsi", "mmsinumber", "vesselid"),
    "latitude": ("lat", "latitude", "latdeg"),
    "longitude": ("lon", "longitude", "long", "lng", "londeg"),
    "sog": ("sog", "sogkn", "speedoverground", "speed"),
    "cog": ("cog", "cogdeg", "courseoverground", "course"),
    "heading": ("heading", "headingdeg", "trueheading", "hdg"),
    "name": ("name", "vesselname", "shipname"),
    "type": ("type", "vesseltype", "shiptype"),
    "length": ("length", "lengthm", "shiplength"),
    "beam": ("beam", "beamm", "width", "shipwidth"),
    "kind": ("kind",),
    "station": ("typeofmobile",),
    "message": ("messagetype", "messagenr", "msgtype", "messageid"),
    "point": ("geometry", "geom"),
}  # fmt: skip
NEEDED = ("time", "mmsi", "latitude", "longitude")

TIME = "time {} is none from 1990 to 2100 (ISO 8601, dd/mm/yyyy hh:mm:ss, or seconds since 1970)"
MMSI_TEXT = "MMSI {} is no number"
MMSI_RANGE = "MMSI {} is none (1 to 999999999)"
NO_MMSI = "without MMSI"

_STATIONS = re.compile(r"basestation|aton|aidto|aidsto|sarairborne|aircraft|airborne")
_STATION_MESSAGES = (4, 9, 11, 21)
#: What stands for "nothing" in a text.
NULL_TEXTS = ("", "nan", "NaN", "NAN", "null", "NULL", "None", "N/A", "n/a", "Unknown", "Undefined")

_DANISH = re.compile(
    r"(\d{1,2})[/.-](\d{1,2})[/.-](\d{4})[ T](\d{1,2}):(\d{2})(?::(\d{2}(?:\.\d+)?))?$", re.ASCII
)
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$", re.ASCII)
#: A point as well-known binary, little-endian: order, type (1; with Z, M, SRID by EWKB or ISO).
_WKB_POINT = 21


def normalized(name: str) -> str:
    """The name of a column as :data:`NAMES` has it: ``# Timestamp (UTC)`` is ``timestamputc``."""
    return re.sub(r"[^a-z0-9]", "", name.lower())


def find_columns(header: Sequence[str]) -> dict[str, int]:
    """Where each column that is used stands in a header; those that are not there are left out."""
    given = [normalized(name) for name in header]
    found = {
        column: next((given.index(name) for name in names if name in given), None)
        for column, names in COLUMN_NAMES.items()
    }
    return {column: place for column, place in found.items() if place is not None}


def missing_column(found: Mapping[str, object], header: Sequence[str]) -> str | None:
    """What a header lacks, in words; None if nothing that is needed."""
    have = {*found, "latitude", "longitude"} if "point" in found else found
    lacking = next((column for column in NEEDED if column not in have), None)
    if lacking is None:
        return None
    shown = ", ".join(name.strip() for name in header)[:200] or "none"
    return f"no {lacking} column (called {' or '.join(COLUMN_NAMES[lacking])}) among {shown}"


def to_recording(
    columns: Mapping[str, pa.Array],
    rows: np.ndarray,
    wanted: Callable[[ReportTable], np.ndarray],
    tally: RowErrors,
    decimal_comma: bool = False,
) -> Recording:
    """The reports of a part of a table, and the particulars of their ships.

    Args:
        columns: Arrow arrays of one length by the keys of :data:`NAMES`, texts or numbers.
        rows: The number of each row in the file.
        wanted: Which of the reports are kept.
        tally: Counts the rows that cannot be read.
        decimal_comma: Whether numbers may have a comma instead of a point.
    """
    count = len(rows)

    def numbers(column: str) -> np.ndarray:
        if column not in columns:
            return np.full(count, np.nan)
        return _numbers(columns[column], decimal_comma)

    time_s = _times(columns["time"])
    mmsi, sure = _identities(columns, numbers("mmsi"), rows, tally)
    no_time = sure & np.isnan(time_s)
    tally.add_all(TIME, no_time, rows, columns["time"])
    readable = sure & ~no_time
    if "latitude" in columns and "longitude" in columns:
        latitude, longitude = numbers("latitude"), numbers("longitude")
    else:
        latitude, longitude = _points(columns["point"])
    motion = (numbers(column) for column in ("sog", "cog", "heading"))
    reports = ReportTable(
        time_s,
        np.where(readable, mmsi, NOT_A_SHIP).astype(np.int64),
        latitude,
        longitude,
        *motion,
    ).take(readable)
    tally.rows += count
    tally.read += len(reports)
    kept = wanted(reports)
    where = np.flatnonzero(readable)[kept]
    reports = reports.take(kept)
    return Recording(reports, _particulars(reports.mmsi, columns, where, decimal_comma))


def _identities(
    columns: Mapping[str, pa.Array], given: np.ndarray, rows: np.ndarray, tally: RowErrors
) -> tuple[np.ndarray, np.ndarray]:
    """Of each row the number of its ship, and whether it has one."""
    count = len(rows)
    own = _matches(columns.get("kind"), lambda text: text == "own", count)
    texts = columns["mmsi"]
    empty = (texts.is_null(nan_is_null=True).to_numpy(zero_copy_only=False) | (given == 0)) & ~own
    no_number = np.isnan(given) & ~empty & ~own
    whole = np.floor(given) == given
    out = ~(is_mmsi(given) & whole) & ~empty & ~no_number & ~own
    tally.add_all(NO_MMSI, empty, rows, None)
    tally.add_all(MMSI_TEXT, no_number, rows, texts)
    tally.add_all(MMSI_RANGE, out, rows, texts)
    station = _matches(
        columns.get("station"), lambda t: bool(_STATIONS.search(normalized(t))), count
    )
    if "message" in columns:
        station |= np.isin(_numbers(columns["message"], False), _STATION_MESSAGES)
    sure = own | ~(empty | no_number | out)
    return np.where(own, OWN_SENSORS, np.where(station, NOT_A_SHIP, np.where(sure, given, 0))), sure


def _matches(texts: pa.Array | None, test: Callable[[str], bool], count: int) -> np.ndarray:
    if texts is None:
        return np.zeros(count, bool)
    return _by_value(texts, lambda text: float(test(str(text).strip().lower()))) == 1.0


def _by_value(values: pa.Array, of: Callable[[object], float]) -> np.ndarray:
    """A number for each value, found once for those that are alike; NaN for none."""
    coded = values.dictionary_encode()
    found = np.array([of(value) for value in coded.dictionary.to_pylist()] + [np.nan])
    return found[pc.fill_null(coded.indices, len(found) - 1).to_numpy(zero_copy_only=False)]


def _is_text(values: pa.Array) -> bool:
    return pa.types.is_string(values.type) or pa.types.is_large_string(values.type)


def _numbers(values: pa.Array, decimal_comma: bool) -> np.ndarray:
    """Numbers of texts or of numbers; NaN where there is none."""
    if not _is_text(values):
        return _floats(values)
    if decimal_comma:
        values = pc.replace_substring(values, ",", ".")
    try:
        return _floats(values)
    except pa.ArrowInvalid:
        return _by_value(values, lambda text: _number(str(text)))


def _floats(values: pa.Array) -> np.ndarray:
    if pa.types.is_decimal(values.type) or pa.types.is_boolean(values.type):
        values = values.cast(pa.string())
    numbers = pc.fill_null(values.cast(pa.float64(), safe=False), np.nan)
    return numbers.to_numpy(zero_copy_only=False)


def _number(text: str) -> float:
    text = text.strip()
    return float(text) if _NUMBER.match(text) else np.nan


def _times(values: pa.Array) -> np.ndarray:
    """Seconds since 1970 of times, texts or numbers; NaN where there is none."""
    if pa.types.is_timestamp(values.type):
        counts = pc.fill_null(values.cast(pa.int64()), -1).to_numpy(zero_copy_only=False)
        return epoch_seconds(counts / {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[values.type.unit])
    if not _is_text(values):
        return epoch_seconds(_floats(values))
    coded = values.dictionary_encode()
    texts = coded.dictionary
    try:  # the form of nearly all
        if pc.min(pc.utf8_length(texts)).as_py() in (None, *range(16)):
            raise pa.ArrowInvalid("a date alone, or a number")
        found = _times(texts.cast(pa.timestamp("us")))
    except pa.ArrowInvalid:
        found = np.array([_time(text) for text in texts.to_pylist()], np.float64)
    codes = pc.fill_null(coded.indices, len(found)).to_numpy(zero_copy_only=False)
    return np.append(found, np.nan)[codes]


def _time(text: str) -> float:
    """Seconds since 1970 of a text; NaN if it is no time, or one of a day alone."""
    text = text.strip().removesuffix("UTC").strip()
    if _NUMBER.match(text):
        return epoch_seconds(float(text))
    danish = _DANISH.match(text)
    try:
        if danish:
            day, month, year, hour, minute, second = danish.groups()
            seconds = float(second or 0)
            time = datetime(int(year), int(month), int(day), int(hour), int(minute), tzinfo=UTC)
            return epoch_seconds(time.timestamp() + seconds) if seconds < 61 else np.nan
        if len(text) < 13:
            return np.nan
        time = datetime.fromisoformat(text)
        return epoch_seconds((time if time.tzinfo else time.replace(tzinfo=UTC)).timestamp())
    except (ValueError, OverflowError):
        return np.nan


def _points(values: pa.Array) -> tuple[np.ndarray, np.ndarray]:
    """Latitudes and longitudes of points in well-known binary; NaN where there is none."""
    points = np.full((len(values), 2), np.nan)
    for i, value in enumerate(values.to_pylist()):
        if isinstance(value, bytes) and len(value) >= _WKB_POINT and value[0] in (0, 1):
            order = "<" if value[0] == 1 else ">"
            kind = int(np.frombuffer(value, f"{order}u4", 1, 1)[0])
            if (kind & 0xFFFF) % 1000 == 1:
                start = 9 if kind & 0x2000_0000 else 5
                if len(value) >= start + 16:
                    points[i] = np.frombuffer(value, f"{order}f8", 2, start)
    return points[:, 1], points[:, 0]


def _particulars(
    mmsi: np.ndarray, columns: Mapping[str, pa.Array], where: np.ndarray, decimal_comma: bool
) -> dict[int, StaticData]:
    """Of each ship the last particulars that say something; ``where`` are the rows of ``mmsi``."""
    found: dict[int, dict[str, str]] = {ship: {} for ship in np.unique(mmsi).tolist()}
    for field in ("name", "length", "beam", "type"):
        if field not in columns or not len(where):
            continue
        texts = columns[field].take(pa.array(where)).cast(pa.string())
        said = np.flatnonzero(texts.is_valid().to_numpy(zero_copy_only=False))[::-1]
        ships, last = np.unique(mmsi[said], return_index=True)
        for ship, text in zip(
            ships.tolist(), texts.take(pa.array(said[last])).to_pylist(), strict=True
        ):
            found[ship][field] = text.strip()

    def size(text: str) -> float | None:
        value = _number(text.replace(",", ".") if decimal_comma else text)
        return value if is_size_m(value) else None

    return {
        ship: StaticData(
            said.get("name") or None,
            size(said.get("length", "")),
            size(said.get("beam", "")),
            said.get("type") or None,
        )
        for ship, said in found.items()
    }
