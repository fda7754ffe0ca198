"""Where own ship is going: to her route's waypoint, or straight on for as long as she means it."""

import math

import numpy as np

from glasshelm.encounters.projection import LocalProjection
from glasshelm.encounters.random_encounters import PAPER, WIDE
from glasshelm.env.step import EnvSettings

#: The assumed waypoint lies so far ahead [m], as in the paper, ...
AHEAD_M = PAPER.waypoint_m[1]
#: ... and is set anew when own ship is nearer to it than any that the pilots were trained on, ...
NEAR_M = WIDE.waypoint_m[0]
#: ... or has steered another course than towards it, by this angle, ...
OFF_COURSE_RAD = math.radians(20)
#: ... for so long [s]: an evasive manoeuvre of some minutes is no new destination.
MEANT_S = 600.0
#: A waypoint that was told is reached so near to it [m], as in the world.
ARRIVED_M = EnvSettings().arrival_m


class WaypointTracker:
    """The waypoint that pilots are shown: the one told by the ship's route, or one ahead.

    Kept on the globe. ``told`` says whether a feed gave the present one.
    """

    def __init__(self) -> None:
        self._place: tuple[float, float] | None = None
        self._on_course_s = -math.inf
        self.told = False
        #: Whether the route was told to have ended, and no other was since.
        self.ended = False

    def tell(self, latitude_deg: float, longitude_deg: float, now_s: float) -> None:
        """The route's next waypoint. It holds until another comes, own ship is there, or off it."""
        self._place, self.told = (latitude_deg, longitude_deg), True
        self._on_course_s, self.ended = now_s, False

    def end(self) -> None:
        """The route has ended: the waypoint is ahead from now on."""
        if self.told:
            self._place, self.told, self.ended = None, False, True

    def waypoint(
        self, plane: LocalProjection, east_m: float, north_m: float, course_rad: float, now_s: float
    ) -> tuple[float, float]:
        """The waypoint (east and north [m]) of own ship at a place of the plane, on a course.

        One from a feed is shown on the same bearing at a distance that the pilots know.
        """
        if self._place is not None:
            east, north = (float(x[0]) for x in plane.to_plane(*_arrays(*self._place)))
            away = math.hypot(east - east_m, north - north_m)
            bearing = math.atan2(east - east_m, north - north_m)
            off = abs((bearing - course_rad + math.pi) % math.tau - math.pi)
            if off <= OFF_COURSE_RAD or now_s < self._on_course_s:
                self._on_course_s = now_s
            meant = now_s - self._on_course_s <= MEANT_S
            if self.told and meant and away > ARRIVED_M:
                shown = min(max(away, NEAR_M), AHEAD_M)
                return east_m + shown * math.sin(bearing), north_m + shown * math.cos(bearing)
            if not self.told and meant and NEAR_M < away < 2 * AHEAD_M:
                return east, north
        east = east_m + AHEAD_M * math.sin(course_rad)
        north = north_m + AHEAD_M * math.cos(course_rad)
        latitude, longitude = plane.to_globe(*_arrays(east, north))
        self._place, self._on_course_s = (float(latitude[0]), float(longitude[0])), now_s
        self.told = False
        return east, north


def _arrays(x: float, y: float) -> tuple[np.ndarray, np.ndarray]:
    return np.array([x]), np.array([y])
