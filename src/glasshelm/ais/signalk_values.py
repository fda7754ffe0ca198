"""What the values of a Signal K update say of a ship: paths, nested objects, and nulls.

A null means that a value is no longer available. A rate of turn, a rudder angle, a
heading or a route ends with it; a position, a speed, a course, a name
or a size stays as it was, and grows old.
"""

import dataclasses
import math
import re
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from glasshelm.ais.reports import MOTION_FIELDS
from glasshelm.ais.table import MAX_NAME_LENGTH

#: Nested objects are searched so deep: the longest path that is used has four parts.
_MAX_DEPTH = 5

#: Values of a Report by its field names.
Fields = dict[str, Any]


@dataclasses.dataclass(slots=True)
class ParsedUpdate:
    """What an update says, as the fields of a Report, and what it ends."""

    fields: Fields = dataclasses.field(default_factory=dict)
    mmsi: str | None = None
    cleared: tuple[str, ...] = ()
    #: The branch of the tree that gives a waypoint, and those that say there is none.
    route: str | None = None
    ended_routes: frozenset[str] = frozenset()
    #: Whether any path is used, and whether the value of one cannot be read.
    used: bool = False
    bad: bool = False

    @property
    def has_motion(self) -> bool:
        """Whether anything is said of the ship's position or motion."""
        return not {"latitude_deg", *MOTION_FIELDS}.isdisjoint(self.fields)

    def add_value(self, path: str, value: Any) -> None:
        """Take the value of a path."""
        if value is None:
            if path in _CLEARED:
                self.cleared = (*self.cleared, _CLEARED[path])
            return
        fields = {name: x for name, x in _READERS[path](value).items() if x is not None}
        self.mmsi = fields.pop("mmsi", None) or self.mmsi
        self.fields |= fields

    def add_route(self, path: str, value: Any) -> None:
        """Take the route's next point, or that there is none, in all forms that servers use."""
        if isinstance(value, dict) and path.endswith(".activeRoute"):
            return
        point = _unwrapped(value)
        point = _unwrapped(point.get("position", point)) if isinstance(point, dict) else point
        if (
            isinstance(point, dict)
            and point.get("latitude", 0) is point.get("longitude", 0) is None
        ):
            point = None
        if point is None:
            self.ended_routes |= {_ROUTES[path]}
        elif not isinstance(point, dict):
            raise ValueError(f"{point!r} is no position")
        elif "latitude" in point or "longitude" in point or point is not value:
            self.fields |= {f"waypoint_{name}": x for name, x in _position(point).items()}
            self.route = _ROUTES[path]


def parse_values(values: Iterable[tuple[str, Any]]) -> ParsedUpdate:
    """Read the paths and values of an update; one that cannot be read spoils no other."""
    update = ParsedUpdate()
    for path, value in values:
        for leaf, leaf_value in _leaves(path, value):
            update.used = True
            add = update.add_route if leaf in _ROUTES else update.add_value
            try:
                add(leaf, leaf_value)
            except _UNREADABLE:
                update.bad = True
    return update


def _leaves(path: str, value: Any, depth: int = 0) -> Iterator[tuple[str, Any]]:
    """The paths that are used at and below a path (the empty one: the ship), and their values."""
    if depth and path in _PATHS:
        value = _unwrapped(value)
    is_object = isinstance(value, dict)
    if path in _PATHS and not (is_object and path in _COURSES):
        yield path, value
    elif is_object and depth < _MAX_DEPTH and (not path or path in _PREFIXES):
        for name, inner in value.items():
            yield from _leaves(f"{path}.{name}" if path else str(name), inner, depth + 1)


def _unwrapped(value: Any) -> Any:
    """A value as the whole tree of a ship has it: ``{"value": …}``."""
    return value["value"] if isinstance(value, dict) and "value" in value else value


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{value!r} is no number")
    return float(value)


def _field(name: str) -> Callable[[Any], Fields]:
    return lambda value: {name: _number(value)}


def _position(value: Any) -> Fields:
    return {
        "latitude_deg": _number(value["latitude"]),
        "longitude_deg": _number(value["longitude"]),
    }


def _length(value: Any) -> Fields:
    overall = value.get("overall") if isinstance(value, dict) else value
    return {"length_m": None if overall is None else _number(overall)}


def _ship_type(value: Any) -> Fields:
    return {"ship_type": str(int(_number(value["id"] if isinstance(value, dict) else value)))}


def _name(value: Any) -> Fields:
    return {"name": (value.strip()[:MAX_NAME_LENGTH] or None) if isinstance(value, str) else None}


def _mmsi(value: Any) -> Fields:
    """An MMSI, as text or as a number; what cannot be one is ignored."""
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        return {}
    found = _MMSI.fullmatch(str(value).strip())
    return {"mmsi": found[1] if found else None}


#: Zeros may stand before the number, and a point behind it, as tables write it.
_MMSI = re.compile(r"0{0,20}([1-9]\d{0,8})(?:\.0*)?", re.ASCII)
_UNREADABLE = (TypeError, ValueError, KeyError, AttributeError, OverflowError)
#: Paths of one number, and their fields; a null ends the value.
_CLEARED = {
    "navigation.speedOverGround": "speed_m_s",
    "navigation.courseOverGroundTrue": "course_rad",
    "navigation.headingTrue": "heading_rad",
    "navigation.rateOfTurn": "rate_of_turn_rad_s",
    "steering.rudderAngle": "rudder_rad",
}
_READERS: dict[str, Callable[[Any], Fields]] = {
    "name": _name,
    "mmsi": _mmsi,
    "navigation.position": _position,
    "design.length": _length,
    "design.beam": _field("beam_m"),
    "design.aisShipType": _ship_type,
    **{path: _field(name) for path, name in _CLEARED.items()},
}
#: Where a route may be given, and the branch of the tree that each path belongs to.
_COURSES = tuple(f"navigation.course{kind}" for kind in ("", "GreatCircle", "Rhumbline"))
_ROUTES = {
    f"{branch}{rest}": branch
    for branch in _COURSES
    for rest in ("", ".nextPoint", ".nextPoint.position", ".activeRoute")
}
_PATHS = frozenset((*_READERS, *_ROUTES))
#: Paths that lead on to one that is used.
_PREFIXES = frozenset(
    path[:i] for path in _PATHS for i, character in enumerate(path) if character == "."
)
