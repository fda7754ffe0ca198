"""Who is own ship among those heard: her numbers, and her echo under a number nobody told us."""

import math

from glasshelm.ais.cleaning import AGREEING
from glasshelm.ais.mmsi import is_number
from glasshelm.ais.vessel import Fix, Motion, Vessel, way_m
from glasshelm.encounters.recorded_traffic import ECHO_M

#: So many positions beside own ship, and not two in a row elsewhere, make an echo.
BESIDE = 3
APART = 2
#: A ship that was once apart is an echo after so many beside own ship, in so long a time [s].
LONG_BESIDE = 30
LONG_BESIDE_S = 600.0
#: So far [m] from own ship she is another, whoever's number she has.
FAR_M = 1000.0
#: An own position older than this [s] is not compared with.
FRESH_S = 30.0
#: A number of own ship that is not told for so long [s] is hers no more.
HERS_S = 780.0
#: Numbers under which own ship is known, at most.
MOST_NUMBERS = 8


def note(vessel: Vessel, own: Fix | None, motion: Motion | None) -> None:
    """Compare a ship's new position with where own ship was at that time."""
    fix, seen = vessel.fix, vessel.compared
    if fix is None or own is None or motion is None or abs(fix.time_s - own.time_s) > FRESH_S:
        return
    if fix.time_s <= seen.time_s:
        return
    seen.time_s = fix.time_s
    east, north = way_m(own, fix)
    course = motion.course_rad
    run = 0.0 if course is None else motion.speed_m_s * (fix.time_s - own.time_s)
    away = math.hypot(east - run * math.sin(course or 0.0), north - run * math.cos(course or 0.0))
    seen.far = seen.far + 1 if away > FAR_M else 0
    if away < ECHO_M:
        seen.beside, seen.away = seen.beside + 1, 0
        long = seen.apart_s is not None and fix.time_s - seen.apart_s >= LONG_BESIDE_S
        if long and seen.beside >= LONG_BESIDE:
            seen.apart_s = None
    else:
        seen.away += 1
        if seen.away >= APART:
            seen.beside, seen.apart_s = 0, fix.time_s


def is_echo(vessel: Vessel) -> bool:
    """Whether her positions are own ship's. A ship that lies alongside is taken for the echo."""
    return vessel.compared.beside >= BESIDE and vessel.compared.apart_s is None


class OwnNumbers:
    """The numbers under which own ship reports itself. Bounded; each may turn out wrong."""

    def __init__(self) -> None:
        self._told: dict[str, tuple[int, float]] = {}

    def tell(self, number: str, time_s: float) -> None:
        """Note that own ship reported under a number."""
        times, last_s = self._told.get(number, (0, time_s))
        if not times and len(self._told) >= MOST_NUMBERS:
            del self._told[min(self._told, key=lambda one: self._told[one][0])]
        self._told[number] = (times + 1, max(last_s, time_s))

    def forget(self, now_s: float) -> None:
        """Drop the numbers that were not told for ``HERS_S``."""
        old = [one for one, (_, last_s) in self._told.items() if now_s - last_s > HERS_S]
        for number in old:
            del self._told[number]

    @property
    def mmsi(self) -> str | None:
        """The most frequent MMSI."""
        found = [one for one in self._told if is_number(one)]
        return max(found, key=lambda one: self._told[one][0], default=None)

    def hide(self, vessel: Vessel) -> bool:
        """Whether she is own ship: under one of her numbers, and not far from her."""
        return vessel.id in self._told and vessel.compared.far < AGREEING
