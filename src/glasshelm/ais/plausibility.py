"""Whether a report can be of a ship at all."""

import math

from glasshelm.ais.limits import MAX_SIZE_M, MAX_SPEED_KN, is_position
from glasshelm.ais.reports import Report
from glasshelm.ship.nomoto import KNOT_M_S

#: No identity is longer than this [characters].
LONGEST_ID = 100


def is_plausible(r: Report) -> bool:
    """Numbers that are numbers, a place on the globe (not the void 0°, 0°), a ship's speed."""
    if not 0 < len(r.id) <= LONGEST_ID:
        return False
    places = (
        (r.latitude_deg, r.longitude_deg),
        (r.waypoint_latitude_deg, r.waypoint_longitude_deg),
    )
    if not all(_on_globe(*place) for place in places):
        return False
    if r.speed_m_s is not None and not 0 <= r.speed_m_s <= MAX_SPEED_KN * KNOT_M_S:
        return False
    if not all(size is None or 0 <= size <= MAX_SIZE_M for size in (r.length_m, r.beam_m)):
        return False
    angles = (r.course_rad, r.heading_rad, r.rate_of_turn_rad_s, r.rudder_rad)
    return all(angle is None or (math.isfinite(angle) and abs(angle) < 100) for angle in angles)


def _on_globe(latitude: float | None, longitude: float | None) -> bool:
    """A place that can be, or none at all; half of a place is none."""
    if latitude is None or longitude is None:
        return latitude is longitude
    return bool(is_position(latitude, longitude))
