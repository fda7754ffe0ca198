"""What a navigator looks at first: distances, heading and rudder over time. Any pilot has it."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from glasshelm.figures import maps
from glasshelm.figures.priorities import draw_rudder
from glasshelm.figures.style import (
    INK,
    SOFT,
    legend_below,
    new_figure,
    nm,
    ship_styles,
    styled,
    time_axis,
)
from glasshelm.frames.series import Frames, Series, ships_of_note, to_series


@styled
def motion(frames: Frames) -> Figure:
    """Ranges of the ships, heading against the course to the waypoint, and rudder, over time.

    A range is drawn thick while the ship is inside own ship's domain (Eq. 13 > 0).
    """
    voyage = to_series(frames)
    count = 3 if voyage.ships else 2
    figure = new_figure(7.2, 1.9 * count + 0.5)
    axes = list(figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0])
    if voyage.ships:
        _ranges(axes[0], voyage)
    _heading(axes[-2], voyage)
    draw_rudder(axes[-1], voyage)
    for ax in axes:
        time_axis(ax, voyage, label=ax is axes[-1])
    figure.align_ylabels(axes)
    legend_below(figure, maps.ship_handles(voyage))
    return figure


def _ranges(ax: Axes, voyage: Series) -> None:
    at, _ = maps.marks(voyage)
    by_id = ship_styles(voyage)
    noted = ships_of_note(voyage)
    for ship in noted:
        look, values = by_id[ship.id], nm(ship.range_m)
        ax.plot(voyage.minutes, values, color=look.colour, lw=1.2, marker=look.marker, ms=4.5,
                mec="white", mew=0.4, markevery=list(at))  # fmt: skip
        inside = np.where(ship.danger > 0, values, np.nan)
        ax.plot(voyage.minutes, inside, color=look.colour, lw=4.5, alpha=0.6)
    ax.set_ylim(0, maps.reach(voyage))
    ax.set_ylabel("range [NM]")
    ax.set_title("Range of each ship; thick: inside the ship domain")


def _heading(ax: Axes, voyage: Series) -> None:
    heading = np.degrees(voyage.heading_rad)
    course = heading + np.degrees(voyage.waypoint_bearing_rad)
    ax.plot(voyage.minutes, course, color=SOFT, lw=1.1, ls=(0, (4, 1.5)), label="to the waypoint")
    ax.plot(voyage.minutes, heading, color=INK, lw=1.4, label="heading")
    ax.margins(y=0.15)
    ax.yaxis.set_major_formatter(lambda value, _: f"{value % 360:03.0f}")
    ax.set_ylabel("heading [°]")
    ax.set_title("Heading, and the course to the waypoint")
    ax.legend(loc="best", ncols=2)
