import jax.numpy as jnp
import numpy as np
import pytest
from matplotlib.colors import Normalize
from tests.voyages import learned, voyage

from glasshelm.core.geometry import Vector
from glasshelm.figures import maps
from glasshelm.figures.style import new_figure
from glasshelm.frames.series import to_series
from glasshelm.ship.domain import danger_unclipped


def test_the_drawn_domain_is_where_danger_is_zero():
    edge = jnp.asarray(maps.domain_outline(340.0))
    np.testing.assert_allclose(
        danger_unclipped(Vector(edge[:, 0], edge[:, 1]), 340.0), 0, atol=1e-6
    )


def test_markers_stand_at_equal_times():
    v = to_series(learned())
    at, step = maps.marks(v)
    np.testing.assert_allclose(np.diff(v.minutes[at]), step)
    assert 3 <= len(at) <= 11


def test_a_voyage_of_one_frame_has_one_marker():
    at, _ = maps.marks(to_series(voyage([0.0])))
    assert at.tolist() == [0]


def test_coloured_pieces_cover_the_track_and_no_gap():
    x, y = np.arange(10.0), np.zeros(10)
    x[5] = np.nan
    value = np.array([0, 0, 0, 1, 1, 1, 0.5, 0.5, 0.5, 0.5])
    pieces, values = maps._pieces(x, y, value, Normalize(0, 1))
    spans = [(p[0, 0], p[-1, 0]) for p in pieces]
    assert spans == [(0, 3), (3, 4), (6, 9)]
    assert values.tolist() == [0, 1, 0.5]


def test_maps_have_equal_scales_and_nautical_labels():
    v = to_series(learned())
    ax = new_figure(4.0, 4.0).add_subplot()
    maps.frame_absolute(ax, v)
    assert ax.get_aspect() == 1
    assert "NM" in ax.get_xlabel()
    assert "NM" in ax.get_ylabel()
    assert np.ptp(ax.get_xlim()) == pytest.approx(np.ptp(ax.get_ylim()))


def test_relative_map_shows_the_whole_domain():
    ax = new_figure(4.0, 4.0).add_subplot()
    maps.frame_relative(ax, to_series(learned()))
    edge = maps.domain_outline(340.0) / 1852
    assert ax.get_xlim()[0] < edge[:, 0].min()
    assert ax.get_xlim()[1] > edge[:, 0].max()
    assert ax.get_ylim()[1] > edge[:, 1].max()
