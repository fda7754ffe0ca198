"""Why not another rudder? Q over the whole rudder range, split by task and ship."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from glasshelm.figures import maps
from glasshelm.figures.situation_maps import choose, describe_rudder
from glasshelm.figures.style import (
    INK,
    SOFT,
    SUM_INK,
    WAYPOINT_INK,
    legend_below,
    new_figure,
    ship_styles,
    styled,
)
from glasshelm.frames.series import Frames, Series, to_series


@styled
def sweep(frames: Frames, times_s: Sequence[float] | None = None) -> Figure | None:
    """Q of every rudder minus Q of rudder 0, at the instants of figure 11 or at ``times_s``.

    The vertical line is the decided rudder. None if the frames carry no sweep.
    """
    voyage = to_series(frames)
    if all(f.sweep is None for f in voyage.frames):
        return None
    chosen = [k for k in choose(voyage, times_s) if voyage.frames[k].sweep is not None]
    figure = new_figure(4.4 * len(chosen) + 0.2, 4.0)
    axes = figure.subplots(1, len(chosen), squeeze=False, sharey=True)[0]
    for ax, k in zip(axes, chosen, strict=True):
        _draw(ax, voyage, k)
    axes[0].set_ylabel("Q − Q of rudder 0 [reward]")
    legend_below(figure, [*axes[0].get_lines()[:3], *maps.ship_handles(voyage)])
    return figure


def _draw(ax: Axes, voyage: Series, k: int) -> None:
    frame = voyage.frames[k]
    assert frame.sweep is not None
    rudder = np.degrees(frame.sweep.rudder_rad)
    waypoint, collision = np.array(frame.sweep.waypoint), np.array(frame.sweep.collision)

    def from_zero(values: np.ndarray) -> np.ndarray:
        return values - np.interp(0.0, rudder, values)

    ax.plot(rudder, from_zero(waypoint + collision), color=INK, lw=2.4, label="total")
    ax.plot(rudder, from_zero(waypoint), color=WAYPOINT_INK, lw=1.3, ls=(0, (4, 1.5)),
            label="waypoint")  # fmt: skip
    ax.plot(rudder, from_zero(collision), color=SUM_INK, lw=2.6, alpha=0.35, label="all ships")
    by_id = ship_styles(voyage)
    for target in frame.targets:
        if target.q_sweep is not None and target.id in by_id:
            look = by_id[target.id]
            ax.plot(rudder, from_zero(np.array(target.q_sweep)), color=look.colour, lw=1.2,
                    marker=look.marker, ms=4, mec="white", mew=0.4, markevery=5)  # fmt: skip
    ax.axhline(0, color=SOFT, lw=0.6)
    ax.axvline(np.degrees(voyage.rudder_rad[k]), color=INK, lw=0.8, ls=(0, (1, 1.5)))
    ax.set_title(f"{voyage.minutes[k]:.1f} min: {describe_rudder(voyage, k)}")
    ax.set_xlabel("to port  ←  rudder [°]  →  to starboard")
