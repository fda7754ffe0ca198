"""What is known of one ship: her latest believable report, and whether the next one is.

The limits are those by which recorded traffic is cleaned (``ais/cleaning``), held
against one report at a time as it comes.
"""

import dataclasses
import math
from collections import deque
from collections.abc import Sequence

from glasshelm.ais.cleaning import (
    BASELINE_S,
    N_AGREEING,
    POSITION_ERROR_M,
    REPEAT_S,
    SHORT_WAY_M,
    STALE_S,
)
from glasshelm.ais.limits import MAX_SPEED_KN
from glasshelm.ais.reports import RejectReason, Report
from glasshelm.encounters.own_ship_candidates import UNDER_WAY_KN
from glasshelm.ship.nomoto import KNOT_M_S

#: No ship turns faster: the highest rate that an AIS report can tell, 708°/min ...
FASTEST_TURN_RAD_S = math.radians(708 / 60)
#: ... beyond the error of two courses. Below 3 kn a course is noise, and not looked at.
COURSE_ERROR_RAD = math.radians(40)
#: A speed or course belongs to a position that is at most this much older or younger [s].
TOGETHER_S = 60.0
#: Positions off the track of which one comes later than this [s] are no second track.
APART_S = 200.0
#: Names are cut to so many characters (AIS has 20).
LONGEST_NAME = 64

_EARTH_M = 6_371_000.0
_FASTEST_M_S = MAX_SPEED_KN * KNOT_M_S


@dataclasses.dataclass(frozen=True, slots=True)
class Fix:
    """A position at a time [s since 1970], with what was said of her motion there."""

    time_s: float
    latitude_deg: float
    longitude_deg: float
    course_rad: float | None = None
    speed_m_s: float | None = None


@dataclasses.dataclass(frozen=True, slots=True)
class Timed:
    """A number and when it was said [s since 1970]."""

    value: float
    time_s: float


@dataclasses.dataclass(frozen=True, slots=True)
class CourseSpeed:
    """Course and speed over ground. The course is None where nothing tells it."""

    course_rad: float | None
    speed_m_s: float


@dataclasses.dataclass(slots=True)
class Compared:
    """How a ship's positions lay to own ship's, each instant once (``echo``)."""

    time_s: float = -math.inf
    #: Positions in a row beside own ship, not beside her, and far from her.
    beside: int = 0
    away: int = 0
    far: int = 0
    #: When she was last seen to be another ship [s since 1970]; None: never, or outweighed.
    apart_s: float | None = None


