"""What is known of one ship: its latest believable report, and whether the next one is.

The limits are those by which recorded traffic is cleaned (:mod:`glasshelm.ais.cleaning`), applied
to one report at a time as it comes.
"""

import dataclasses
import math
from collections import deque
from collections.abc import Sequence

from glasshelm.ais.cleaning import (
    DUPLICATE_S,
    MAX_BASELINE_S,
    MIN_BASELINE_S,
    MIN_DISTANCE_M,
    N_AGREEING,
    POSITION_ERROR_M,
)
from glasshelm.ais.geodesy import offset_m
from glasshelm.ais.limits import MAX_SPEED_KN, UNDER_WAY_KN
from glasshelm.ais.reports import MOTION_FIELDS, RejectReason, Report
from glasshelm.ais.table import StaticData
from glasshelm.ship.nomoto import KNOT_M_S

#: No ship turns faster: the highest rate of an AIS report, 708°/min ...
MAX_TURN_RAD_S = math.radians(708 / 60)
#: ... beyond the error of two courses. Below 3 kn courses are noise, and not compared.
COURSE_ERROR_RAD = math.radians(40)
#: A speed or course belongs to a position that is at most this much older or younger [s].
TOGETHER_S = 60.0
#: Positions off the track followed by one on it later than this [s] are no second track.
OFF_TRACK_S = 200.0
#: Below this speed [m/s] the course over ground is noise, and the heading is used.
DRIFTING_M_S = 0.5


@dataclasses.dataclass(frozen=True, slots=True)
class Fix:
    """A position at a time [s since 1970], with the motion reported there."""

    time_s: float
    latitude_deg: float
    longitude_deg: float
    course_rad: float | None = None
    speed_m_s: float | None = None


@dataclasses.dataclass(frozen=True, slots=True)
class Timed:
    """A number and when it was reported [s since 1970]."""

    value: float
    time_s: float


@dataclasses.dataclass(frozen=True, slots=True)
class CourseSpeed:
    """Course and speed over ground. The course is None where nothing tells it."""

    course_rad: float | None
    speed_m_s: float

    @property
    def lacks_course(self) -> bool:
        """Whether the ship makes way in a direction that is not known."""
        return self.course_rad is None and self.speed_m_s >= DRIFTING_M_S


@dataclasses.dataclass(slots=True)
class Proximity:
    """How near a ship's positions were to own ship's, each instant counted once."""

    time_s: float = -math.inf
    #: Positions in a row near own ship, not near it, and far from it.
    n_near: int = 0
    n_apart: int = 0
    n_far: int = 0
    #: When it last was surely another ship [s since 1970]; None: never, or outweighed.
    apart_s: float | None = None


