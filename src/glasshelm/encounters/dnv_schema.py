"""DNV's traffic-situation JSON as it is written: both layouts in use, every field optional.

The older layout gives each ship's ``initial`` position, speed and course and
``static.length``; the newer (schemaVersion 0.2.0) only waypoints with leg
speeds and ``static.dimensions``. Positions are ``lat``/``lon`` or
``latitude``/``longitude``. Degrees, knots and metres, as in the file.
"""

import dataclasses
import math
from pathlib import Path

import msgspec

from glasshelm.ais.files import read_document
from glasshelm.core.errors import DECODE_ERRORS, InputError

SCHEMA_VERSION = "0.2.0"
#: DNV's own reader refuses a file that does not name the version of its generator.
TRAFFICGEN_VERSION = "0.8.5"


class _Part(msgspec.Struct, rename="camel", omit_defaults=True):
    """Unknown fields are passed over, fields left at ``None`` not written."""


class Position(_Part):
    lat: float | None = None
    lon: float | None = None
    latitude: float | None = None
    longitude: float | None = None


class Value(_Part):
    value: float | None = None


class RouteData(_Part):
    sog: Value | None = None


class Leg(_Part):
    sog: float | None = None
    data: RouteData | None = None


class Waypoint(_Part):
    position: Position
    leg: Leg | None = None
    data: RouteData | None = None


class Initial(_Part):
    position: Position | None = None
    sog: float | None = None
    cog: float | None = None
    heading: float | None = None
    nav_status: str | int | None = None


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


class Vessel(_Part):
    static: Static | None = None
    initial: Initial | None = None
    waypoints: list[Waypoint] | None = None


class Situation(_Part):
    own_ship: Vessel
    target_ships: list[Vessel] | None = None
    target_ship: list[Vessel] | None = None
    title: str | None = None
    description: str | None = None
    start_time: str | None = None
    schema_version: str | None = None
    trafficgen_version: str | None = None


@dataclasses.dataclass(frozen=True)
class Voyage:
    """What a vessel of a situation intends, layouts settled: degrees and knots.

    ``points`` are (latitude, longitude), the start first; ``speeds_kn`` one a
    leg. A vessel without a way to go has one point and sails on ``course_deg``.
    """

    points: tuple[tuple[float, float], ...]
    speeds_kn: tuple[float, ...]
    course_deg: float | None
    heading_deg: float | None
    length_m: float | None
    beam_m: float | None
    name: str | None
    id: str | None
    kind: str | None


def read_file(path: Path) -> tuple[Situation, tuple[str, ...]]:
    """The situation of a file, packed or not, in any encoding, and its keys that are not used.

    InputError if it is missing, not JSON, something else than a situation, or of another layout.
    """
    data = read_document(path)
    try:
        keys = _keys_of(path, data)
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
    used = {field.encode_name for field in msgspec.structs.fields(Situation)}
    return situation, tuple(key for key in keys if key not in used)


#: What JSON holds that is no situation, by keys that it has; what would be right.
_OTHERS: tuple[tuple[frozenset[str], str], ...] = (
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


def _keys_of(path: Path, data: bytes) -> tuple[str, ...]:
    """The keys of a situation; InputError, by name, if a document is something else."""
    first, _, more = data.strip().partition(b"\n")
    decoder = msgspec.json.Decoder(dict[str, msgspec.Raw])
    try:  # lines of JSON
        keys = tuple(decoder.decode(first if more.lstrip()[:1] == b"{" else data))
    except msgspec.ValidationError:
        raise
    except msgspec.DecodeError:
        keys = tuple(decoder.decode(data))
    what = next((text for wanted, text in _OTHERS if wanted <= frozenset(keys)), None)
    if what is not None:
        raise InputError(f"{path}: {what}")
    if "ownShip" not in keys:
        given = ", ".join(keys)[:80] or "nothing"
        raise InputError(f"{path}: not a DNV traffic situation: no ownShip in it, but {given}")
    return keys


def voyage(vessel: Vessel, where: str) -> Voyage:
    """The voyage of a vessel; InputError naming ``where`` and the field that is missing or wrong.

    A waypoint's speed is that of the leg that begins there; a leg without one
    keeps the speed before it.
    """
    initial = vessel.initial or Initial()
    waypoints = vessel.waypoints or []
    points = [_point(w.position, f"{where}.waypoints[{i}]") for i, w in enumerate(waypoints)]
    speeds = [_leg_speed(w) for w in waypoints]
    if initial.position is not None:
        start = _point(initial.position, f"{where}.initial")
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
        speed = _number(speed if given is None else given, f"{where}: sog [kn]", 0.0, 102.3)
        legs.append(speed)
    course = initial.cog if initial.cog is not None else initial.heading
    if len(points) == 1 and course is None:
        raise InputError(f"{where}.initial.cog is missing, and there is no second waypoint")
    static = vessel.static or Static()
    size = static.dimensions or Dimensions()
    length = size.length or _sum(size.a, size.b) or static.length
    beam = size.width or _sum(size.c, size.d) or static.width
    number = static.mmsi if static.mmsi is not None else static.id
    return Voyage(
        tuple(points),
        tuple(legs),
        None if course is None else _number(course, f"{where}.initial.cog", 0.0, 360.0),
        None
        if initial.heading is None
        else _number(initial.heading, f"{where}.initial.heading", 0.0, 360.0),
        None if length is None else _number(length, f"{where}.static: length [m]", 1.0, 500.0),
        None if beam is None else _number(beam, f"{where}.static: width [m]", 0.5, 100.0),
        static.name,
        None if number is None else str(number),
        None if static.ship_type is None else str(static.ship_type),
    )


def _leg_speed(waypoint: Waypoint) -> float | None:
    if waypoint.leg is not None and waypoint.leg.sog is not None:
        return waypoint.leg.sog
    data = waypoint.data or (waypoint.leg.data if waypoint.leg else None)
    return data.sog.value if data and data.sog else None


def _point(position: Position, where: str) -> tuple[float, float]:
    latitude = position.lat if position.lat is not None else position.latitude
    longitude = position.lon if position.lon is not None else position.longitude
    if latitude is None or longitude is None:
        lacks = "lat" if latitude is None else "lon"
        raise InputError(f"{where}.position.{lacks} is missing")
    return (
        _number(latitude, f"{where}.position.lat", -90.0, 90.0),
        _number(longitude, f"{where}.position.lon", -180.0, 180.0),
    )


def _number(value: float, where: str, low: float, high: float) -> float:
    if not (math.isfinite(value) and low <= value <= high):
        raise InputError(f"{where} = {value}: must be between {low:g} and {high:g}")
    return float(value)


def _sum(first: float | None, second: float | None) -> float | None:
    return None if first is None or second is None else first + second
