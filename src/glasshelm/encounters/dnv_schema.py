"""DNV's traffic-situation JSON as it is written: both layouts in use, every field optional.

The older layout gives each ship's ``initial`` position, speed and course and
``static.length``; the newer (schemaVersion 0.2.0) only waypoints with leg
speeds and ``static.dimensions``. Positions are ``lat``/``lon`` or
``latitude``/``longitude``. Degrees, knots and metres, as in the file.
"""

import dataclasses
from pathlib import Path
from typing import Annotated, TypeAlias

import msgspec

from glasshelm.ais.files import read_document
from glasshelm.core.errors import DECODE_ERRORS, InputError

Latitude: TypeAlias = Annotated[float, msgspec.Meta(ge=-90.0, le=90.0)]
Longitude: TypeAlias = Annotated[float, msgspec.Meta(ge=-180.0, le=180.0)]
Knots: TypeAlias = Annotated[float, msgspec.Meta(ge=0.0, le=102.3)]
Degrees: TypeAlias = Annotated[float, msgspec.Meta(ge=0.0, le=360.0)]

#: Keys of a situation that are known and not needed.
_IGNORED = frozenset({"description", "schemaVersion", "trafficgenVersion"})
#: JSON documents that are no situation, by keys that they have; what would be right.
_OTHER_DOCUMENTS: tuple[tuple[frozenset[str], str], ...] = (
    (frozenset({"encounters"}), "an input of the generator (encounters), not a situation: give "
     "what the generator makes of it"),
    (frozenset({"time_s", "own", "targets"}), "a log of frames, not a source: use glasshelm "
     "explain or whatif, or bridge --replay"),
    (frozenset({"type", "features"}), "GeoJSON, not a situation"),
    (frozenset({"type", "geometry"}), "GeoJSON, not a situation"),
    (frozenset({"type", "coordinates"}), "GeoJSON, not a situation"),
    (frozenset({"updates"}), "Signal K deltas, not a situation: use signalk://HOST"),
    (frozenset({"self", "version"}), "Signal K deltas, not a situation: use signalk://HOST"),
)  # fmt: skip


class _Part(msgspec.Struct, rename="camel"):
    """Unknown fields are ignored."""


class Position(_Part):
    lat: Latitude | None = None
    lon: Longitude | None = None
    latitude: Latitude | None = None
    longitude: Longitude | None = None

    def __post_init__(self) -> None:
        self.lat = self.latitude if self.lat is None else self.lat
        self.lon = self.longitude if self.lon is None else self.lon
        if self.lat is None or self.lon is None:
            raise ValueError(f"{'lat' if self.lat is None else 'lon'} is missing")

    @property
    def point(self) -> tuple[float, float]:
        """Latitude and longitude [deg]."""
        assert self.lat is not None
        assert self.lon is not None
        return self.lat, self.lon


class Value(_Part):
    value: Knots | None = None


class RouteData(_Part):
    sog: Value | None = None


class Leg(_Part):
    sog: Knots | None = None
    data: RouteData | None = None


class Waypoint(_Part):
    position: Position
    leg: Leg | None = None
    data: RouteData | None = None

    @property
    def leg_speed_kn(self) -> float | None:
        """The speed on the leg that begins here."""
        if self.leg is not None and self.leg.sog is not None:
            return self.leg.sog
        data = self.data or (self.leg.data if self.leg else None)
        return data.sog.value if data and data.sog else None


class Initial(_Part):
    position: Position | None = None
    sog: Knots | None = None
    cog: Degrees | None = None
    heading: Degrees | None = None


class Dimensions(_Part):
    length: float | None = None
    width: float | None = None
    a: float | None = None
    b: float | None = None
    c: float | None = None
    d: float | None = None


class Static(_Part):
    id: int | str | None = None
    mmsi: int | str | None = None
    name: str | None = None
    dimensions: Dimensions | None = None
    length: float | None = None
    width: float | None = None
    ship_type: str | int | None = None


class ShipEntry(_Part):
    static: Static | None = None
    initial: Initial | None = None
    waypoints: list[Waypoint] | None = None


class Situation(_Part):
    own_ship: ShipEntry
    target_ships: list[ShipEntry] | None = None
    target_ship: list[ShipEntry] | None = None
    title: str | None = None
    start_time: str | None = None


@dataclasses.dataclass(frozen=True)
class VoyagePlan:
    """What a ship of a situation intends, the same for both layouts: degrees and knots.

    ``points`` are (latitude, longitude), the start first; ``speeds_kn`` one a
    leg. A ship without waypoints has one point and holds ``course_deg``.
    """

    points: tuple[tuple[float, float], ...]
    speeds_kn: tuple[float, ...]
    course_deg: float | None
    heading_deg: float | None
    length_m: float | None
    beam_m: float | None
    name: str | None
    id: str | None
    ship_type: str | None


