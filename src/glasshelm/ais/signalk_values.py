"""What the values of a Signal K update say of a ship: paths, nested objects, and nulls.

A null means that a value is not available any more. Of a rate of turn, a rudder or a
heading, and of a route, that ends the earlier value; a position, a speed, a course, a name
or a size goes on as it was, and grows old.
"""

import dataclasses
import math
import re
from collections.abc import Callable, Iterable
from typing import Any

from glasshelm.ais.vessel import LONGEST_NAME

#: Nested objects are looked into so deep: the longest path that is used has four parts.
_DEEPEST = 5

Fields = dict[str, Any]


@dataclasses.dataclass(slots=True)
class Said:
    """What an update says, as the fields of a Report, and what it ends."""

    fields: Fields = dataclasses.field(default_factory=dict)
    mmsi: str | None = None
    ended: tuple[str, ...] = ()
    #: The part of the tree that tells a waypoint, and those that say there is none.
    route: str | None = None
    routes_ended: frozenset[str] = frozenset()
    used: bool = False
    bad: bool = False

    @property
    def moves(self) -> bool:
        """Whether anything is said of where she is and how she moves."""
        return any(name in self.fields for name in _MOVING)


def read_values(values: Iterable[tuple[str, Any]]) -> Said:
    """Read the paths and values of an update; one that cannot be read spoils no other."""
    said = Said()
    for path, value in values:
        _read(said, path, value, 0)
    return said


def _read(said: Said, path: str, value: Any, deep: int) -> None:
    if deep and path in _PATHS:
        value = _unwrapped(value)
    reader = _READERS.get(path)
    if path in _ROUTES:
        said.used = True
        try:
            _route(said, path, value)
        except _UNREADABLE:
            said.bad = True
    elif reader is not None:
        said.used = True
        try:
            _value(said, path, value, reader)
        except _UNREADABLE:
            said.bad = True
    elif isinstance(value, dict) and deep < _DEEPEST and _leads_on(path):
        for name, inner in value.items():
            _read(said, f"{path}.{name}" if path else str(name), inner, deep + 1)


def _value(said: Said, path: str, value: Any, reader: Callable[[Any], Fields]) -> None:
    if value is None:
        ended = _ENDED.get(path)
        if ended is not None:
            said.ended = (*said.ended, ended)
        return
    found = {name: one for name, one in reader(value).items() if one is not None}
    said.mmsi = found.pop("mmsi", None) or said.mmsi
    said.fields |= found


def _route(said: Said, path: str, value: Any) -> None:
    """The route's next point, or that there is none, in all the forms that servers use."""
    part = _ROUTES[path]
    if isinstance(value, dict) and not path.endswith((".nextPoint", ".position")):
        for name in ("nextPoint", "activeRoute"):  # the whole object of a course
            if name in value and f"{path}.{name}" in _ROUTES:
                _route(said, f"{path}.{name}", value[name])
        return
    if isinstance(value, dict) and path.endswith(".activeRoute"):
        return
    place = _unwrapped(value)
    place = _unwrapped(place.get("position", place)) if isinstance(place, dict) else place
    if isinstance(place, dict) and place.get("latitude", 0) is place.get("longitude", 0) is None:
        place = None
    if place is None:
        said.routes_ended |= {part}
    elif not isinstance(place, dict):
        raise ValueError(f"{place!r} is no place")
    elif "latitude" in place or "longitude" in place or place is not value:
        said.fields |= {f"waypoint_{name}": x for name, x in _position(place).items()}
        said.route = part


def _unwrapped(value: Any) -> Any:
    """A value as the whole tree of a ship has it: ``{"value": …}``."""
    return value["value"] if isinstance(value, dict) and "value" in value else value


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{value!r} is no number")
    return float(value)


def _as(name: str) -> Callable[[Any], Fields]:
    return lambda value: {name: _number(value)}


def _position(value: Any) -> Fields:
    return {
        "latitude_deg": _number(value["latitude"]),
        "longitude_deg": _number(value["longitude"]),
    }


def _length(value: Any) -> Fields:
    overall = value.get("overall") if isinstance(value, dict) else value
    return {"length_m": None if overall is None else _number(overall)}


def _kind(value: Any) -> Fields:
    return {"kind": str(int(_number(value["id"] if isinstance(value, dict) else value)))}


def _name(value: Any) -> Fields:
    return {"name": (value.strip()[:LONGEST_NAME] or None) if isinstance(value, str) else None}


def _mmsi(value: Any) -> Fields:
    """An MMSI, as text or as a number; what cannot be one is none."""
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        return {}
    found = _MMSI.fullmatch(str(value).strip())
    return {"mmsi": found[1] if found else None}


#: Zeros may stand before the number, and a point behind it, as tables write it.
_MMSI = re.compile(r"0{0,20}([1-9]\d{0,8})(?:\.0*)?", re.ASCII)
_UNREADABLE = (TypeError, ValueError, KeyError, AttributeError, OverflowError)
_MOVING = frozenset(
    (
        "latitude_deg",
        "course_rad",
        "speed_m_s",
        "heading_rad",
        "rate_of_turn_rad_s",
        "rudder_rad",
    )
)
_READERS: dict[str, Callable[[Any], Fields]] = {
    "name": _name,
    "mmsi": _mmsi,
    "navigation.position": _position,
    "navigation.speedOverGround": _as("speed_m_s"),
    "navigation.courseOverGroundTrue": _as("course_rad"),
    "navigation.headingTrue": _as("heading_rad"),
    "navigation.rateOfTurn": _as("rate_of_turn_rad_s"),
    "steering.rudderAngle": _as("rudder_rad"),
    "design.length": _length,
    "design.beam": _as("beam_m"),
    "design.aisShipType": _kind,
}
#: What a null ends.
_ENDED = {
    "navigation.speedOverGround": "speed_m_s",
    "navigation.courseOverGroundTrue": "course_rad",
    "navigation.headingTrue": "heading_rad",
    "navigation.rateOfTurn": "rate_of_turn_rad_s",
    "steering.rudderAngle": "rudder_rad",
}
#: Where a route is told, and the part of the tree that it belongs to.
_ROUTES = {
    f"navigation.{part}{rest}": part
    for part in ("course", "courseGreatCircle", "courseRhumbline")
    for rest in ("", ".nextPoint", ".nextPoint.position", ".activeRoute")
}
_PATHS = (*_READERS, *_ROUTES)


def _leads_on(path: str) -> bool:
    """Whether paths that are used begin with this one (the empty one: the ship herself)."""
    return not path or any(one.startswith(path + ".") for one in _PATHS)
