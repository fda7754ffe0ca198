"""What every feed of live traffic gives: reports, and how much of what it heard became of use.

The rest of the room: ``source.feed_from`` makes a feed of a string, ``picture.Picture``
takes the reports and makes a scenario of them, ``write_back.WriteBack`` tells Signal K.
"""

from collections.abc import AsyncIterator, Callable
from datetime import datetime
from enum import StrEnum
from typing import Any, Protocol, runtime_checkable

import msgspec

from glasshelm.core.errors import InputError


class Report(msgspec.Struct, frozen=True, kw_only=True):
    """One thing heard of one ship. SI units, angles clockwise from true north, starboard positive.

    ``id`` is her MMSI or URN. ``time`` (UTC) is the time of the *stream*: for a
    recording played again it lies in the past. What the source does not say
    is ``None``: a report may hold identity alone (AIS types 5 and 24), or a heading
    alone (HDT). The waypoint is the next one of own ship's route; ``route_ended``: she
    has none any more. ``ended`` names the fields of her motion of which the source says
    that they are not available any more. ``own``: of own ship, from her AIVDO, her
    sensors or the Signal K server's self. ``formerly``: the id under which the same ship
    was reported before its MMSI was known.
    """

    id: str
    time: datetime
    formerly: str | None = None
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
    kind: str | None = None
    own: bool = False
    route_ended: bool = False
    ended: tuple[str, ...] = ()


class RejectReason(StrEnum):
    """Why something heard was of no use. A fixed set: no input can make it grow."""

    TOO_LONG = "longer than any sentence or message may be"
    UNREADABLE = "not of the form of a sentence or message"
    CHECKSUM = "with a wrong checksum"
    UNDECODABLE = "whose contents cannot be decoded"
    PART_MISSING = "part of a message whose other parts did not come"
    UNUSED = "of a kind that is not used"
    NO_TIME = "without a time, in a recording"
    NO_SHIP = "of a coast station, an aid to navigation or an aircraft"
    NOTHING_TOLD = "without any value"
    IMPOSSIBLE = "with impossible values"
    IMPOSSIBLE_TIME = "with a time that is none (before 1990 or after 2100)"
    LATE = "older than what was heard before"
    REPEATED = "a repeat of what was heard before"
    JUMP = "a jump in position or course"
    TIME_JUMP = "a jump in the time of the stream"
    FAR = "of ships farther off than those that are kept"
    OVERRUN = "come faster than they were read"


#: What every feed holds beside what is of use: no fault of it.
_USUAL = frozenset(
    (
        RejectReason.UNUSED,
        RejectReason.NO_SHIP,
        RejectReason.NOTHING_TOLD,
        RejectReason.LATE,
        RejectReason.REPEATED,
        RejectReason.FAR,
    )
)


class Counts:
    """How much was heard, understood and refused, by reason.

    A feed counts sentences (NMEA) or messages (Signal K); a picture counts reports: ``what``.
    ``heard`` is counted on arrival, the rest when it is decided, so that at any time
    ``heard == understood + sum(refused.values()) + waiting``; what waits are the
    parts of messages not yet complete, and none are left when a feed has ended.
    """

    def __init__(self, what: str = "sentences"):
        self.what = what
        self.heard = 0
        self.understood = 0
        self.refused: dict[RejectReason, int] = dict.fromkeys(RejectReason, 0)
        #: More about what is refused, for people: which clocks are wrong.
        self.remark: Callable[[], str | None] = lambda: None

    @property
    def waiting(self) -> int:
        """What is heard and not yet decided."""
        return self.heard - self.understood - sum(self.refused.values())

    @property
    def useless(self) -> bool:
        """Whether something was heard, and nothing of it became of use."""
        return self.heard > 0 and self.understood == 0

    @property
    def faulty(self) -> bool:
        """Whether something was refused that a sound feed does not hold."""
        return any(n for why, n in self.refused.items() if why not in _USUAL)

    def refuse(self, why: RejectReason, count: int = 1) -> None:
        """Count ``count`` of those heard as refused."""
        self.refused[why] += count

    def sentence(self) -> str:
        """For people: ``"heard 12 sentences: 9 used, 3 with a wrong checksum"``."""
        parts = [f"{self.understood} used", *(f"{n} {why}" for why, n in self._reasons())]
        remark = self.remark()
        said = f"heard {self.heard} {self.what}: {', '.join(parts)}"
        return f"{said}; {remark}" if remark else said

    def told(self) -> dict[str, Any]:
        """For programs: the same numbers."""
        refused = {str(why): count for why, count in self._reasons()}
        return {"heard": self.heard, "used": self.understood, "refused": refused}

    def _reasons(self) -> list[tuple[RejectReason, int]]:
        return [(why, count) for why, count in self.refused.items() if count]


class Begun:
    """A feed of a title that has heard nothing yet: what all feeds have before they run."""

    def __init__(self, title: str, counts: Counts | None = None):
        self.title = title
        self.counts = counts or Counts()
        self.connected = False
        self.trouble: str | None = None

    def ended(self, why: str) -> InputError:
        """To be raised where nothing can be heard at all; why stays its trouble."""
        self.trouble = why
        return InputError(why)


@runtime_checkable
class Feed(Protocol):
    """A source of reports.

    ``connected``: something is at the other end (for UDP: the port is open);
    ``trouble``: one line about why it is not, or was not the last time.
    ``reports`` runs until it is cancelled or closed (``aclose``), and connects again by
    itself, waiting longer each time; only a file comes to an end. A feed is run once.
    """

    title: str
    counts: Counts
    connected: bool
    trouble: str | None

    def reports(self) -> AsyncIterator[Report]:
        """The reports as they come. ``async for report in feed.reports(): ...``."""
        ...
