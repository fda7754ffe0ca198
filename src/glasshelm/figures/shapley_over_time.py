"""What moved the rudder: Shapley values by ship (docs/explanation/explanations.md)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from glasshelm.figures import maps
from glasshelm.figures.priorities import draw_by_ship, draw_rudder
from glasshelm.figures.style import (
    INK,
    SOFT,
    legend_below,
    new_figure,
    ship_styles,
    styled,
    time_axis,
)
from glasshelm.figures.trajectories import draw_absolute
from glasshelm.frames.series import Frames, Series, TimeSeries, ships_of_note, to_series

_WAYPOINT_FILL = "#9aa3ad"
_REST_FILL = "#e4e7ea"


@styled
def reasons(frames: Frames) -> Figure | None:
    """The rudder, what it is made of, and what it would lack without each ship, over time.

    Above: the rudder. Middle: the same as a sum, the part of the waypoint (the rudder
    with nobody there) and every ship's Shapley value, stacked to either side. Below: by
    how much the rudder would change if one ship alone were left out. None if the
    frames have no Shapley values.
    """
    voyage = to_series(frames)
    if not voyage.has("shapley_rad"):
        return None
    figure = new_figure(9.4, 6.4)
    grid = figure.add_gridspec(3, 2, width_ratios=(1, 1.1), height_ratios=(0.6, 1, 1))
    draw_absolute(figure.add_subplot(grid[:, 0]), voyage)
    axes = [figure.add_subplot(grid[i, 1]) for i in range(3)]
    draw_rudder(axes[0], voyage)
    draw_sum(axes[1], voyage)
    at, _ = maps.marks(voyage)
    axes[2].axhline(0, color=SOFT, lw=0.6)
    draw_by_ship(axes[2], voyage, "leave_one_out_deg", at)
    axes[2].set_title("Rudder − rudder without this ship")
    axes[2].set_ylabel("[°], + to starboard")
    for ax in axes:
        time_axis(ax, voyage, label=ax is axes[-1])
    figure.align_ylabels(axes)
    legend_below(figure, [maps.own_handle(), *maps.ship_handles(voyage)])
    return figure


def draw_sum(ax: Axes, voyage: Series) -> None:
    """The rudder as a sum: parts to starboard upwards, parts to port downwards, and the total."""
    up, down = np.zeros(len(voyage.time_s)), np.zeros(len(voyage.time_s))
    for part, colour in _parts(voyage):
        for side, base in ((np.maximum(part, 0.0), up), (np.minimum(part, 0.0), down)):
            ax.fill_between(
                voyage.minutes, base, base + side, step="post", color=colour, lw=0, alpha=0.85
            )
            base += side
    ax.axhline(0, color=SOFT, lw=0.6)
    whole = np.where(np.isfinite(voyage.base_rad), voyage.rudder_rad, np.nan)
    ax.step(voyage.minutes, np.degrees(whole), where="post", color=INK, lw=1.2)
    ax.set_ylabel("[°], + to starboard")
    ax.set_title("What the rudder is made of (Shapley values; line: their sum)")
    fills = [Patch(color=_WAYPOINT_FILL, label="waypoint")]
    if len(ships_of_note(voyage)) < len(voyage.ships):
        fills.append(Patch(color=_REST_FILL, label="other ships"))
    ax.legend(handles=fills, loc="upper right", ncols=2, borderaxespad=0.1)
    ax.margins(y=0.15)


def _parts(voyage: Series) -> list[tuple[TimeSeries, str]]:
    """The parts of the rudder in degrees with their colours; they add up to it."""
    by_id = ship_styles(voyage)
    alone = np.degrees(np.nan_to_num(voyage.base_rad))
    parts = [(alone, _WAYPOINT_FILL)]
    rest = np.zeros_like(alone)
    for ship in voyage.ships:
        share = np.degrees(np.nan_to_num(ship.shapley_rad))
        if ship.id in by_id:
            parts.append((share, by_id[ship.id].colour))
        else:
            rest += share
    return [*parts, (rest, _REST_FILL)]
