"""From the columns of a published table to reports: what they are called, and what they hold.

Columns are found by name, in any order and case. Required: a time, an MMSI, latitude and longitude
(or a point as WKB). Optional: speed [kn], course, heading, name, type, length, beam, type of
station. Rows whose ``kind`` is ``own`` are own ship's sensors.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute

from glasshelm.ais.limits import is_mmsi, is_size_m
from glasshelm.ais.row_errors import RowErrors
from glasshelm.ais.table import NOT_A_SHIP, OWN_SENSORS, Recording, ReportTable, StaticData, Wanted
from glasshelm.ais.timestamps import epoch_seconds, parse_time

#: Its functions are made at import: type checkers do not know them.
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
REQUIRED = ("time", "mmsi", "latitude", "longitude")

TIME = "time {} is none from 1990 to 2100 (ISO 8601, dd/mm/yyyy hh:mm:ss, or seconds since 1970)"
MMSI_TEXT = "MMSI {} is no number"
MMSI_ROUNDED = "MMSI {} is rounded: its last digits are lost"
NO_NUMBER = "{} {} is no number"
MMSI_RANGE = "MMSI {} is none (1 to 999999999)"
NO_MMSI = "without MMSI"

_STATIONS = re.compile(r"basestation|aton|aidto|aidsto|sarairborne|aircraft|airborne")
_STATION_MESSAGES = (4, 9, 11, 21)
#: Texts that stand for a missing value.
NULL_TEXTS = ("", "nan", "NaN", "NAN", "null", "NULL", "None", "N/A", "n/a", "Unknown", "Undefined")

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$", re.ASCII)
#: A point as well-known binary, little-endian: order, type (1; with Z, M, SRID by EWKB or ISO).
_WKB_POINT = 21


def normalized(name: str) -> str:
    """A column name as :data:`COLUMN_NAMES` has it: ``# Timestamp (UTC)`` is ``timestamputc``."""
    return re.sub(r"[^a-z0-9]", "", name.lower())


def find_columns(header: Sequence[str]) -> dict[str, int]:
    """The index of each column that is used in a header; missing ones are left out."""
    given = [normalized(name) for name in header]
    return {
        column: given.index(name)
        for column, names in COLUMN_NAMES.items()
        if (name := next((name for name in names if name in given), None)) is not None
    }


def missing_column(found: Mapping[str, object], header: Sequence[str]) -> str | None:
    """What a header lacks, in words; None if every required column is there."""
    have = {*found, "latitude", "longitude"} if "point" in found else found
    lacking = next((column for column in REQUIRED if column not in have), None)
    if lacking is None:
        return None
    shown = ", ".join(name.strip() for name in header)[:200] or "none"
    return f"no {lacking} column (called {' or '.join(COLUMN_NAMES[lacking])}) among {shown}"


def to_recording(
    columns: Mapping[str, pa.Array],
    rows: np.ndarray,
    wanted: Wanted,
    errors: RowErrors,
    decimal_comma: bool = False,
) -> Recording:
    """The reports of a part of a table, and the static data of their ships.

    Args:
        columns: Arrow arrays of one length by the keys of :data:`COLUMN_NAMES`, texts or numbers.
        rows: The number of each row in the file.
        wanted: Which of the reports are kept.
        errors: Counts the rows that cannot be read.
        decimal_comma: Whether numbers may have a comma instead of a point.
    """

    def numbers(column: str) -> np.ndarray:
        if column not in columns:
            return np.full(len(rows), np.nan)
        return _numbers(columns[column], decimal_comma)

    time_s = _times(columns["time"])
    mmsi, identified = _identities(columns, numbers("mmsi"), rows, errors)
    no_time = identified & np.isnan(time_s)
    errors.add_mask(TIME, no_time, rows, columns["time"])
    readable = identified & ~no_time
    if "latitude" in columns and "longitude" in columns:
        latitude, longitude = numbers("latitude"), numbers("longitude")
        for column, values in (("latitude", latitude), ("longitude", longitude)):
            no_number = readable & np.isnan(values) & ~_is_null(columns[column])
            errors.add_mask(NO_NUMBER.format(column, "{}"), no_number, rows, columns[column])
            readable &= ~no_number
    else:
        latitude, longitude = _points(columns["point"])
    mmsi = np.where(readable, mmsi, NOT_A_SHIP).astype(np.int64)
    motion = (numbers(column) for column in ("sog", "cog", "heading"))
    reports = ReportTable(time_s, mmsi, latitude, longitude, *motion).take(readable)
    errors.rows += len(rows)
    errors.read += len(reports)
    kept = wanted(reports)
    reports = reports.take(kept)
    kept_rows = np.flatnonzero(readable)[kept]
    return Recording(reports, _static_data(reports.mmsi, columns, kept_rows, decimal_comma))


