"""Between the globe and the plane: latitude and longitude as metres east and north of an origin.

Azimuthal equidistant on WGS84, centred on the origin: distances and bearings
from the origin are exact, and within 50 km of it lengths are true to 1 : 10⁵.
"""

import numpy as np
import pyproj
from jaxtyping import Float64

Degrees = Float64[np.ndarray, "*n"]
Metres = Float64[np.ndarray, "*n"]

_E2 = 0.00669438  # eccentricity of WGS84, squared
_STEP_DEG = 1e-5  # about a metre: the finite difference that turns a course into the plane


class LocalProjection:
    """The plane that touches the globe at ``origin`` (latitude, longitude; [deg])."""

    def __init__(self, latitude_deg: float, longitude_deg: float):
        self.origin = (float(latitude_deg), float(longitude_deg))
        self._projection = pyproj.Proj(
            proj="aeqd", lat_0=self.origin[0], lon_0=self.origin[1], ellps="WGS84"
        )

    def to_plane(self, latitude_deg: Degrees, longitude_deg: Degrees) -> tuple[Metres, Metres]:
        """East and north [m] of positions."""
        east, north = self._projection(np.asarray(longitude_deg), np.asarray(latitude_deg))
        return np.asarray(east), np.asarray(north)

    def to_globe(self, east_m: Metres, north_m: Metres) -> tuple[Degrees, Degrees]:
        """Latitude and longitude [deg] of points of the plane."""
        longitude, latitude = self._projection(
            np.asarray(east_m, float), np.asarray(north_m, float), inverse=True
        )
        return np.asarray(latitude), np.asarray(longitude)

    def course(
        self, latitude_deg: Degrees, longitude_deg: Degrees, true_course_rad: Degrees
    ) -> Degrees:
        """A true course at a place as a direction of the plane [rad].

        The meridians converge: 20 km east of an origin at 60° N the plane's
        north is 0.3° off true north.
        """
        latitude = np.radians(latitude_deg)
        # A degree of longitude over one of latitude, in metres, on the ellipsoid.
        ratio = np.cos(latitude) * (1 - _E2 * np.sin(latitude) ** 2) / (1 - _E2)
        step_north = _STEP_DEG * np.cos(true_course_rad)
        step_east = _STEP_DEG * np.sin(true_course_rad) / ratio
        east, north = self.to_plane(latitude_deg, longitude_deg)
        east_2, north_2 = self.to_plane(latitude_deg + step_north, longitude_deg + step_east)
        return np.arctan2(east_2 - east, north_2 - north)
