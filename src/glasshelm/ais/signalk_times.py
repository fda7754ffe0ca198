"""The timestamps of Signal K updates, also as servers write them that are not quite right."""

import math
import re
from datetime import UTC, datetime, timedelta, timezone
from typing import Any

from glasshelm.ais.limits import epoch_seconds
from glasshelm.ais.stream_clock import from_epoch

#: As RFC 3339 has it; numbers may lack their zeros, and a zone that is missing is UTC.
_FORM = re.compile(
    r"(\d{4})-(\d{1,2})-(\d{1,2})[Tt ](\d{1,2}):(\d{1,2}):(\d{1,2})(?:[.,](\d+))?"
    r"\s*(?:[Zz]|([+-])(\d{1,2}):?(\d{2})?)?",
    re.ASCII,
)
_NUMBER = re.compile(r"\d{1,20}(?:\.\d+)?", re.ASCII)


def time_of(stamp: Any) -> datetime | None:
    """The time (UTC) of a timestamp: text, or seconds since 1970; None if it is none."""
    if isinstance(stamp, int | float) and not isinstance(stamp, bool):
        stamp = str(stamp)
    if not isinstance(stamp, str):
        return None
    if _NUMBER.fullmatch(stamp.strip()):
        seconds = epoch_seconds(float(stamp))
        return None if math.isnan(seconds) else from_epoch(seconds)
    found = _FORM.fullmatch(stamp.strip())
    if found is None:
        return None
    *whole, fraction, sign, hours, minutes = found.groups()
    try:
        zone = timedelta(hours=int(hours or 0), minutes=int(minutes or 0))
        year, month, day, hour, minute, second = (int(part) for part in whole)
        offset = timezone(-zone if sign == "-" else zone)
        time = datetime(year, month, day, hour, minute, tzinfo=offset)
        if second > 60:
            return None
        # Added, so that a leap second is one.
        part = timedelta(seconds=second, microseconds=int((fraction or "").ljust(6, "0")[:6]))
        return (time + part).astimezone(UTC)
    except (ValueError, OverflowError):
        return None