class Vessel:
    """One ship, from her reports in the order in which they come. Bounded in memory."""

    def __init__(self, number: str, second_of: str | None = None):
        self.id = number
        #: The MMSI that another ship uses too, who was heard first.
        self.shares_id_of = second_of
        self.name: str | None = None
        self.length_m: float | None = None
        self.beam_m: float | None = None
        self.ship_type: str | None = None
        self.fix: Fix | None = None
        self.heading: Timed | None = None
        self.rate_of_turn: Timed | None = None
        self.rudder: Timed | None = None
        #: When anything at all was last heard of her [s since 1970].
        self.last_heard_s = -math.inf
        #: Where her positions were, compared with own ship's.
        self.compared = Compared()
        #: Where another ship is, with the same number, heard in turn with her.
        self.twin_fix: Fix | None = None
        self._course: Timed | None = None
        self._speed: Timed | None = None
        self._waiting: list[Fix] = []
        self._on_track = 0
        self._before: deque[Fix] = deque(maxlen=2)

    def update_static(self, r: Report, time_s: float) -> None:
        """Note who she is."""
        self.name = r.name[:LONGEST_NAME] if r.name else self.name
        self.ship_type = r.ship_type[:LONGEST_NAME] if r.ship_type else self.ship_type
        self.length_m = r.length_m or self.length_m
        self.beam_m = r.beam_m or self.beam_m
        self.last_heard_s = max(self.last_heard_s, time_s)

    def update(self, r: Report, time_s: float) -> RejectReason | None:
        """Note where she is and how she moves, or say why that is not believed."""
        if r.latitude_deg is not None and r.longitude_deg is not None:
            fix = Fix(time_s, r.latitude_deg, r.longitude_deg, r.course_rad, r.speed_m_s)
            refused = self._place(fix)
            if refused is not None:
                return refused
        self._course = _later(self._course, r.course_rad, time_s)
        self._speed = _later(self._speed, r.speed_m_s, time_s)
        self.heading = _later(self.heading, r.heading_rad, time_s)
        self.rate_of_turn = _later(self.rate_of_turn, r.rate_of_turn_rad_s, time_s)
        self.rudder = _later(self.rudder, r.rudder_rad, time_s)
        self.last_heard_s = max(self.last_heard_s, time_s)
        return None

    def merge(self, other: "Vessel") -> None:
        """Take over what is known of a ship that turned out to be this one."""
        self.name = self.name or other.name
        self.ship_type = self.ship_type or other.ship_type
        self.length_m = self.length_m or other.length_m
        self.beam_m = self.beam_m or other.beam_m
        if other.fix is not None and (self.fix is None or other.fix.time_s > self.fix.time_s):
            self.fix, self._course, self._speed = other.fix, other._course, other._speed
            self.heading, self.last_heard_s = (
                other.heading,
                max(self.last_heard_s, other.last_heard_s),
            )

    def course_speed(self) -> CourseSpeed | None:
        """Her motion at her latest position; None if nothing tells a speed.

        What is not said is taken from the positions; a course that these do not
        give is the last one said, or her heading, or not known.
        """
        fix = self.fix
        if fix is None:
            return None
        before = self._earlier(fix)
        east, north = (0.0, 0.0) if before is None else offset_m(before, fix)
        way = math.hypot(east, north)
        if before is not None and not _near(self._speed, fix):
            speed = way / (fix.time_s - before.time_s)
        elif self._speed is not None:
            speed = self._speed.value
        else:
            return None
        if way >= SHORT_WAY_M and not _near(self._course, fix):
            return CourseSpeed(math.atan2(east, north) % math.tau, speed)
        said = self._course or self.heading
        return CourseSpeed(None if said is None else said.value, speed)

    def _earlier(self, fix: Fix) -> Fix | None:
        """The latest position from which motion to ``fix`` can be taken."""
        for before in reversed(self._before):
            if BASELINE_S <= fix.time_s - before.time_s <= STALE_S:
                return before
        return None

    def clear_fields(self, names: Sequence[str]) -> None:
        """Note which values are not available any more.

        A speed or a course goes on, until positions tell another.
        """
        for name in names:
            match name:
                case "heading_rad":
                    self.heading = None
                case "rate_of_turn_rad_s":
                    self.rate_of_turn = None
                case "rudder_rad":
                    self.rudder = None
                case "course_rad" if self._course is not None:
                    self._course = Timed(self._course.value, -math.inf)
                case "speed_m_s" if self._speed is not None:
                    self._speed = Timed(self._speed.value, -math.inf)

    def _place(self, fix: Fix) -> RejectReason | None:
        """Move her to a new position if she can be there.

        A position or course that she cannot have reached waits; when ``AGREEING`` such
        reports of as many instants agree, they are believed; those of another ship if she
        is heard on her track in between.
        """
        last = self.fix
        if last is not None:
            if fix.time_s < last.time_s:
                return RejectReason.LATE
            if repeats(last, fix):
                return RejectReason.DUPLICATE
            if not follows(last, fix):
                refused = self._off_track(last, fix)
                if refused is not None:
                    return refused
            elif self._waiting:
                self._on_track += 1
                if fix.time_s - self._waiting[-1].time_s > APART_S:
                    self._waiting = []
        self.fix = fix
        if not self._before or fix.time_s - self._before[-1].time_s >= BASELINE_S:
            self._before.append(fix)
        return None

    def _off_track(self, last: Fix, fix: Fix) -> RejectReason | None:
        """A position that she cannot have reached: why it is refused; None if it is hers now."""
        waiting = self._waiting
        if waiting and (fix.time_s <= waiting[-1].time_s or repeats(waiting[-1], fix)):
            return RejectReason.JUMP  # said thrice at one instant is said once
        if waiting and not follows(waiting[-1], fix):
            waiting.clear()
        if not waiting:
            self._on_track = 0
        waiting.append(fix)
        if len(waiting) < N_AGREEING:
            return RejectReason.JUMP
        elsewhere = math.hypot(*offset_m(last, fix)) > POSITION_ERROR_M
        if self._on_track >= N_AGREEING - 1 and elsewhere:
            self.twin_fix = waiting.pop()
            return RejectReason.JUMP
        self._before.clear()
        self._waiting = []
        return None


def offset_m(a: Fix, b: Fix) -> tuple[float, float]:
    """East and north [m] from one position to another, near enough together to be a plane."""
    turn = (b.longitude_deg - a.longitude_deg + 180.0) % 360.0 - 180.0
    middle = math.radians(0.5 * (a.latitude_deg + b.latitude_deg))
    return (
        math.radians(turn) * math.cos(middle) * _EARTH_M,
        math.radians(b.latitude_deg - a.latitude_deg) * _EARTH_M,
    )


def follows(a: Fix, b: Fix) -> bool:
    """Whether a ship that was at ``a`` can be at ``b`` and on its course."""
    gap = abs(b.time_s - a.time_s)
    if math.hypot(*offset_m(a, b)) > _FASTEST_M_S * gap + POSITION_ERROR_M:
        return False
    if a.course_rad is None or b.course_rad is None:
        return True
    if min(a.speed_m_s or 0.0, b.speed_m_s or 0.0) < UNDER_WAY_KN * KNOT_M_S:
        return True
    turned = abs((b.course_rad - a.course_rad + math.pi) % math.tau - math.pi)
    return turned <= FASTEST_TURN_RAD_S * gap + COURSE_ERROR_RAD


def repeats(a: Fix, b: Fix) -> bool:
    """The same report again: at the same time, or with the same contents at once."""
    gap = b.time_s - a.time_s
    same = (a.latitude_deg, a.longitude_deg, a.speed_m_s) == (
        b.latitude_deg,
        b.longitude_deg,
        b.speed_m_s,
    )
    return gap == 0 or (gap < REPEAT_S and same)


def _near(value: Timed | None, fix: Fix) -> bool:
    return value is not None and abs(value.time_s - fix.time_s) <= TOGETHER_S


def _later(known: Timed | None, value: float | None, time_s: float) -> Timed | None:
    """The newer of two values."""
    if value is None or (known is not None and time_s < known.time_s):
        return known
    return Timed(value, time_s)
