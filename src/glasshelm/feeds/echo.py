"""Own ship's echo: AIS reports of herself, under a number that nobody told us."""

import math

from glasshelm.encounters.recorded import ECHO_M
from glasshelm.feeds.vessel import Fix, Motion, Vessel, way_m

#: So many positions beside own ship, and none elsewhere, make an echo, as in recorded traffic.
BESIDE = 3
#: An own position older than this [s] is not compared with.
FRESH_S = 30.0


def note(vessel: Vessel, own: Fix | None, motion: Motion | None) -> None:
    """Compare a ship's new position with where own ship was at that time."""
    fix = vessel.fix
    if fix is None or own is None or motion is None or abs(fix.time_s - own.time_s) > FRESH_S:
        return
    east, north = way_m(own, fix)
    course = motion.course_rad
    run = 0.0 if course is None else motion.speed_m_s * (fix.time_s - own.time_s)
    away = math.hypot(east - run * math.sin(course or 0.0), north - run * math.cos(course or 0.0))
    if away < ECHO_M:
        vessel.beside += 1
    else:
        vessel.apart = True


def is_echo(vessel: Vessel) -> bool:
    """Whether every position compared was beside own ship. A ship alongside is taken for one."""
    return vessel.beside >= BESIDE and not vessel.apart
