"""Figure 15: time histories of the measures of intention, ship by ship, beside the tracks."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from glasshelm.figures import maps
from glasshelm.figures.priorities import draw_by_ship, draw_priorities
from glasshelm.figures.style import SOFT, legend_below, new_figure, styled, time_axis
from glasshelm.figures.trajectories import draw_absolute, draw_relative
from glasshelm.frames.series import Frames, Series, to_series

#: field, title, label of the axis
_ROWS = (
    ("critic_danger", "Danger by the critic: Q far off − Q", "danger [reward]"),
    ("attention", "Attention (Eq. 23)", "share of 1"),
    ("intention", "Intention: increment of Q × attention (Eq. 24)", "intention [reward]"),
    ("intention_level", "Intention as first printed: Q × attention (Eq. 24)", "intention [reward]"),
)


@styled
def histories(frames: Frames) -> Figure | None:
    """Figure 15: priorities, danger, attention and intention of each ship over time.

    A ship has the colour and marker that she has in the tracks on the left. Rows
    that the pilot cannot fill are left out; None if it has no critic.
    """
    voyage = to_series(frames)
    if not voyage.has("priority_waypoint"):
        return None
    rows = [row for row in _ROWS if voyage.has(row[0])]
    count = 1 + len(rows)
    figure = new_figure(9.6, 2.0 * count + 0.6)
    grid = figure.add_gridspec(count, 2, width_ratios=(1, 1.1))
    if count < 4:
        draw_absolute(figure.add_subplot(grid[:, 0]), voyage)
    else:
        draw_absolute(figure.add_subplot(grid[: count // 2, 0]), voyage)
        draw_relative(figure.add_subplot(grid[count // 2 :, 0]), voyage)
    axes = [figure.add_subplot(grid[i, 1]) for i in range(count)]
    draw_priorities(axes[0], voyage)
    for ax, (field, title, label) in zip(axes[1:], rows, strict=True):
        _draw_row(ax, voyage, field)
        ax.set_title(title)
        ax.set_ylabel(label)
    for ax in axes:
        time_axis(ax, voyage, label=ax is axes[-1])
    figure.align_ylabels(axes)
    legend_below(figure, [maps.own_handle(), *maps.ship_handles(voyage)])
    return figure


def _draw_row(ax: Axes, voyage: Series, field: str) -> None:
    at, _ = maps.marks(voyage)
    ax.axhline(0, color=SOFT, lw=0.6)
    draw_by_ship(ax, voyage, field, at)
    if field == "attention":
        ax.set_ylim(-0.03, 1.03)
        ax.set_yticks(np.linspace(0, 1, 5))