def read_situation_file(path: Path) -> tuple[Situation, tuple[str, ...]]:
    """The situation of a file, packed or not, in any encoding, and its keys that are not used.

    Raises:
        InputError: The file is missing, not JSON, not a situation, or of another layout.
    """
    data = read_document(path)
    try:
        keys = _top_level_keys(path, data)
        situation = msgspec.json.decode(data, type=Situation)
    except msgspec.ValidationError as error:
        raise InputError(f"{path}: not a DNV traffic situation: {error}") from None
    except RecursionError:
        raise InputError(f"{path}: not a DNV traffic situation: nested too deep") from None
    except DECODE_ERRORS as error:
        raise InputError(f"{path}: not JSON, or cut off ({error})") from None
    if situation.target_ships is None and situation.target_ship is None:
        raise InputError(
            f'{path}: no targetShips: a situation without any says so by "targetShips": []'
        )
    used = {field.encode_name for field in msgspec.structs.fields(Situation)} | _IGNORED
    return situation, tuple(key for key in keys if key not in used)


def _top_level_keys(path: Path, data: bytes) -> tuple[str, ...]:
    """The keys of a situation. InputError if the document is known to be something else."""
    decoder = msgspec.json.Decoder(dict[str, msgspec.Raw])
    try:
        keys = tuple(decoder.decode(data))
    except msgspec.ValidationError:
        raise
    except msgspec.DecodeError:  # perhaps JSON lines
        keys = tuple(decoder.decode(data.strip().partition(b"\n")[0]))
    what = next((text for wanted, text in _OTHER_DOCUMENTS if wanted <= frozenset(keys)), None)
    if what is not None:
        raise InputError(f"{path}: {what}")
    if "ownShip" not in keys:
        given = ", ".join(keys)[:80] or "nothing"
        raise InputError(f"{path}: not a DNV traffic situation: no ownShip in it, but {given}")
    return keys


def voyage_plan(ship: ShipEntry, where: str) -> VoyagePlan:
    """The plan of one ship of a situation.

    A waypoint's speed is that of the leg that begins there; a leg without one
    keeps the speed before it.

    Args:
        ship: The ship as the file has it.
        where: The file and the key of the ship, for messages.

    Raises:
        InputError: A field is missing or impossible; the message names it.
    """
    initial, static = ship.initial or Initial(), ship.static or Static()
    waypoints = ship.waypoints or []
    points = [waypoint.position.point for waypoint in waypoints]
    speeds = [waypoint.leg_speed_kn for waypoint in waypoints]
    if initial.position is not None:
        start = initial.position.point
        if not points or max(abs(a - b) for a, b in zip(start, points[0], strict=True)) > 1e-6:
            points.insert(0, start)
            speeds.insert(0, initial.sog)
    if not points:
        raise InputError(f"{where}.initial.position is missing, and there are no waypoints")
    speed = initial.sog if initial.sog is not None else next((s for s in speeds if s), None)
    if speed is None:
        raise InputError(f"{where}.initial.sog is missing, and no waypoint has leg.sog")
    legs = []
    for given in speeds[: max(len(points) - 1, 1)]:
        speed = speed if given is None else given
        legs.append(speed)
    course = initial.cog if initial.cog is not None else initial.heading
    if len(points) == 1 and course is None:
        raise InputError(f"{where}.initial.cog is missing, and there is no second waypoint")
    size = static.dimensions or Dimensions()
    number = static.mmsi if static.mmsi is not None else static.id
    return VoyagePlan(
        tuple(points),
        tuple(legs),
        course,
        initial.heading,
        _size(where, "length", (size.length, size.a, size.b, static.length), 1.0, 500.0),
        _size(where, "width", (size.width, size.c, size.d, static.width), 0.5, 100.0),
        static.name,
        None if number is None else str(number),
        None if static.ship_type is None else str(static.ship_type),
    )


def _size(
    where: str, name: str, given: tuple[float | None, ...], low: float, high: float
) -> float | None:
    """A length or width [m]: as such, as two distances from the antenna, or of the older layout."""
    whole, first, second, older = given
    both = None if first is None or second is None else first + second
    value = whole or both or older
    if value is not None and not low <= value <= high:
        raise InputError(f"{where}.static: {name} = {value} m: must be {low:g} to {high:g}")
    return value
