"""Hulls touch where a drawing says so."""

import jax.numpy as jnp
import numpy as np
import pytest
from matplotlib.path import Path as Outline

from glasshelm.core.geometry import Vector
from glasshelm.figures.maps import hull_outline
from glasshelm.ship.hull_overlap import hull, hull_gap_m

OWN = hull(340.0, 60.0)


def gap(east, north, heading_deg, own_heading_deg=0.0, length=340.0, beam=60.0):
    return float(
        hull_gap_m(
            OWN,
            float(np.radians(own_heading_deg)),
            hull(length, beam),
            Vector(jnp.asarray(east), jnp.asarray(north)),
            float(np.radians(heading_deg)),
        )
    )


def test_the_hull_is_the_one_that_figures_draw():
    drawn = {tuple(p) for p in hull_outline(340.0, 60.0).round(3).tolist()}
    ours = {tuple(p) for p in np.stack(OWN, -1).round(3).tolist()}
    assert drawn == ours


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ((100.0, 0.0, 0.0), 40.0),  # side by side
        ((50.0, 0.0, 0.0), -10.0),
        ((0.0, -360.0, 0.0), 20.0),  # her bow to our stern
        ((300.0, 0.0, 270.0), 100.0),  # her bow to our side
        ((0.0, 0.0, 90.0), None),  # crossed
    ],
)
def test_gaps_of_simple_places(place, expected):
    found = gap(*place)
    assert found == pytest.approx(expected, abs=1e-3) if expected is not None else found < -59


def test_a_narrow_bow_passes_where_a_box_would_touch():
    """Two bows port to port: boxes of 60 m would overlap by 10 m, the drawn hulls are apart."""
    assert gap(-50.0, 320.0, 180.0) > 0


def test_the_gap_is_the_same_from_either_ship_and_however_turned():
    rng = np.random.default_rng(0)
    for _ in range(20):
        east, north, a, b = rng.uniform((-300, -300, 0, 0), (300, 300, 360, 360))
        there = gap(east, north, b, a)
        assert gap(-east, -north, a, b) == pytest.approx(there, abs=1e-2)


def test_overlap_agrees_with_points_of_a_grid():
    """A point of one hull inside the other means overlap; none, at a metre's grid, none."""
    rng = np.random.default_rng(1)
    corners = np.stack(OWN, -1)
    x, y = np.meshgrid(np.arange(-30, 31, 2.0), np.arange(-170, 171, 2.0))
    grid = np.stack([x.ravel(), y.ravel()], -1)
    grid = grid[Outline(corners).contains_points(grid)]
    for _ in range(40):
        east, north, course = rng.uniform((-200, -400, 0), (200, 400, 360))
        angle = np.radians(course)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        hers = grid @ turn + (east, north)
        touching = Outline(corners).contains_points(hers).any()
        found = gap(east, north, course)
        if abs(found) > 3:
            assert touching == (found < 0)
