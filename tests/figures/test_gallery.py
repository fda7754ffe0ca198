import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import rgb_to_hsv, to_rgb
from tests.voyages import learned, plain, voyage

from glasshelm.figures import coloured_tracks, trajectories
from glasshelm.figures.gallery import FIGURES, why_missing
from glasshelm.figures.priorities import at_instants, over_time, signed
from glasshelm.figures.shapley_over_time import reasons
from glasshelm.figures.style import as_svg, save
from glasshelm.frames.series import to_series

LEARNED, PLAIN = to_series(learned()), to_series(plain())


def drawn(frames):
    return {spec.stem for spec in FIGURES if spec.draw(frames) is not None}


def test_an_attention_pilot_gets_every_figure():
    assert drawn(LEARNED) == {spec.stem for spec in FIGURES}


def test_a_pilot_without_reasons_gets_tracks_and_motion_and_the_reason_why():
    assert drawn(PLAIN) == {"07_tracks", "08_relative", "motion"}
    for spec in FIGURES:
        if spec.draw(PLAIN) is None:
            assert why_missing(spec, PLAIN).endswith(".")
            assert "not drawn" in why_missing(spec, PLAIN)


def test_an_empty_sea_still_has_tracks_and_motion():
    empty = to_series(voyage([0.0] * 30))
    assert drawn(empty) == {"07_tracks", "motion"}
    relative = next(p for p in FIGURES if p.stem == "08_relative")
    assert "no other ship" in why_missing(relative, empty)


def lines_of(figure, index=0):
    return figure.axes[index].get_lines()


def test_tracks_are_where_the_ships_were_in_miles():
    lines = lines_of(trajectories.absolute(LEARNED))
    for ship in LEARNED.ships:
        track = np.stack([ship.east_m, ship.north_m], -1) / 1852
        assert any(
            line.get_xydata().shape == track.shape and np.allclose(line.get_xydata(), track)
            for line in lines
        )


def test_own_markers_are_open_and_others_filled():
    lines = lines_of(trajectories.absolute(LEARNED))
    markers = [line for line in lines if line.get_linestyle() == "None"]
    own = [m for m in markers if m.get_marker() == "o"]
    assert own
    assert all(m.get_markerfacecolor() == "white" for m in own)
    others = [m for m in markers if m.get_marker() in "s^Dv"]
    assert len(others) == 2
    assert all(m.get_markerfacecolor() == m.get_color() != "white" for m in others)
    assert len({m.get_marker() for m in others}) == 2


def brightness(cmap, value):
    return rgb_to_hsv(to_rgb(cmap(value)))[2]


@pytest.mark.parametrize("cmap", [coloured_tracks.DANGER, coloured_tracks.ATTENTION])
def test_more_is_darker(cmap):
    shades = [brightness(cmap, v) for v in np.linspace(0, 1, 20)]
    assert np.all(np.diff(shades) < 0)


def test_danger_is_how_much_lower_than_far_off():
    figure = coloured_tracks.danger(LEARNED)
    assert figure is not None
    parts = [c for c in figure.axes[0].collections if isinstance(c, LineCollection)]
    values = np.concatenate([c.get_array() for c in parts])
    assert set(np.round(values, 6)) == {0.5, 0.1, 0.0}


def test_intention_has_a_scale_with_zero_in_the_middle():
    figure = coloured_tracks.intention(LEARNED)
    assert figure is not None
    part = next(c for c in figure.axes[0].collections if isinstance(c, LineCollection))
    assert part.norm.vmin == -part.norm.vmax


def test_bars_of_an_instant_are_the_priorities_there():
    figure = at_instants(LEARNED, [100.0])
    assert figure is not None
    widths = [patch.get_width() for patch in figure.axes[1].patches]
    np.testing.assert_allclose(widths, [-0.03, 0.08, 0.01, 0.09])


def test_priorities_over_time_are_those_of_the_frames():
    figure = over_time(LEARNED)
    assert figure is not None
    by_label = {line.get_label(): line for ax in figure.axes for line in ax.get_lines()}
    np.testing.assert_allclose(by_label["waypoint"].get_ydata(), LEARNED.priority_waypoint)
    np.testing.assert_allclose(by_label["all ships"].get_ydata(), LEARNED.priority_collision)


@pytest.mark.parametrize(
    ("value", "text"), [(0.0123, "+0.012"), (-0.5, "−0.500"), (-0.0001, "0.000")]
)
def test_signs(value, text):
    assert signed(value) == text


@pytest.mark.slow
def test_the_same_frames_give_the_same_files(tmp_path):
    one = save(trajectories.absolute(PLAIN), tmp_path / "a" / "tracks")
    two = save(trajectories.absolute(PLAIN), tmp_path / "b" / "tracks")
    assert [p.suffix for p in one] == [".pdf", ".png"]
    assert [p.read_bytes() for p in one] == [p.read_bytes() for p in two]
    assert as_svg(trajectories.absolute(PLAIN)) == as_svg(trajectories.absolute(PLAIN))


def test_the_parts_of_the_rudder_are_stacked_to_either_side():
    """Starboard parts up, port parts down."""
    axes = reasons(LEARNED).axes[2]
    ends = [path.get_extents() for fill in axes.collections for path in fill.get_paths()]
    up, down = max(box.y1 for box in ends), min(box.y0 for box in ends)
    parts = np.degrees([LEARNED.base_rad, *(s.shapley_rad for s in LEARNED.ships)])
    assert up == pytest.approx(np.maximum(parts, 0).sum(0).max())
    assert down == pytest.approx(np.minimum(parts, 0).sum(0).min())


def test_a_ship_that_moves_the_rudder_to_port_is_not_coloured_as_one_to_starboard():
    low, middle, high = (coloured_tracks.MOVES(x)[:3] for x in (0.0, 0.5, 1.0))
    hues = [rgb_to_hsv(np.array(c))[0] for c in (low, high)]
    assert abs(hues[0] - hues[1]) > 0.2
    assert max(rgb_to_hsv(np.array(middle))[1:]) > 0.8
