"""What an AIS message says of a ship, in SI units; the codes for "not available" are left out."""

import math
from typing import Any

import numpy as np

from glasshelm.ais.cleaning import FASTEST_KN, no_ship
from glasshelm.feeds.types import Refusal
from glasshelm.ships import KNOT_M_S

#: Message types that tell where a ship is, and those that tell who she is (19: both).
POSITION = frozenset((1, 2, 3, 18, 19, 27))
STATIC = frozenset((5, 19, 24))
#: Base stations, aircraft, aids to navigation.
NO_SHIP = frozenset((4, 9, 11, 21))
WANTED = POSITION | STATIC
#: Aircraft of search and rescue: 111MIDxxx.
_AIRCRAFT = range(111_000_000, 112_000_000)
#: A rate of turn [°/min] that only says "turning" or "not known".
_NO_RATE = frozenset((127.0, -127.0, 128.0, -128.0))

Said = dict[str, Any]


def ais_said(message: Any) -> Said | Refusal:
    """The fields of a Report that a decoded message gives, or why it is of no use.

    A message cut short has ``None`` where it ends.
    """
    mmsi = int(message.mmsi)
    if mmsi == 0 or mmsi in _AIRCRAFT or no_ship(np.array([mmsi])).any():
        return Refusal.NO_SHIP
    said: Said = {}
    if message.msg_type in POSITION:
        said |= _motion(message)
    if message.msg_type in STATIC:
        said |= _identity(message)
    said = {name: value for name, value in said.items() if value is not None}
    return {"id": str(mmsi)} | said if said else Refusal.NOTHING_TOLD


def _motion(message: Any) -> Said:
    latitude, longitude = message.lat, message.lon
    if latitude is None or longitude is None or abs(latitude) > 90 or abs(longitude) > 180:
        return {}
    speed, course = message.speed, message.course
    heading = getattr(message, "heading", None)
    turn = getattr(message, "turn", None)
    return {
        "latitude_deg": float(latitude),
        "longitude_deg": float(longitude),
        # 102.3 (type 27: 63) means "not available"; more than 60 no ship makes.
        "speed_m_s": None if speed is None or speed > FASTEST_KN else speed * KNOT_M_S,
        "course_rad": _angle(course),
        "heading_rad": _angle(heading),
        "rate_of_turn_rad_s": (
            None if turn is None or float(turn) in _NO_RATE else math.radians(float(turn) / 60)
        ),
    }


def _identity(message: Any) -> Said:
    kind = getattr(message, "ship_type", None)
    return {
        "name": (getattr(message, "shipname", None) or "").strip(" @") or None,
        "length_m": _size(message, "to_bow", "to_stern"),
        "beam_m": _size(message, "to_port", "to_starboard"),
        "kind": str(int(kind)) if kind else None,
    }


def _size(message: Any, one: str, other: str) -> float | None:
    total = (getattr(message, one, 0) or 0) + (getattr(message, other, 0) or 0)
    return float(total) or None


def _angle(degrees: Any) -> float | None:
    return math.radians(degrees) if degrees is not None and 0 <= degrees < 360 else None
