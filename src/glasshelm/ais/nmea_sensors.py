"""Own ship's sensors in NMEA 0183: what each sentence says of the motion, in SI units.

Fields as in IEC 61162-1. A sentence whose own status says "not valid" gives nothing.
"""

import math
from collections.abc import Callable, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any

from glasshelm.ais.timestamps import epoch_seconds
from glasshelm.ship.nomoto import KNOT_M_S

#: Values of a Report by its field names; and ``time``, the receiver's own (RMC).
Fields = dict[str, Any]
#: Sentence fields, from the first one after the sentence's name.
Texts = Sequence[str]

#: Modes of a position that is simulated, estimated or not valid.
_NO_MODES = ("N", "S", "E")


def parse_sensor_sentence(formatter: str, texts: Texts) -> Fields | None:
    """What a sentence says; None for a formatter (``RMC``) that is not used.

    Empty if no value is available.

    Raises:
        ValueError, IndexError, KeyError: The fields cannot be read.
    """
    parse = _PARSERS.get(formatter)
    if parse is None:
        return None
    return {name: value for name, value in parse(texts).items() if value is not None}


def _rmc(f: Texts) -> Fields:
    """time, status, lat, N/S, lon, E/W, speed [kn], course [°], date, …, mode"""
    if f[1] != "A" or (len(f) > 11 and f[11] in _NO_MODES):
        return {}
    return _position(f[2:6]) | {
        "speed_m_s": _scaled(f[6], KNOT_M_S),
        "course_rad": _angle(f[7]),
        "time": _date_time(f[8], f[0]),
    }


def _vtg(f: Texts) -> Fields:
    """course [°], T, magnetic, M, speed [kn], N, speed [km/h], K"""
    speed = _scaled(f[4], KNOT_M_S)
    return {
        "course_rad": _angle(f[0]),
        "speed_m_s": _scaled(f[6], 1 / 3.6) if speed is None and len(f) > 6 else speed,
    }


def _hdg(f: Texts) -> Fields:
    """compass heading [°], deviation [°], E/W, variation [°], E/W; true only with the latter"""
    heading, variation = _scaled(f[0], 1.0), _scaled(f[3], 1.0)
    if heading is None or variation is None:
        return {}
    east = {"E": 1, "W": -1}
    deviation = (_scaled(f[1], 1.0) or 0.0) * east.get(f[2], 0)
    return {"heading_rad": math.radians((heading + deviation + variation * east[f[4]]) % 360.0)}


def _rmb(f: Texts) -> Fields:
    """status, off track [NM], side, from, to, lat, N/S, lon, E/W of the next waypoint, …, mode"""
    if len(f) > 13 and f[13] in _NO_MODES:
        return {}
    waypoint = _position(f[5:9]) if f[0] == "A" else {}
    if not waypoint:  # a receiver without a route goes on sending the sentence
        return {"route_ended": True}
    return {f"waypoint_{name}": value for name, value in waypoint.items()}


def _heading(f: Texts) -> Fields:
    return {"heading_rad": _angle(f[0])}


_PARSERS: dict[str, Callable[[Texts], Fields]] = {
    # lat, N/S, lon, E/W, time, status
    "GLL": lambda f: _position(f[0:4]) if f[5] == "A" else {},
    # time, lat, N/S, lon, E/W, quality
    "GGA": lambda f: {} if f[5] in ("", "0", "6", "7", "8") else _position(f[1:5]),
    "RMC": _rmc,
    "VTG": _vtg,
    # heading [°], T
    "HDT": _heading,
    # heading [°], mode (A: autonomous)
    "THS": lambda f: _heading(f) if f[1] == "A" else {},
    "HDG": _hdg,
    # rate of turn [°/min, + starboard], status
    "ROT": lambda f: (
        {"rate_of_turn_rad_s": _scaled(f[0], math.pi / 180 / 60)} if f[1] == "A" else {}
    ),
    # starboard or single rudder [°, + starboard], status, port rudder, status
    "RSA": lambda f: {"rudder_rad": _scaled(f[0], math.pi / 180)} if f[1] == "A" else {},
    "RMB": _rmb,
}


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text}: no number")
    return value


def _scaled(text: str, unit: float) -> float | None:
    return _number(text) * unit if text else None


def _angle(text: str) -> float | None:
    return math.radians(_number(text) % 360.0) if text else None


def _position(f: Texts) -> Fields:
    if not f[0] or not f[2]:
        return {}
    if not (_whole_digits(f[0]) > 2 or _whole_digits(f[2]) > 3):
        # Without leading zeros minutes alone and degrees look alike: never a wrong position.
        raise ValueError(f"{f[0]}, {f[2]}: degrees, or minutes?")
    latitude = _degrees(f[0]) * {"N": 1, "S": -1}[f[1]]
    longitude = _degrees(f[2]) * {"E": 1, "W": -1}[f[3]]
    if abs(latitude) > 90 or abs(longitude) > 180:
        raise ValueError(f"{latitude}, {longitude}: not on the globe")
    return {"latitude_deg": latitude, "longitude_deg": longitude}


def _whole_digits(text: str) -> int:
    """How many digits stand before the point."""
    digits = text.partition(".")[0]
    if not (digits.isascii() and digits.isdigit()):
        raise ValueError(f"{text}: no degrees and minutes")
    return len(digits)


def _degrees(text: str) -> float:
    """``ddmm.mm`` or ``dddmm.mm`` in degrees: the minutes are the two digits before the point,
    whether or not zeros stand before them."""
    split = max(_whole_digits(text) - 2, 0)
    minutes = _number(text[split:])
    if not 0 <= minutes < 60:
        raise ValueError(f"{text}: no minutes")
    return int(text[:split] or 0) + minutes / 60


def _date_time(date: str, time: str) -> datetime | None:
    """``ddmmyy`` and ``hhmmss.ss``; the years 80 to 99 are of the last century.

    None for the date of a receiver without a fix: the position may be right all the same.
    """
    if not date or not time:
        return None
    whole, _, fraction = time.partition(".")
    hour, minute, second = _pairs(whole)
    day, month, year = _pairs(date)
    century = 1900 if year >= 80 else 2000
    instant = datetime(century + year, month, day, hour, minute, min(second, 59), tzinfo=UTC)
    instant += timedelta(seconds=max(second - 59, 0) + _number(f"0.{fraction or 0}"))
    return None if math.isnan(epoch_seconds(instant.timestamp())) else instant


def _pairs(text: str) -> tuple[int, int, int]:
    """Three numbers of two digits each; some receivers leave the first zero out."""
    if not (text.isascii() and text.isdigit() and 5 <= len(text) <= 6):
        raise ValueError(f"{text}: not three times two digits")
    text = text.zfill(6)
    return int(text[:2]), int(text[2:4]), int(text[4:])
