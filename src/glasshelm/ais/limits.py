"""What the numbers of AIS may be: one set of checks for live and recorded traffic.

Every check takes a number or an array of numbers and answers alike; NaN is never within a limit.
Codes for "not available" are those of ITU-R M.1371-5.
"""

from typing import Any, TypeAlias

import numpy as np

#: A number, or an array of them.
Numbers: TypeAlias = Any

#: A ship is not faster than this [kn]; 102.3 (type 27: 63) means "not available".
FASTEST_KN = 60.0
#: No ship is longer or broader [m] than AIS can tell.
LONGEST_M = 1022.0
#: Nearer to the poles no course is a direction of a plane [deg].
HIGHEST_LATITUDE_DEG = 89.0
#: Times before 1990-01-01 are those of clocks without a fix, ...
EARLIEST_S = 631_152_000.0
#: ... and none after 2100-01-01 is taken for one.
LATEST_S = 4_102_444_800.0

_LARGEST_MMSI = 999_999_999
#: What counts an instant since 1970 is below so much, and so many to the second.
_UNITS = ((1e11, 1.0), (1e14, 1e3), (1e17, 1e6), (1e20, 1e9))


def is_vessel_mmsi(mmsi: Numbers) -> Numbers:
    """Whether a number can be that of a ship (ITU-R M.585).

    Not those of coast stations (00MIDxxxx), aircraft of search and rescue (111MIDxxx) and aids to
    navigation (99MIDxxxx), and nothing outside 1 to 999,999,999. Numbers below 2,000,000 pass:
    anonymised data count their ships from 1. Senders of distress (970, 972, 974) pass as well.
    """
    coast = _within(mmsi, 2_000_000, 7_999_999)
    aircraft = _within(mmsi, 111_000_000, 111_999_999)
    aid = _within(mmsi, 990_000_000, _LARGEST_MMSI)
    return is_mmsi(mmsi) & ((coast | aircraft | aid) ^ True)


def is_mmsi(mmsi: Numbers) -> Numbers:
    """Whether a number can be the identity of any station: 1 to 999,999,999."""
    return _within(mmsi, 1, _LARGEST_MMSI)


def is_position(latitude_deg: Numbers, longitude_deg: Numbers) -> Numbers:
    """Whether a ship can be there: on the globe, and not at 0° 0°, where receivers without a fix
    are."""
    highest = HIGHEST_LATITUDE_DEG
    on_globe = _within(latitude_deg, -highest, highest) & _within(longitude_deg, -180.0, 180.0)
    return on_globe & ((latitude_deg != 0) | (longitude_deg != 0))


def is_speed_kn(speed_kn: Numbers) -> Numbers:
    """Whether a ship can make this speed over ground."""
    return _within(speed_kn, 0.0, FASTEST_KN)


def is_angle_deg(angle_deg: Numbers) -> Numbers:
    """Whether this is a course or a heading: 360 (course) and 511 (heading) are none."""
    return (angle_deg >= 0) & (angle_deg < 360)


def is_size_m(size_m: Numbers) -> Numbers:
    """Whether a ship can be so long or so broad; 0 is a size that nobody has entered."""
    return (size_m > 0) & (size_m <= LONGEST_M)


def epoch_seconds(instant: Numbers) -> Numbers:
    """Seconds since 1970 of a number that counts seconds, milli-, micro- or nanoseconds.

    Their size gives the unit. NaN for what is no time between 1990 and 2100: a year,
    a count from another epoch, a clock that was never set.
    """
    seconds = np.full(np.shape(instant), np.nan)
    values = np.asarray(instant, np.float64)
    for most, unit in reversed(_UNITS):
        seconds = np.where(np.abs(values) < most, values / unit, seconds)
    seconds = np.where((seconds >= EARLIEST_S) & (seconds <= LATEST_S), seconds, np.nan)
    return seconds if np.ndim(instant) else float(seconds)


def _within(value: Numbers, least: Numbers, most: Numbers) -> Numbers:
    # Operators, not functions of NumPy: of single numbers there are thousands a second.
    return (value >= least) & (value <= most)
