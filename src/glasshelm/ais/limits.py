"""The ranges of AIS values: one set of checks for live and recorded traffic.

Every check takes a number or an array of numbers; NaN is never within a limit.
Codes for "not available" are those of ITU-R M.1371-5.
"""

from typing import Any, TypeAlias

from glasshelm.ais.reports import Report
from glasshelm.ship.nomoto import KNOT_M_S

#: A number, or an array of them.
Numbers: TypeAlias = Any

#: No ship is faster [kn]; 102.3 (type 27: 63) means "not available".
MAX_SPEED_KN = 60.0
#: No ship is longer or broader [m] than AIS can tell.
MAX_SIZE_M = 1022.0
#: Nearer to the poles no course is a direction of a plane [deg].
MAX_LATITUDE_DEG = 89.0
#: At this speed a ship is under way; below, its course over ground is noise [kn].
UNDER_WAY_KN = 3.0
#: A ship that stays this near to own ship's position sensors is own ship's echo [m].
ECHO_M = 150.0
#: A ship not heard for so long is lost: two missed reports of a class A ship at anchor (3 min).
LOST_AFTER_S = 360.0
#: A lost ship is still shown for so long, where it was last received, ...
LOST_SHOWN_S = 360.0
#: ... and is forgotten a minute later.
FORGOTTEN_S = LOST_AFTER_S + LOST_SHOWN_S + 60.0
#: No identity is longer [characters].
MAX_ID_LENGTH = 100

_MAX_MMSI = 999_999_999
#: No angle or rate of turn is larger [rad, rad/s].
_MAX_ANGLE_RAD = 100.0


def is_vessel_mmsi(mmsi: Numbers) -> Numbers:
    """Whether a number can be that of a ship (ITU-R M.585).

    Not those of coast stations (00MIDxxxx), aircraft of search and rescue (111MIDxxx) and aids to
    navigation (99MIDxxxx), and nothing outside 1 to 999,999,999. Numbers below 2,000,000 pass:
    anonymised data count their ships from 1. Senders of distress (970, 972, 974) pass as well.
    """
    coast = _within(mmsi, 2_000_000, 7_999_999)
    aircraft = _within(mmsi, 111_000_000, 111_999_999)
    aid = _within(mmsi, 990_000_000, _MAX_MMSI)
    return is_mmsi(mmsi) & ((coast | aircraft | aid) ^ True)


def is_mmsi(mmsi: Numbers) -> Numbers:
    """Whether a number can be the identity of any station: 1 to 999,999,999."""
    return _within(mmsi, 1, _MAX_MMSI)


def is_position(latitude_deg: Numbers, longitude_deg: Numbers) -> Numbers:
    """Whether a ship can be there: on the globe, and not at 0° 0°, where receivers without a fix
    are."""
    on_globe = _within(latitude_deg, -MAX_LATITUDE_DEG, MAX_LATITUDE_DEG) & _within(
        longitude_deg, -180.0, 180.0
    )
    return on_globe & ((latitude_deg != 0) | (longitude_deg != 0))


def is_speed_kn(speed_kn: Numbers) -> Numbers:
    """Whether a ship can make this speed over ground."""
    return _within(speed_kn, 0.0, MAX_SPEED_KN)


def is_angle_deg(angle_deg: Numbers) -> Numbers:
    """Whether this is a course or a heading: 360 (course) and 511 (heading) are none."""
    return (angle_deg >= 0) & (angle_deg < 360)


def is_size_m(size_m: Numbers) -> Numbers:
    """Whether a ship can be so long or so broad; 0 is a size that nobody has entered."""
    return (size_m > 0) & (size_m <= MAX_SIZE_M)


def is_plausible(r: Report) -> bool:
    """Whether a report can be of a ship at all; values that are missing do no harm."""
    positions = (
        (r.latitude_deg, r.longitude_deg),
        (r.waypoint_latitude_deg, r.waypoint_longitude_deg),
    )
    ranges = (
        (r.speed_m_s, 0.0, MAX_SPEED_KN * KNOT_M_S),
        (r.length_m, 0.0, MAX_SIZE_M),
        (r.beam_m, 0.0, MAX_SIZE_M),
        *(
            (angle, -_MAX_ANGLE_RAD, _MAX_ANGLE_RAD)
            for angle in (r.course_rad, r.heading_rad, r.rate_of_turn_rad_s, r.rudder_rad)
        ),
    )
    return (
        0 < len(r.id) <= MAX_ID_LENGTH
        and all(_is_position_or_none(*position) for position in positions)
        and all(value is None or _within(value, low, high) for value, low, high in ranges)
    )


def _is_position_or_none(latitude: float | None, longitude: float | None) -> bool:
    """Whether this is a possible position, or no position at all; half a position is wrong."""
    if latitude is None or longitude is None:
        return latitude is longitude
    return bool(is_position(latitude, longitude))


def _within(value: Numbers, low: Numbers, high: Numbers) -> Numbers:
    # Operators, not functions of NumPy: single numbers come by the thousand a second.
    return (value >= low) & (value <= high)
