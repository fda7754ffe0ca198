"""The two futures of a branch in one figure: tracks north-up, nearest ship and rudder over time."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from glasshelm.figures import maps
from glasshelm.figures.style import INK, SOFT, legend_below, new_figure, nm, ship_styles, styled
from glasshelm.frames.series import Frames, Series, ships_of_note, to_series

#: Own ship in the changed future; no ship's colour.
OTHER_INK = "#7B3294"
_DASHED = (0, (4, 2))


@styled
def draw_futures(fact: Frames, other: Frames, condition: str) -> Figure:
    """Own ship as things are (solid) and in the changed future (dashed), with what each meets."""
    one, two = to_series(fact), to_series(other)
    figure = new_figure(5.6, 8.4)
    above, middle, below = figure.subplots(3, 1, height_ratios=(3.2, 1, 1))
    _map(above, one, two)
    _nearest(middle, one, two)
    _rudder(below, one, two)
    middle.sharex(below)
    middle.tick_params(labelbottom=False)
    below.set_xlabel("time from the branch [min]")
    figure.align_ylabels([middle, below])
    changed = Line2D([], [], color=OTHER_INK, lw=1.6, ls=_DASHED, label=condition)
    own = maps.own_handle()
    own.set_label("own ship, as things are")
    legend_below(figure, [own, changed, *maps.ship_handles(one)])
    return figure


def _map(ax: Axes, one: Series, two: Series) -> None:
    at, step = maps.marks(one)
    maps.draw_others(ax, one, relative=False)
    by_id = ship_styles(one)
    xs, ys = [nm(one.east_m), nm(two.east_m)], [nm(one.north_m), nm(two.north_m)]
    moved = {ship.id: ship for ship in two.ships}
    for ship in ships_of_note(one):
        x, y = maps.track(ship, False)
        maps.draw_track(ax, x, y, at, by_id[ship.id])
        if ship.id in moved:
            _where_moved(ax, x, y, *maps.track(moved[ship.id], False), by_id[ship.id].colour)
        close = nm(ship.range_m) <= maps.reach(one)
        xs.append(x[close])
        ys.append(y[close])
    maps.draw_own(ax, one, at)
    ax.plot(nm(two.east_m), nm(two.north_m), color=OTHER_INK, lw=1.6, ls=_DASHED, zorder=4.4)
    shown = at[at < len(two.time_s)]
    ax.plot(
        nm(two.east_m)[shown], nm(two.north_m)[shown], ls="", marker="o", ms=5, mfc="white",
        mec=OTHER_INK, mew=1.1, zorder=5,
    )  # fmt: skip
    maps.draw_arrow(ax, nm(two.east_m), nm(two.north_m), OTHER_INK)
    maps.limits(ax, np.concatenate(xs), np.concatenate(ys))
    ax.set_xlabel("east [NM]")
    ax.set_ylabel("north [NM]")
    ax.grid(True)
    ax.set_title(f"Two futures of one instant, a marker every {step:g} min")


def _where_moved(
    ax: Axes, x: np.ndarray, y: np.ndarray, x2: np.ndarray, y2: np.ndarray, colour: str
) -> None:
    """A target's other track, where she goes another way."""
    count = min(len(x), len(x2))
    if np.nanmax(np.hypot(x[:count] - x2[:count], y[:count] - y2[:count]), initial=0.0) > 0.01:
        ax.plot(x2, y2, color=colour, lw=1.2, ls=_DASHED, zorder=3)


def _nearest(ax: Axes, one: Series, two: Series) -> None:
    for voyage, colour, style in ((one, INK, "-"), (two, OTHER_INK, _DASHED)):
        if voyage.ships:
            ranges = np.stack([ship.range_m for ship in voyage.ships])
            known = np.where(np.isfinite(ranges), ranges, np.inf).min(0)
            known = np.where(np.isfinite(known), known, np.nan)
            ax.plot(voyage.minutes, nm(known), color=colour, lw=1.4, ls=style)
    ax.set_ylim(bottom=0)
    ax.set_ylabel("range [NM]")
    ax.set_title("Range of the nearest ship")


def _rudder(ax: Axes, one: Series, two: Series) -> None:
    ax.axhline(0, color=SOFT, lw=0.6)
    for voyage, colour, style in ((one, INK, "-"), (two, OTHER_INK, _DASHED)):
        ax.step(voyage.minutes, np.degrees(voyage.rudder_rad), color=colour, lw=1.2, ls=style,
                where="post")  # fmt: skip
    ax.set_ylabel("rudder [°]")
    ax.set_title("Rudder, starboard positive")
