"""From Signal K messages (hello, deltas) to reports. SI units already."""

from datetime import UTC, datetime
from typing import Any

import msgspec

from glasshelm.ais.limits import is_vessel_mmsi
from glasshelm.ais.mmsi import is_number
from glasshelm.ais.reports import Counts, RejectReason, Report
from glasshelm.ais.signalk_values import parse_values
from glasshelm.ais.timestamps import parse_time
from glasshelm.ais.traffic_time import StreamClock

#: The longest message [bytes or characters].
MAX_MESSAGE_BYTES = 1 << 20
#: The longest context: a ship's URN has some 60 characters.
MAX_CONTEXT_LENGTH = 128
#: Ships whose MMSI came beside their context; the one learnt first is forgotten.
MAX_LEARNT = 10_000

_VESSELS = "vessels."
_MMSI = "urn:mrn:imo:mmsi:"


class _Value(msgspec.Struct):
    path: str
    value: Any = None


class _Update(msgspec.Struct):
    values: list[_Value] = []
    timestamp: Any = None


class _Message(msgspec.Struct):
    context: str | None = None
    updates: list[_Update] | None = None
    self: str | None = None


_DECODER = msgspec.json.Decoder(_Message)


class DeltaDecoder:
    """Decodes the messages of one server, each counted once.

    Own ship is the ``self`` of the server's hello, or the vessel with ``own_mmsi``.
    One context is one ship, whatever its updates say of it; an MMSI that comes with a
    context without one is its number from then on.
    """

    def __init__(self, counts: Counts, own_mmsi: str | None = None):
        self._counts, self._own_mmsi = counts, own_mmsi
        self._self = _VESSELS + "self"
        self._clock = StreamClock(live=True)
        #: The MMSI of contexts that have none in their name.
        self._learnt: dict[str, str] = {}
        #: The branch of the tree that gave own ship's waypoint: only its null ends the route.
        self._route: str | None = None

    def decode(self, raw: str | bytes) -> list[Report]:
        """The reports of a message, one for each update that says something."""
        self._counts.received += 1
        result = self._decode(raw)
        if isinstance(result, RejectReason):
            self._counts.reject(result)
            return []
        self._counts.accepted += 1
        return result

    def _decode(self, raw: str | bytes) -> list[Report] | RejectReason:
        if len(raw) > MAX_MESSAGE_BYTES:
            return RejectReason.TOO_LONG
        try:
            message = _DECODER.decode(raw)
        except msgspec.ValidationError:
            return RejectReason.UNDECODABLE
        except (msgspec.DecodeError, UnicodeError, RecursionError):
            return RejectReason.MALFORMED
        if message.updates is None:
            if message.self is None:
                return RejectReason.UNUSED_KIND
            self._self = _VESSELS + message.self.removeprefix(_VESSELS)
            return []
        context = self._self if message.context is None else message.context
        if context == _VESSELS + "self":
            context = self._self
        if not context.startswith(_VESSELS):
            return RejectReason.NO_SHIP
        if len(context) > MAX_CONTEXT_LENGTH:
            return RejectReason.UNDECODABLE
        results = [self._report(context, update) for update in message.updates]
        reports = [result for result in results if isinstance(result, Report)]
        rejected = [result for result in results if isinstance(result, RejectReason)]
        # Of several updates without any use, the message's reason is the first one's.
        return reports or (rejected[0] if rejected else RejectReason.EMPTY)

    def _report(self, context: str, update: _Update) -> Report | RejectReason:
        """What one update says of the ship of a context."""
        parsed = parse_values((one.path, one.value) for one in update.values)
        number, previous_id = self._identify(context, parsed.mmsi)
        if _is_no_ship(number) and previous_id is None:
            return RejectReason.NO_SHIP
        is_own = context == self._self or number == self._own_mmsi
        route_ended = is_own and self._route_ended(parsed.route, parsed.ended_routes)
        if not (parsed.fields or parsed.cleared or route_ended or previous_id):
            if parsed.bad:
                return RejectReason.UNDECODABLE
            return RejectReason.EMPTY if parsed.used else RejectReason.UNUSED_KIND
        time = _parse_timestamp(update.timestamp)
        if time is None and update.timestamp is not None:
            return RejectReason.UNDECODABLE
        if time is not None and parsed.has_motion:
            self._clock.update(time, number)
        return Report(
            id=number,
            time=time or self._clock.now() or datetime.now(UTC),
            is_own=is_own,
            previous_id=previous_id,
            route_ended=route_ended,
            cleared=parsed.cleared,
            **parsed.fields,
        )

    def _identify(self, context: str, mmsi: str | None) -> tuple[str, str | None]:
        """The id of the ship of a context, and its id before its MMSI was known.

        The context's own MMSI comes first, whatever else is said.
        """
        name = context.removeprefix(_VESSELS)
        digits = name.removeprefix(_MMSI)
        if is_number(digits) and len(digits) < 20:
            return str(int(digits)), None
        learnt = self._learnt.get(context)
        if mmsi is None or mmsi == learnt:
            return learnt or name, None
        if learnt is None and len(self._learnt) >= MAX_LEARNT:
            del self._learnt[next(iter(self._learnt))]
        self._learnt[context] = mmsi
        return mmsi, learnt or name

    def _route_ended(self, route: str | None, ended_routes: frozenset[str]) -> bool:
        """Whether own ship's route ended: its own branch says so, and no other gives one."""
        if route is not None:
            self._route = route
            return False
        if self._route is None or self._route not in ended_routes:
            return False
        self._route = None
        return True


def _parse_timestamp(stamp: Any) -> datetime | None:
    """The time of an update: text, or a count since 1970; None if it is none."""
    if isinstance(stamp, bool) or not isinstance(stamp, str | int | float):
        return None
    return parse_time(str(stamp), any_year=True)


def _is_no_ship(number: str) -> bool:
    """Whether this is the number of a station that is no ship, or that none can have."""
    return is_number(number) and (len(number) > 9 or not is_vessel_mmsi(int(number)))
