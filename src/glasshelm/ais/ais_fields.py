"""The fields of an AIS message, in SI units; codes for "not available" are left out."""

import functools
import itertools
import math
from collections.abc import Mapping
from typing import Any

from pyais.messages import AISSentence

from glasshelm.ais.limits import is_angle_deg, is_size_m, is_speed_kn, is_vessel_mmsi
from glasshelm.ais.reports import RejectReason
from glasshelm.ship.nomoto import KNOT_M_S

#: Message types with a position, and those with static data (19: both).
POSITION_TYPES = frozenset((1, 2, 3, 18, 19, 27))
STATIC_TYPES = frozenset((5, 19, 24))
#: Base stations, aircraft, aids to navigation.
STATION_TYPES = frozenset((4, 9, 11, 21))
#: Rates of turn [°/min] that only say "turning" or "not available".
_NO_RATE = frozenset((127.0, -127.0, 128.0, -128.0))
_DYNAMIC = ("lat", "lon", "speed", "course", "heading", "turn")
_STATIC = ("shipname", "ship_type", "to_bow", "to_stern", "to_port", "to_starboard")
_USED = frozenset((*_DYNAMIC, *_STATIC))
#: The characters that carry six bits each.
_ARMOUR = frozenset(range(48, 88)) | frozenset(range(96, 120))

#: Values of a Report by its field names.
Fields = dict[str, Any]


def mmsi_of(sentence: AISSentence) -> int | None:
    """The number of the station that sent a message; None if the message is cut off before it."""
    return int(sentence.bv.get(8, 30)) if len(sentence.bv) >= 38 else None


def decode_fields(sentence: AISSentence) -> Fields | RejectReason:
    """The fields of a Report that a whole message gives, or why it is of no use.

    A field in which the message ends is not available.
    """
    mmsi = mmsi_of(sentence)
    if mmsi is None or not _ARMOUR.issuperset(sentence.payload):
        return RejectReason.UNDECODABLE
    if sentence.ais_id in STATION_TYPES or not is_vessel_mmsi(mmsi):
        return RejectReason.NO_SHIP
    if sentence.ais_id not in POSITION_TYPES | STATIC_TYPES:
        return RejectReason.UNUSED_KIND
    try:
        message = sentence.decode()
    except Exception:  # of a mangled payload pyais raises many kinds
        return RejectReason.UNDECODABLE
    ends = _field_ends(type(message))
    raw = {name: getattr(message, name) for name, end in ends if end <= len(sentence.bv)}
    fields: Fields = {}
    if sentence.ais_id in POSITION_TYPES:
        fields |= _dynamic_data(raw)
    if sentence.ais_id in STATIC_TYPES:
        fields |= _static_data(raw)
    fields = {name: value for name, value in fields.items() if value is not None}
    if fields:
        return {"id": str(mmsi)} | fields
    return RejectReason.EMPTY if len(raw) == len(ends) else RejectReason.UNDECODABLE


@functools.cache
def _field_ends(message_type: Any) -> tuple[tuple[str, int], ...]:
    """The used fields of a message type, and the bit before which each one ends."""
    fields = message_type.fields()
    ends = itertools.accumulate(field.metadata["width"] for field in fields)
    return tuple(
        (field.name, end) for field, end in zip(fields, ends, strict=True) if field.name in _USED
    )


def _dynamic_data(raw: Mapping[str, Any]) -> Fields:
    latitude, longitude = raw.get("lat"), raw.get("lon")
    if latitude is None or longitude is None or abs(latitude) > 90 or abs(longitude) > 180:
        return {}
    speed, turn = raw.get("speed"), raw.get("turn")
    return {
        "latitude_deg": float(latitude),
        "longitude_deg": float(longitude),
        "speed_m_s": speed * KNOT_M_S if speed is not None and is_speed_kn(speed) else None,
        "course_rad": _angle(raw.get("course")),
        "heading_rad": _angle(raw.get("heading")),
        "rate_of_turn_rad_s": (
            None if turn is None or float(turn) in _NO_RATE else math.radians(float(turn) / 60)
        ),
    }


def _static_data(raw: Mapping[str, Any]) -> Fields:
    ship_type = raw.get("ship_type")
    return {
        "name": (raw.get("shipname") or "").strip(" @") or None,
        "length_m": _size(raw.get("to_bow"), raw.get("to_stern")),
        "beam_m": _size(raw.get("to_port"), raw.get("to_starboard")),
        "ship_type": str(int(ship_type)) if ship_type else None,
    }


def _size(one: int | None, other: int | None) -> float | None:
    if one is None or other is None or not is_size_m(one + other):
        return None
    return float(one + other)


def _angle(degrees: float | int | None) -> float | None:
    return math.radians(degrees) if degrees is not None and is_angle_deg(degrees) else None
