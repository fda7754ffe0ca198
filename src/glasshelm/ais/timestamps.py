"""Times as AIS sources write them: counts since 1970, ISO 8601 and what comes close to it."""

import math
import re
from datetime import UTC, datetime, timedelta, timezone

import numpy as np

from glasshelm.ais.limits import Numbers

#: Earlier times are those of clocks without a fix (1990-01-01), ...
MIN_TIME_S = 631_152_000.0
#: ... and later ones (2100-01-01) are wrong.
MAX_TIME_S = 4_102_444_800.0

#: A count below the first number has the second number of units to the second.
_UNITS = ((1e11, 1.0), (1e14, 1e3), (1e17, 1e6), (1e20, 1e9))
_NUMBER = re.compile(r"\d{1,20}(?:\.\d*)?", re.ASCII)
#: A date, year or day first, and a time of day; numbers may lack their zeros.
_DATE_TIME = re.compile(
    r"(?:(\d{4})-(\d{1,2})-(\d{1,2})|(\d{1,2})[/.-](\d{1,2})[/.-](\d{4}))"
    r"[Tt ](\d{1,2}):(\d{1,2})(?::(\d{1,2})(?:[.,](\d+))?)?"
    r"\s*(?:[Zz]|UTC|([+-])(\d{1,2}):?(\d{2})?)?",
    re.ASCII,
)
#: Shorter texts are dates alone.
_SHORTEST = len("2024-06-01T12")


def epoch_seconds(instant: Numbers) -> Numbers:
    """Seconds since 1970 of a number that counts seconds, milli-, micro- or nanoseconds.

    Their size gives the unit. NaN for what is no time between 1990 and 2100: a year,
    a count from another epoch, a clock that was never set.
    """
    seconds = np.full(np.shape(instant), np.nan)
    values = np.asarray(instant, np.float64)
    for limit, unit in reversed(_UNITS):
        seconds = np.where(np.abs(values) < limit, values / unit, seconds)
    seconds = np.where((seconds >= MIN_TIME_S) & (seconds <= MAX_TIME_S), seconds, np.nan)
    return seconds if np.ndim(instant) else float(seconds)


def parse_time(text: str, any_year: bool = False) -> datetime | None:
    """The time (UTC) of a text: a count since 1970, ISO 8601, or ``dd/mm/yyyy hh:mm:ss``.

    A zone that is missing is UTC. None if the text is no time or a date alone, and, unless
    ``any_year``, if it lies outside 1990 to 2100.
    """
    text = text.strip()
    if _NUMBER.fullmatch(text):
        return from_epoch(epoch_seconds(float(text)))
    if len(text) < _SHORTEST:
        return None
    try:
        time = _date_time(text)
    except (ValueError, OverflowError):
        return None
    return time if any_year or not math.isnan(epoch_seconds(time.timestamp())) else None


def _date_time(text: str) -> datetime:
    found = _DATE_TIME.fullmatch(text)
    if found is None:
        return as_utc(datetime.fromisoformat(text))
    *date, hour, minute, second, fraction, sign, zone_hours, zone_minutes = found.groups()
    year, month, day = date[:3] if date[0] else date[:2:-1]
    zone = timedelta(hours=int(zone_hours or 0), minutes=int(zone_minutes or 0))
    offset = timezone(-zone if sign == "-" else zone)
    time = datetime(int(year), int(month), int(day), int(hour), int(minute), tzinfo=offset)
    seconds = int(second or 0)
    if seconds > 60:
        raise ValueError(f"{text}: no second")
    # Added, so that a leap second is one.
    part = timedelta(seconds=seconds, microseconds=int((fraction or "").ljust(6, "0")[:6]))
    return (time + part).astimezone(UTC)


def as_utc(time: datetime) -> datetime:
    """A time in UTC; one without a zone is UTC already."""
    return time.replace(tzinfo=UTC) if time.tzinfo is None else time.astimezone(UTC)


def from_epoch(seconds: float) -> datetime | None:
    """The time (UTC) so many seconds since 1970; None for a number that is no date."""
    try:
        return datetime.fromtimestamp(seconds, UTC)
    except (ValueError, OverflowError, OSError):
        return None


def format_duration(seconds: float) -> str:
    """A duration for people: ``"12 h"``, ``"25 min"``, ``"3 days"``."""
    seconds = abs(seconds)
    for unit_s, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= (2 * unit_s if unit == "days" else unit_s):
            many = seconds / unit_s
            return f"{many:,.0f} {unit}" if many >= 100 else f"{round(many, 1):g} {unit}"
    return f"{seconds:.0f} s"
