"""Short distances on the globe."""

import math

import numpy as np

from glasshelm.ais.limits import Numbers

#: Mean radius of the earth [m].
EARTH_RADIUS_M = 6_371_000.0
_M_DEG = math.radians(EARTH_RADIUS_M)


def offset_m(
    from_latitude_deg: Numbers,
    from_longitude_deg: Numbers,
    to_latitude_deg: Numbers,
    to_longitude_deg: Numbers,
) -> tuple[Numbers, Numbers]:
    """East and north [m] from one position to another, near enough together to be a plane."""
    east_deg = (to_longitude_deg - from_longitude_deg + 180.0) % 360.0 - 180.0
    middle = np.radians(0.5 * (from_latitude_deg + to_latitude_deg))
    return _M_DEG * east_deg * np.cos(middle), _M_DEG * (to_latitude_deg - from_latitude_deg)