def _identities(
    columns: Mapping[str, pa.Array], given: np.ndarray, rows: np.ndarray, errors: RowErrors
) -> tuple[np.ndarray, np.ndarray]:
    """The number of the ship of each row, and whether it has one."""
    texts = columns["mmsi"]

    def matches(column: str, test: Callable[[str], bool]) -> np.ndarray:
        if column not in columns:
            return np.zeros(len(rows), bool)
        return _by_value(columns[column], lambda x: float(test(str(x).strip().lower()))) == 1.0

    own = matches("kind", lambda text: text == "own")
    empty = (_is_null(texts) | (given == 0)) & ~own
    no_number = np.isnan(given) & ~empty & ~own
    out = ~(is_mmsi(given) & (np.floor(given) == given)) & ~empty & ~no_number & ~own
    rounded = (
        matches("mmsi", _is_rounded) & ~(own | out)
        if _is_text(texts)
        else np.zeros(len(rows), bool)
    )
    errors.add_mask(NO_MMSI, empty, rows, None)
    errors.add_mask(MMSI_ROUNDED, rounded, rows, texts)
    errors.add_mask(MMSI_TEXT, no_number, rows, texts)
    errors.add_mask(MMSI_RANGE, out, rows, texts)
    station = matches("station", lambda text: bool(_STATIONS.search(normalized(text))))
    if "message" in columns:
        station |= np.isin(_numbers(columns["message"], False), _STATION_MESSAGES)
    identified = own | ~(empty | no_number | out | rounded)
    mmsi = np.select([own, station, identified], [OWN_SENSORS, NOT_A_SHIP, given], NOT_A_SHIP)
    return mmsi, identified


def _is_null(values: pa.Array) -> np.ndarray:
    return values.is_null(nan_is_null=True).to_numpy(zero_copy_only=False)


def _is_rounded(text: str) -> bool:
    """Whether a number has an exponent and at most the six digits of ``%g``: ``2.57E+08``."""
    mantissa, exponent, power = text.partition("e")
    decimals = len(mantissa.partition(".")[2])
    return bool(exponent and _NUMBER.match(text)) and decimals < min(int(power), 6)


def _by_value(values: pa.Array, to_number: Callable[[object], float]) -> np.ndarray:
    """A number for each value, found once for equal values; NaN for null."""
    coded = values.dictionary_encode()
    numbers = np.array([to_number(value) for value in coded.dictionary.to_pylist()] + [np.nan])
    return numbers[pc.fill_null(coded.indices, len(numbers) - 1).to_numpy(zero_copy_only=False)]


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
        times = _times(texts.cast(pa.timestamp("us")))
    except pa.ArrowInvalid:
        times = np.array([_time(text) for text in texts.to_pylist()], np.float64)
    codes = pc.fill_null(coded.indices, len(times)).to_numpy(zero_copy_only=False)
    return np.append(times, np.nan)[codes]


def _time(text: str) -> float:
    number = _number(text)
    if not np.isnan(number):
        return epoch_seconds(number)
    time = parse_time(text)
    return np.nan if time is None else time.timestamp()


def _points(values: pa.Array) -> tuple[np.ndarray, np.ndarray]:
    """Latitudes and longitudes of points in well-known binary; NaN where there is none."""
    points = np.full((len(values), 2), np.nan)
    for i, value in enumerate(values.to_pylist()):
        if isinstance(value, bytes) and len(value) >= _WKB_POINT and value[0] in (0, 1):
            order = "<" if value[0] == 1 else ">"
            kind = int(np.frombuffer(value, f"{order}u4", 1, 1)[0])
            start = 9 if kind & 0x2000_0000 else 5
            if (kind & 0xFFFF) % 1000 == 1 and len(value) >= start + 16:
                points[i] = np.frombuffer(value, f"{order}f8", 2, start)
    return points[:, 1], points[:, 0]


def _static_data(
    mmsi: np.ndarray, columns: Mapping[str, pa.Array], rows: np.ndarray, decimal_comma: bool
) -> dict[int, StaticData]:
    """The last static data of each ship; ``rows`` are the rows of ``mmsi``."""
    found: dict[int, dict[str, str]] = {ship: {} for ship in np.unique(mmsi).tolist()}
    for field in ("name", "length", "beam", "type"):
        if field not in columns or not len(rows):
            continue
        texts = columns[field].take(pa.array(rows)).cast(pa.string())
        given = np.flatnonzero(texts.is_valid().to_numpy(zero_copy_only=False))[::-1]
        ships, last = np.unique(mmsi[given], return_index=True)
        values = texts.take(pa.array(given[last])).to_pylist()
        for ship, text in zip(ships.tolist(), values, strict=True):
            found[ship][field] = text.strip()

    def size(text: str) -> float | None:
        value = _number(text.replace(",", ".") if decimal_comma else text)
        return value if is_size_m(value) else None

    return {
        ship: StaticData(
            data.get("name") or None,
            size(data.get("length", "")),
            size(data.get("beam", "")),
            data.get("type") or None,
        )
        for ship, data in found.items()
    }