class Vessel:
    """One ship, from its reports in the order in which they come. Bounded in memory."""

    def __init__(self, number: str, shares_id_of: str | None = None):
        self.id = number
        #: The MMSI that another ship uses too, which was received first.
        self.shares_id_of = shares_id_of
        self.static = StaticData()
        self.fix: Fix | None = None
        #: The latest value of each field of the motion (``reports.MOTION_FIELDS``).
        self.motion: dict[str, Timed] = {}
        #: When anything at all was last received [s since 1970].
        self.last_heard_s = -math.inf
        self.proximity = Proximity()
        #: Where another ship with the same number is, received in turn with this one.
        self.twin_fix: Fix | None = None
        self._waiting: list[Fix] = []
        self._n_on_track = 0
        self._earlier: deque[Fix] = deque(maxlen=2)

    def update_static(self, r: Report, time_s: float) -> None:
        """Take the static data of a report."""
        self.static = self.static.updated_by(StaticData.of(r))
        self.last_heard_s = max(self.last_heard_s, time_s)

    def update(self, r: Report, time_s: float) -> RejectReason | None:
        """Take position and motion of a report, or say why they are not believed."""
        if r.latitude_deg is not None and r.longitude_deg is not None:
            fix = Fix(time_s, r.latitude_deg, r.longitude_deg, r.course_rad, r.speed_m_s)
            rejected = self._move(fix)
            if rejected is not None:
                return rejected
        for name in MOTION_FIELDS:
            value, known = getattr(r, name), self.motion.get(name)
            if value is not None and (known is None or time_s >= known.time_s):
                self.motion[name] = Timed(value, time_s)
        self.last_heard_s = max(self.last_heard_s, time_s)
        return None

    def merge(self, other: "Vessel") -> None:
        """Take over what is known of a ship that turned out to be this one."""
        self.static = other.static.updated_by(self.static)
        if other.fix is not None and (self.fix is None or other.fix.time_s > self.fix.time_s):
            self.fix, self.motion = other.fix, other.motion
            self.last_heard_s = max(self.last_heard_s, other.last_heard_s)

    def course_speed(self) -> CourseSpeed | None:
        """The motion at the latest position; None if nothing tells a speed.

        What is not reported is derived from the positions; a course that these do not
        give is the last one reported, or the heading, or not known.
        """
        fix = self.fix
        if fix is None:
            return None
        before = next(
            (
                one
                for one in reversed(self._earlier)
                if MIN_BASELINE_S <= fix.time_s - one.time_s <= MAX_BASELINE_S
            ),
            None,
        )
        east, north = (0.0, 0.0) if before is None else offset_between(before, fix)
        distance = math.hypot(east, north)
        course, speed = self.motion.get("course_rad"), self.motion.get("speed_m_s")
        if before is not None and not _belongs_to(speed, fix):
            speed_m_s = distance / (fix.time_s - before.time_s)
        elif speed is not None:
            speed_m_s = speed.value
        else:
            return None
        if distance >= MIN_DISTANCE_M and not _belongs_to(course, fix):
            return CourseSpeed(math.atan2(east, north) % math.tau, speed_m_s)
        reported = course or self.motion.get("heading_rad")
        return CourseSpeed(None if reported is None else reported.value, speed_m_s)

    def clear_fields(self, names: Sequence[str]) -> None:
        """Note which values are no longer available.

        A speed or a course goes on, until positions tell another.
        """
        for name in names:
            value = self.motion.pop(name, None)
            if value is not None and name in ("course_rad", "speed_m_s"):
                self.motion[name] = Timed(value.value, -math.inf)

    def _move(self, fix: Fix) -> RejectReason | None:
        """Move the ship to a new position if it can be there.

        A position or course that it cannot have reached waits; when ``N_AGREEING`` such
        reports of as many instants agree, they are believed; they are another ship's if this
        one is received on its track in between.
        """
        last = self.fix
        if last is not None:
            if fix.time_s < last.time_s:
                return RejectReason.LATE
            if is_duplicate(last, fix):
                return RejectReason.DUPLICATE
            if not is_reachable(last, fix):
                rejected = self._off_track(last, fix)
                if rejected is not None:
                    return rejected
            elif self._waiting:
                self._n_on_track += 1
                if fix.time_s - self._waiting[-1].time_s > OFF_TRACK_S:
                    self._waiting = []
        self.fix = fix
        if not self._earlier or fix.time_s - self._earlier[-1].time_s >= MIN_BASELINE_S:
            self._earlier.append(fix)
        return None

    def _off_track(self, last: Fix, fix: Fix) -> RejectReason | None:
        """Why a position that the ship cannot have reached is rejected; None if it is believed."""
        waiting = self._waiting
        if waiting and (fix.time_s <= waiting[-1].time_s or is_duplicate(waiting[-1], fix)):
            return RejectReason.JUMP  # reported thrice at one instant is reported once
        if waiting and not is_reachable(waiting[-1], fix):
            waiting.clear()
        if not waiting:
            self._n_on_track = 0
        waiting.append(fix)
        if len(waiting) < N_AGREEING:
            return RejectReason.JUMP
        elsewhere = math.hypot(*offset_between(last, fix)) > POSITION_ERROR_M
        if self._n_on_track >= N_AGREEING - 1 and elsewhere:
            self.twin_fix = waiting.pop()
            return RejectReason.JUMP
        self._earlier.clear()
        self._waiting = []
        return None


def offset_between(a: Fix, b: Fix) -> tuple[float, float]:
    """East and north [m] from one position to another."""
    return offset_m(a.latitude_deg, a.longitude_deg, b.latitude_deg, b.longitude_deg)


def is_reachable(a: Fix, b: Fix) -> bool:
    """Whether a ship that was at ``a`` can be at ``b`` and on its course."""
    gap = abs(b.time_s - a.time_s)
    if math.hypot(*offset_between(a, b)) > MAX_SPEED_KN * KNOT_M_S * gap + POSITION_ERROR_M:
        return False
    if a.course_rad is None or b.course_rad is None:
        return True
    if min(a.speed_m_s or 0.0, b.speed_m_s or 0.0) < UNDER_WAY_KN * KNOT_M_S:
        return True
    turned = abs((b.course_rad - a.course_rad + math.pi) % math.tau - math.pi)
    return turned <= MAX_TURN_RAD_S * gap + COURSE_ERROR_RAD


def is_duplicate(a: Fix, b: Fix) -> bool:
    """The same report again: at the same time, or with the same contents soon after."""
    gap = b.time_s - a.time_s
    return gap == 0 or (gap < DUPLICATE_S and _content(a) == _content(b))


def _content(fix: Fix) -> tuple[float | None, ...]:
    return fix.latitude_deg, fix.longitude_deg, fix.speed_m_s


def _belongs_to(value: Timed | None, fix: Fix) -> bool:
    return value is not None and abs(value.time_s - fix.time_s) <= TOGETHER_S
