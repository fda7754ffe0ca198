"""What every live feed gives: reports, and statistics of what it received."""

from collections.abc import AsyncIterator, Callable
from datetime import datetime
from enum import StrEnum
from typing import Any

import msgspec

from glasshelm.core.errors import InputError


class Report(msgspec.Struct, frozen=True, kw_only=True):
    """What one message says of one ship. SI units; angles clockwise from true north, starboard +.

    A value that the source does not give is None: a report may hold static data alone
    (AIS types 5 and 24), or a heading alone (HDT).

    Attributes:
        id: MMSI or URN of the ship.
        time: Time of the *stream* (UTC): of a recording that is played again it lies in the past.
        previous_id: The id under which the same ship was reported before its MMSI was known.
        waypoint_latitude_deg: Next waypoint of own ship's route, with ``waypoint_longitude_deg``.
        is_own: From own ship: its AIVDO, its sensors or the Signal K server's self.
        route_ended: Own ship no longer follows a route.
        cleared: Fields of the motion that the source says are no longer available.
    """

    id: str
    time: datetime
    previous_id: str | None = None
    latitude_deg: float | None = None
    longitude_deg: float | None = None
    course_rad: float | None = None
    speed_m_s: float | None = None
    heading_rad: float | None = None
    rate_of_turn_rad_s: float | None = None
    rudder_rad: float | None = None
    waypoint_latitude_deg: float | None = None
    waypoint_longitude_deg: float | None = None
    name: str | None = None
    length_m: float | None = None
    beam_m: float | None = None
    ship_type: str | None = None
    is_own: bool = False
    route_ended: bool = False
    cleared: tuple[str, ...] = ()


#: The fields of a Report that are sensor values of the motion.
MOTION_FIELDS = ("course_rad", "speed_m_s", "heading_rad", "rate_of_turn_rad_s", "rudder_rad")


class RejectReason(StrEnum):
    """Why a message was of no use. A fixed set: no input can make it grow."""

    TOO_LONG = "longer than any sentence or message may be"
    MALFORMED = "not of the form of a sentence or message"
    CHECKSUM = "with a wrong checksum"
    UNDECODABLE = "whose contents cannot be decoded"
    INCOMPLETE = "part of a message whose other parts did not come"
    UNUSED_KIND = "of a kind that is not used"
    NO_TIME = "without a time, in a recording"
    NO_SHIP = "of a coast station, an aid to navigation or an aircraft"
    EMPTY = "without any value"
    IMPLAUSIBLE = "with impossible values"
    INVALID_TIME = "with a time that is none (before 1990 or after 2100)"
    LATE = "older than what was heard before"
    DUPLICATE = "a repeat of what was heard before"
    JUMP = "a jump in position or course"
    TIME_JUMP = "a jump in the time of the stream"
    TOO_FAR = "of ships farther off than those that are kept"
    OVERRUN = "come faster than they were read"


#: What every sound feed holds beside what is of use.
_USUAL = frozenset(
    (
        RejectReason.UNUSED_KIND,
        RejectReason.NO_SHIP,
        RejectReason.EMPTY,
        RejectReason.LATE,
        RejectReason.DUPLICATE,
        RejectReason.TOO_FAR,
    )
)


class Counts:
    """How many messages were received, accepted and rejected, by reason.

    A feed counts sentences (NMEA) or messages (Signal K), a picture counts reports: ``unit``.
    At any time ``received == accepted + sum(rejected.values()) + pending``; pending are the
    parts of messages not yet complete, and none are left when a feed has ended.
    """

    def __init__(self, unit: str = "sentences"):
        self.unit = unit
        self.received = 0
        self.accepted = 0
        self.rejected: dict[RejectReason, int] = dict.fromkeys(RejectReason, 0)
        #: More about what is rejected, for people: which clocks are wrong.
        self.remark: Callable[[], str | None] = lambda: None

    @property
    def pending(self) -> int:
        """How many messages are received and not yet accepted or rejected."""
        return self.received - self.accepted - sum(self.rejected.values())

    @property
    def all_rejected(self) -> bool:
        """Whether something was received, and nothing of it accepted."""
        return self.received > 0 and self.accepted == 0

    @property
    def has_faults(self) -> bool:
        """Whether something was rejected that a sound feed does not hold."""
        return any(n for reason, n in self.rejected.items() if reason not in _USUAL)

    def reject(self, reason: RejectReason, count: int = 1) -> None:
        """Count ``count`` of the received messages as rejected."""
        self.rejected[reason] += count

    @property
    def reasons(self) -> dict[RejectReason, int]:
        """Why messages were rejected, and how many; reasons that did not occur are left out."""
        return {reason: count for reason, count in self.rejected.items() if count}

    def summary(self) -> str:
        """For people: ``"heard 12 sentences: 9 used, 3 with a wrong checksum"``."""
        parts = [f"{self.accepted} used", *(f"{n} {reason}" for reason, n in self.reasons.items())]
        text = f"heard {self.received} {self.unit}: {', '.join(parts)}"
        remark = self.remark()
        return f"{text}; {remark}" if remark else text

    def as_dict(self) -> dict[str, Any]:
        """For programs: the same numbers."""
        rejected = {str(reason): count for reason, count in self.reasons.items()}
        return {"heard": self.received, "used": self.accepted, "refused": rejected}


class Feed:
    """A source of reports; it runs once.

    Attributes:
        title: What the feed is, for people.
        counts: What it received.
        connected: Something is at the other end (UDP: the port is open).
        last_error: One line about why it is not connected, or was not the last time.
    """

    def __init__(self, title: str, counts: Counts | None = None):
        self.title = title
        self.counts = counts or Counts()
        self.connected = False
        self.last_error: str | None = None

    def reports(self) -> AsyncIterator[Report]:
        """The reports as they come, until the iterator is cancelled or closed (``aclose``).

        A lost connection is made again, after a wait that grows each time; only a file ends.
        """
        raise NotImplementedError

    def fatal_error(self, message: str) -> InputError:
        """The error to raise where nothing can be received at all; it stays ``last_error``."""
        self.last_error = message
        return InputError(message)
