"""Where own ship is going: to its route's next waypoint, or straight ahead."""

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
OFF_COURSE_S = 600.0
#: A waypoint of the route is reached so near to it [m], as in the environment.
ARRIVED_M = EnvSettings().arrival_m


class WaypointTracker:
    """The waypoint for the pilots: that of the ship's route, or one ahead. Kept on the globe.

    Attributes:
        is_from_route: Whether the present waypoint is of the route.
        route_ended: Whether the route has ended, and there was no other since.
    """

    def __init__(self) -> None:
        self._position: tuple[float, float] | None = None
        self._last_on_course_s = -math.inf
        self.is_from_route = False
        self.route_ended = False

    def set_route_waypoint(self, latitude_deg: float, longitude_deg: float, now_s: float) -> None:
        """Set the route's next waypoint; it holds until the next one, or own ship is there or off
        course."""
        self._position, self.is_from_route = (latitude_deg, longitude_deg), True
        self._last_on_course_s, self.route_ended = now_s, False

    def end_route(self) -> None:
        """End the route: the waypoint is ahead from now on."""
        if self.is_from_route:
            self._position, self.is_from_route, self.route_ended = None, False, True

    def waypoint(
        self, plane: LocalProjection, east_m: float, north_m: float, course_rad: float, now_s: float
    ) -> tuple[float, float]:
        """The waypoint (east and north [m]) of own ship at a point of the plane, on a course.

        A waypoint of the route is shown on its bearing at a distance that the pilots know.
        """
        if self._position is not None:
            east, north = (float(x[0]) for x in plane.to_plane(*_arrays(*self._position)))
            distance = math.hypot(east - east_m, north - north_m)
            bearing = math.atan2(east - east_m, north - north_m)
            off = abs((bearing - course_rad + math.pi) % math.tau - math.pi)
            if off <= OFF_COURSE_RAD or now_s < self._last_on_course_s:
                self._last_on_course_s = now_s
            on_course = now_s - self._last_on_course_s <= OFF_COURSE_S
            if self.is_from_route and on_course and distance > ARRIVED_M:
                shown = min(max(distance, NEAR_M), AHEAD_M)
                return east_m + shown * math.sin(bearing), north_m + shown * math.cos(bearing)
            if not self.is_from_route and on_course and NEAR_M < distance < 2 * AHEAD_M:
                return east, north
        east = east_m + AHEAD_M * math.sin(course_rad)
        north = north_m + AHEAD_M * math.cos(course_rad)
        latitude, longitude = plane.to_globe(*_arrays(east, north))
        self._position, self._last_on_course_s = (float(latitude[0]), float(longitude[0])), now_s
        self.is_from_route = False
        return east, north


def _arrays(x: float, y: float) -> tuple[np.ndarray, np.ndarray]:
    return np.array([x]), np.array([y])
