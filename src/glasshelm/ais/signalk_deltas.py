"""From Signal K messages to reports: hello, deltas, and everything else that comes. SI already."""

from datetime import UTC, datetime
from typing import Any

import msgspec

from glasshelm.ais.limits import is_vessel_mmsi
from glasshelm.ais.mmsi import is_number
from glasshelm.ais.reports import Counts, RejectReason, Report
from glasshelm.ais.signalk_times import time_of
from glasshelm.ais.signalk_values import read_values
from glasshelm.ais.stream_clock import StreamClock

#: The longest message [bytes or characters].
LONGEST_MESSAGE = 1 << 20
#: The longest context: a ship's URN has some 60 characters.
LONGEST_CONTEXT = 128
#: Ships whose MMSI was told beside their context, at most; the one learnt first is forgotten.
MOST_LEARNT = 10_000

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


class DeltaReader:
    """Reads the messages of one server, each counted once.

    Own ship is the ``self`` of the server's hello, or the vessel with the MMSI ``own``.
    One context is one ship, whatever its updates say; an MMSI that is given for a
    context without one is her number from then on.
    """

    def __init__(self, counts: Counts, own: str | None = None):
        self._counts, self._own = counts, own
        self._self = _VESSELS + "self"
        self._clock = StreamClock(live=True)
        #: The MMSI of contexts that have none in their name.
        self._learnt: dict[str, str] = {}
        #: The part of the tree that told own ship's waypoint: only its null ends the route.
        self._route: str | None = None

    def message(self, raw: str | bytes) -> list[Report]:
        """The reports of a message, one for each update that tells something."""
        self._counts.heard += 1
        found = self._message(raw)
        if isinstance(found, RejectReason):
            self._counts.refuse(found)
            return []
        self._counts.understood += 1
        return found

    def _message(self, raw: str | bytes) -> list[Report] | RejectReason:
        if len(raw) > LONGEST_MESSAGE:
            return RejectReason.TOO_LONG
        try:
            message = _DECODER.decode(raw)
        except msgspec.ValidationError:
            return RejectReason.UNDECODABLE
        except (msgspec.DecodeError, UnicodeError, RecursionError):
            return RejectReason.UNREADABLE
        if message.updates is None:
            if message.self is None:
                return RejectReason.UNUSED
            self._self = _full(message.self)
            return []
        context = self._self if message.context is None else message.context
        if context == _VESSELS + "self":
            context = self._self
        if not context.startswith(_VESSELS):
            return RejectReason.NO_SHIP
        if len(context) > LONGEST_CONTEXT:
            return RejectReason.UNDECODABLE
        reports: list[Report] = []
        refused: list[RejectReason] = []
        for update in message.updates:
            found = self._report(context, update)
            (refused if isinstance(found, RejectReason) else reports).append(found)  # pyright: ignore
        # Of several updates without any use, the message's reason is the first one's.
        return reports or (refused[0] if refused else RejectReason.NOTHING_TOLD)

    def _report(self, context: str, update: _Update) -> Report | RejectReason:
        """What one update says of the ship of a context."""
        said = read_values((one.path, one.value) for one in update.values)
        number, formerly = self._number(context, said.mmsi)
        if _no_ship(number) and formerly is None:
            return RejectReason.NO_SHIP
        own = context == self._self or number == self._own
        ended = self._route_ended(said.route, said.routes_ended) if own else False
        if not (said.fields or said.ended or ended or formerly):
            if said.bad:
                return RejectReason.UNDECODABLE
            return RejectReason.NOTHING_TOLD if said.used else RejectReason.UNUSED
        told = time_of(update.timestamp)
        if told is None and update.timestamp is not None:
            return RejectReason.UNDECODABLE
        if told is not None and said.moves:
            self._clock.tell(told, number)
        time = told or self._clock.now() or datetime.now(UTC)
        return Report(
            id=number,
            time=time,
            own=own,
            formerly=formerly,
            route_ended=ended,
            ended=said.ended,
            **said.fields,
        )

    def _number(self, context: str, told: str | None) -> tuple[str, str | None]:
        """Which ship a context is, and its id before its MMSI was known.

        The context's own MMSI is the ship's, whatever else is said.
        """
        name = context.removeprefix(_VESSELS)
        digits = name.removeprefix(_MMSI)
        if is_number(digits) and len(digits) < 20:
            return str(int(digits)), None
        learnt = self._learnt.get(context)
        if told is None or told == learnt:
            return learnt or name, None
        if learnt is None and len(self._learnt) >= MOST_LEARNT:
            del self._learnt[next(iter(self._learnt))]
        self._learnt[context] = told
        return told, learnt or name

    def _route_ended(self, told: str | None, ended: frozenset[str]) -> bool:
        """Whether own ship's route ended: said by the one that told it, which tells no other."""
        if told is not None:
            self._route = told
            return False
        if self._route is None or self._route not in ended:
            return False
        self._route = None
        return True


def _full(identity: str) -> str:
    return identity if identity.startswith(_VESSELS) else _VESSELS + identity


def _no_ship(number: str) -> bool:
    """Whether this is the number of a station that is no ship, or that none can have."""
    return is_number(number) and (len(number) > 9 or not is_vessel_mmsi(int(number)))
