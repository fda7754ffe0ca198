import numpy as np
import pytest
from pyproj import Geod

from glasshelm.encounters.projection import LocalProjection

GEOD = Geod(ellps="WGS84")


@pytest.mark.parametrize("home", [(0.0, 0.0), (59.7, 24.7), (-33.9, 151.3), (52.0, 179.99)])
def test_range_and_bearing_from_the_origin_are_exact(home):
    bearing, range_m = np.array([0.0, 77.0, 181.0, 300.0]), np.array([100.0, 5e3, 2e4, 5e4])
    longitude, latitude, _ = GEOD.fwd(np.full(4, home[1]), np.full(4, home[0]), bearing, range_m)
    east, north = LocalProjection(*home).to_plane(latitude, longitude)
    np.testing.assert_allclose(np.hypot(east, north), range_m, rtol=1e-6)
    np.testing.assert_allclose(np.degrees(np.arctan2(east, north)) % 360, bearing, atol=1e-4)
    back = LocalProjection(*home).to_globe(east, north)
    np.testing.assert_allclose(back[0], latitude, atol=1e-9)


def test_courses_follow_the_converging_meridians():
    # A ship 20 km east at 60° N steering true north: her way on the plane, against geodesics.
    plane = LocalProjection(60.0, 25.0)
    latitude, longitude = plane.to_globe(np.array([20_000.0]), np.array([0.0]))
    for true_deg in (0.0, 45.0, 200.0):
        course = plane.course(latitude, longitude, np.radians([true_deg]))
        there = GEOD.fwd(longitude, latitude, [true_deg], [500.0])
        east, north = plane.to_plane(np.asarray(there[1]), np.asarray(there[0]))
        start = plane.to_plane(latitude, longitude)
        way = np.arctan2(east - start[0], north - start[1])
        np.testing.assert_allclose(np.sin(course - way), 0, atol=2e-4)
    north_there = plane.course(latitude, longitude, np.zeros(1))
    assert np.degrees(north_there[0]) == pytest.approx(-0.31, abs=0.01)
