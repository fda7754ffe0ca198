"""From Signal K messages to reports: hello, deltas, and everything else that comes. SI already."""

import math
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any

import msgspec

from glasshelm.ais.limits import is_vessel_mmsi
from glasshelm.feeds.types import Counts, Refusal, Report

#: The longest message [bytes or characters].
LONGEST_MESSAGE = 1 << 20

_VESSELS = "vessels."
_MMSI = "urn:mrn:imo:mmsi:"

Said = dict[str, Any]


class _Value(msgspec.Struct):
    path: str
    value: Any = None


class _Update(msgspec.Struct):
    values: list[_Value] = []
    timestamp: str | None = None


class _Message(msgspec.Struct):
    context: str | None = None
    updates: list[_Update] | None = None
    self: str | None = None


_DECODER = msgspec.json.Decoder(_Message)


class DeltaReader:
    """Reads the messages of one connection, each counted once.

    Own ship is the ``self`` of the server's hello, or the vessel with the MMSI ``own``.
    """

    def __init__(self, counts: Counts, own: str | None = None):
        self._counts, self._own = counts, own
        self._self = _VESSELS + "self"

    def message(self, raw: str | bytes) -> list[Report]:
        """The reports of a message, one for each update that tells something."""
        self._counts.heard += 1
        found = self._message(raw)
        if isinstance(found, Refusal):
            self._counts.refuse(found)
            return []
        self._counts.understood += 1
        return found

    def _message(self, raw: str | bytes) -> list[Report] | Refusal:
        if len(raw) > LONGEST_MESSAGE:
            return Refusal.TOO_LONG
        try:
            message = _DECODER.decode(raw)
        except msgspec.ValidationError:
            return Refusal.UNDECODABLE
        except (msgspec.DecodeError, UnicodeError, RecursionError):
            return Refusal.UNREADABLE
        if message.updates is None:
            if message.self is None:
                return Refusal.UNUSED
            self._self = _full(message.self)
            return []
        context = self._self if message.context is None else message.context
        if not context.startswith(_VESSELS):
            return Refusal.NO_SHIP
        own = context in (self._self, _VESSELS + "self")
        number = (self._self if own else context).removeprefix(_VESSELS).removeprefix(_MMSI)
        if number.isascii() and number.isdigit() and _no_ship(number):
            return Refusal.NO_SHIP
        own = own or number == self._own
        reports: list[Report] = []
        refused: list[Refusal] = []
        for update in message.updates:
            found = _report(number, own, update)
            (refused if isinstance(found, Refusal) else reports).append(found)  # pyright: ignore
        # Of several updates without any use, the message's reason is the first one's.
        return reports or (refused[0] if refused else Refusal.NOTHING_TOLD)


def _report(number: str, own: bool, update: _Update) -> Report | Refusal:
    """What one update says. An update without a time is of now."""
    said, bad, used = {}, False, False
    for one in update.values:
        reader = _READERS.get(one.path)
        if reader is None:
            continue
        used = True
        if one.value is None:
            continue
        try:
            said |= {k: v for k, v in reader(one.value).items() if v is not None}
        except (TypeError, ValueError, KeyError, AttributeError, OverflowError):
            bad = True
    if not said:
        unsaid = Refusal.NOTHING_TOLD if used else Refusal.UNUSED
        return Refusal.UNDECODABLE if bad else unsaid
    try:
        time = _time(update.timestamp)
    except (ValueError, OverflowError):
        return Refusal.UNDECODABLE
    number = said.pop("mmsi", None) or number
    return Report(id=number, time=time, own=own, **said)


def _time(text: str | None) -> datetime:
    if text is None:
        return datetime.now(UTC)
    time = datetime.fromisoformat(text)
    return time.replace(tzinfo=UTC) if time.tzinfo is None else time.astimezone(UTC)


def _full(identity: str) -> str:
    return identity if identity.startswith(_VESSELS) else _VESSELS + identity


def _no_ship(number: str) -> bool:
    return len(number) > 9 or not is_vessel_mmsi(int(number))


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{value!r} is no number")
    return float(value)


def _as(name: str) -> Callable[[Any], Said]:
    return lambda value: {name: _number(value)}


def _position(value: Any) -> Said:
    return {
        "latitude_deg": _number(value["latitude"]),
        "longitude_deg": _number(value["longitude"]),
    }


def _waypoint(value: Any) -> Said:
    """The place of the route's next point; inside ``position`` in the newer form."""
    return {f"waypoint_{name}": x for name, x in _position(value.get("position", value)).items()}


def _length(value: Any) -> Said:
    overall = value.get("overall")
    return {"length_m": None if overall is None else _number(overall)}


def _kind(value: Any) -> Said:
    return {"kind": str(int(_number(value["id"])))}


def _root(value: Any) -> Said:
    """Values of the vessel herself: her name, her MMSI."""
    name, mmsi = value.get("name"), value.get("mmsi")
    said = {}
    if isinstance(name, str):
        said["name"] = name.strip() or None
    if isinstance(mmsi, str) and mmsi.isascii() and mmsi.isdigit() and len(mmsi) <= 9:
        said["mmsi"] = str(int(mmsi)) if int(mmsi) else None
    return said


_READERS: dict[str, Callable[[Any], Said]] = {
    "": _root,
    "navigation.position": _position,
    "navigation.speedOverGround": _as("speed_m_s"),
    "navigation.courseOverGroundTrue": _as("course_rad"),
    "navigation.headingTrue": _as("heading_rad"),
    "navigation.rateOfTurn": _as("rate_of_turn_rad_s"),
    "steering.rudderAngle": _as("rudder_rad"),
    "navigation.course.nextPoint": _waypoint,
    "navigation.courseGreatCircle.nextPoint.position": _waypoint,
    "navigation.courseRhumbline.nextPoint.position": _waypoint,
    "design.length": _length,
    "design.beam": _as("beam_m"),
    "design.aisShipType": _kind,
}
