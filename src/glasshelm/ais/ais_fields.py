"""What an AIS message says of a ship, in SI units; the codes for "not available" are left out."""

import functools
import itertools
import math
from collections.abc import Mapping
from typing import Any

from pyais.messages import AISSentence

from glasshelm.ais.limits import is_angle_deg, is_size_m, is_speed_kn, is_vessel_mmsi
from glasshelm.ais.reports import RejectReason
from glasshelm.ship.nomoto import KNOT_M_S

#: Message types that tell where a ship is, and those that tell who she is (19: both).
POSITION = frozenset((1, 2, 3, 18, 19, 27))
STATIC = frozenset((5, 19, 24))
#: Base stations, aircraft, aids to navigation.
NO_SHIP = frozenset((4, 9, 11, 21))
#: A rate of turn [°/min] that only says "turning" or "not known".
_NO_RATE = frozenset((127.0, -127.0, 128.0, -128.0))
#: The fields that are read.
_MOTION = ("lat", "lon", "speed", "course", "heading", "turn")
_WHO = ("shipname", "ship_type", "to_bow", "to_stern", "to_port", "to_starboard")
_USED = frozenset((*_MOTION, *_WHO))
#: The characters that carry six bits each.
_ARMOUR = frozenset(range(48, 88)) | frozenset(range(96, 120))

Said = dict[str, Any]


def mmsi_of(sentence: AISSentence) -> int | None:
    """The number of the station that a message is of; None if it is cut off before."""
    return int(sentence.bv.get(8, 30)) if len(sentence.bv) >= 38 else None


def ais_said(sentence: AISSentence) -> Said | RejectReason:
    """The fields of a Report that a whole message gives, or why it is of no use.

    A field in which the message ends is not told.
    """
    mmsi = mmsi_of(sentence)
    if mmsi is None or not _ARMOUR.issuperset(sentence.payload):
        return RejectReason.UNDECODABLE
    if sentence.ais_id in NO_SHIP or not is_vessel_mmsi(mmsi):
        return RejectReason.NO_SHIP
    if sentence.ais_id not in POSITION | STATIC:
        return RejectReason.UNUSED_KIND
    try:
        message = sentence.decode()
    except Exception:  # of a mangled payload pyais raises many kinds
        return RejectReason.UNDECODABLE
    ends = _ends(type(message))
    told = {name: getattr(message, name) for name, end in ends if end <= len(sentence.bv)}
    said: Said = {}
    if sentence.ais_id in POSITION:
        said |= _motion(told)
    if sentence.ais_id in STATIC:
        said |= _identity(told)
    said = {name: value for name, value in said.items() if value is not None}
    if said:
        return {"id": str(mmsi)} | said
    return RejectReason.EMPTY if len(told) == len(ends) else RejectReason.UNDECODABLE


@functools.cache
def _ends(kind: Any) -> tuple[tuple[str, int], ...]:
    """The used fields of a kind of message, and the bit before which each one ends."""
    fields = kind.fields()
    ends = itertools.accumulate(field.metadata["width"] for field in fields)
    return tuple(
        (field.name, end) for field, end in zip(fields, ends, strict=True) if field.name in _USED
    )


def _motion(told: Mapping[str, Any]) -> Said:
    latitude, longitude = told.get("lat"), told.get("lon")
    if latitude is None or longitude is None or abs(latitude) > 90 or abs(longitude) > 180:
        return {}
    speed, turn = told.get("speed"), told.get("turn")
    return {
        "latitude_deg": float(latitude),
        "longitude_deg": float(longitude),
        "speed_m_s": speed * KNOT_M_S if speed is not None and is_speed_kn(speed) else None,
        "course_rad": _angle(told.get("course")),
        "heading_rad": _angle(told.get("heading")),
        "rate_of_turn_rad_s": (
            None if turn is None or float(turn) in _NO_RATE else math.radians(float(turn) / 60)
        ),
    }


def _identity(told: Mapping[str, Any]) -> Said:
    kind = told.get("ship_type")
    return {
        "name": (told.get("shipname") or "").strip(" @") or None,
        "length_m": _size(told.get("to_bow"), told.get("to_stern")),
        "beam_m": _size(told.get("to_port"), told.get("to_starboard")),
        "ship_type": str(int(kind)) if kind else None,
    }


def _size(one: int | None, other: int | None) -> float | None:
    if one is None or other is None or not is_size_m(one + other):
        return None
    return float(one + other)


def _angle(degrees: float | int | None) -> float | None:
    return math.radians(degrees) if degrees is not None and is_angle_deg(degrees) else None
