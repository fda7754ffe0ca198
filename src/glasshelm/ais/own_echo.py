"""Which of the received ships is own ship: by its numbers, or by its echo under an unknown one."""

import math

from glasshelm.ais.cleaning import N_AGREEING
from glasshelm.ais.limits import ECHO_M, FORGOTTEN_S
from glasshelm.ais.mmsi import is_number
from glasshelm.ais.vessel import CourseSpeed, Fix, Vessel, offset_between

#: So many positions near own ship, and not two in a row elsewhere, make an echo.
MIN_NEAR = 3
MIN_APART = 2
#: A ship that was once apart is an echo after so many positions near, over so long a time [s].
MIN_NEAR_AGAIN = 30
MIN_NEAR_AGAIN_S = 600.0
#: So far [m] from own ship it is another ship, whatever its number.
FAR_M = 1000.0
#: An own position older than this [s] is not compared with.
MAX_AGE_S = 30.0
#: Numbers of own ship that are remembered.
MAX_NUMBERS = 8


def compare_with_own(vessel: Vessel, own: Fix | None, motion: CourseSpeed | None) -> None:
    """Compare a ship's new position with where own ship was at that time."""
    fix, seen = vessel.fix, vessel.proximity
    if fix is None or own is None or motion is None or abs(fix.time_s - own.time_s) > MAX_AGE_S:
        return
    if fix.time_s <= seen.time_s:
        return
    seen.time_s = fix.time_s
    east, north = offset_between(own, fix)
    course = motion.course_rad
    run = 0.0 if course is None else motion.speed_m_s * (fix.time_s - own.time_s)
    course = course or 0.0
    distance = math.hypot(east - run * math.sin(course), north - run * math.cos(course))
    seen.n_far = seen.n_far + 1 if distance > FAR_M else 0
    if distance < ECHO_M:
        seen.n_near, seen.n_apart = seen.n_near + 1, 0
        near_s = 0.0 if seen.apart_s is None else fix.time_s - seen.apart_s
        if near_s >= MIN_NEAR_AGAIN_S and seen.n_near >= MIN_NEAR_AGAIN:
            seen.apart_s = None
    else:
        seen.n_apart += 1
        if seen.n_apart >= MIN_APART:
            seen.n_near, seen.apart_s = 0, fix.time_s


def is_echo(vessel: Vessel) -> bool:
    """Whether a ship's positions are own ship's; so is a ship that lies alongside."""
    return vessel.proximity.n_near >= MIN_NEAR and vessel.proximity.apart_s is None


class OwnIdentities:
    """The numbers under which own ship reports itself. Bounded; each may turn out wrong."""

    def __init__(self) -> None:
        #: How often each was received, and when last [s since 1970].
        self._numbers: dict[str, tuple[int, float]] = {}

    def add(self, number: str, time_s: float) -> None:
        """Note that own ship was received under a number."""
        count, last_s = self._numbers.get(number, (0, time_s))
        if not count and len(self._numbers) >= MAX_NUMBERS:
            del self._numbers[min(self._numbers, key=lambda one: self._numbers[one][0])]
        self._numbers[number] = (count + 1, max(last_s, time_s))

    def forget(self, now_s: float) -> None:
        """Drop the numbers not received for ``FORGOTTEN_S``."""
        self._numbers = {
            number: (count, last_s)
            for number, (count, last_s) in self._numbers.items()
            if now_s - last_s <= FORGOTTEN_S
        }

    @property
    def mmsi(self) -> str | None:
        """The MMSI that was received most often."""
        found = [number for number in self._numbers if is_number(number)]
        return max(found, key=lambda number: self._numbers[number][0], default=None)

    def is_own(self, vessel: Vessel) -> bool:
        """Whether a ship is own ship: under one of its numbers, and not far from it."""
        return vessel.id in self._numbers and vessel.proximity.n_far < N_AGREEING
