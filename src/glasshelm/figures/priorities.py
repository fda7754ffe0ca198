"""Figures 10 and 11: what the pilot wants, task by task and ship by ship (Eq. 22)."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator

from glasshelm.figures import maps
from glasshelm.figures.situation_maps import choose, describe_rudder, draw_situation
from glasshelm.figures.style import (
    INK,
    SOFT,
    SUM_INK,
    WAYPOINT_INK,
    legend_below,
    new_figure,
    ship_styles,
    styled,
    time_axis,
)
from glasshelm.figures.trajectories import draw_absolute
from glasshelm.frames.series import Frames, Series, TimeSeries, ships_of_note, to_series

#: Priorities, and spans of values, larger than this have a scale that is logarithmic beyond ±1.
WIDE = 50.0


@styled
def over_time(frames: Frames, times_s: Sequence[float] | None = None) -> Figure | None:
    """Figure 10: the tracks, and beside them rudder and priorities over time.

    The thin vertical lines are the instants of figure 11. None if the pilot has
    no critic.
    """
    voyage = to_series(frames)
    if not voyage.has("priority_waypoint"):
        return None
    figure = new_figure(9.0, 4.9)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.05, 1), height_ratios=(0.55, 1))
    draw_absolute(figure.add_subplot(grid[:, 0]), voyage)
    rudder, priority = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    draw_rudder(rudder, voyage)
    draw_priorities(priority, voyage)
    for k in choose(voyage, times_s):
        for ax in (rudder, priority):
            ax.axvline(voyage.minutes[k], color=SOFT, lw=0.7, ls=(0, (1, 2)))
    time_axis(rudder, voyage, label=False)
    time_axis(priority, voyage)
    legend_below(figure, [maps.own_handle(), *maps.ship_handles(voyage)])
    return figure


@styled
def at_instants(frames: Frames, times_s: Sequence[float] | None = None) -> Figure | None:
    """Figure 11: situation, action and priorities at chosen instants.

    Without ``times_s``: the instant of the largest collision priority, and that
    of the largest waypoint priority after it. None if the pilot has no critic.
    """
    voyage = to_series(frames)
    if not voyage.has("priority_waypoint"):
        return None
    chosen = choose(voyage, times_s)
    figure = new_figure(8.2, 3.6 * len(chosen))
    rows = figure.subplots(len(chosen), 2, squeeze=False, width_ratios=(1, 1))
    span = _span(voyage, chosen)
    for (left, right), k in zip(rows, chosen, strict=True):
        draw_situation(left, voyage, k)
        left.set_title(f"{voyage.minutes[k]:.1f} min: {describe_rudder(voyage, k)}")
        _bars(right, voyage, k, span)
    return figure


def draw_rudder(ax: Axes, voyage: Series) -> None:
    """The rudder over time, degrees, starboard up."""
    degrees = np.degrees(voyage.rudder_rad)
    ax.axhline(0, color=SOFT, lw=0.6)
    ax.step(voyage.minutes, degrees, where="post", color=INK, lw=1.1)
    limit = np.degrees(voyage.frames[0].ship.rudder_limit_rad)
    ax.set_ylim(-1.1 * limit, 1.1 * limit)
    ax.set_ylabel("rudder [°]")
    what = "Rudder" if voyage.applied else "Rudder that the pilot advises"
    ax.set_title(f"{what}, + to starboard")


def draw_priorities(ax: Axes, voyage: Series) -> None:
    """Priorities (Eq. 22) over time: the waypoint's, every ship's, and the ships' sum."""
    at, _ = maps.marks(voyage)
    ax.axhline(0, color=SOFT, lw=0.6)
    ax.plot(voyage.minutes, voyage.priority_collision, color=SUM_INK, lw=2.6, alpha=0.35,
            label="all ships")  # fmt: skip
    draw_by_ship(ax, voyage, "priority", at)
    ax.plot(voyage.minutes, voyage.priority_waypoint, color=WAYPOINT_INK, lw=1.3,
            ls=(0, (4, 1.5)), label="waypoint")  # fmt: skip
    ax.set_ylabel("priority [reward]")
    ax.set_title(f"Priorities: Q of the choice − Q of {_reference(voyage)}")
    ax.margins(y=0.22)
    if _spread(voyage) > WIDE:
        ax.set_yscale("symlog", linthresh=1.0)
        plain_powers(ax.yaxis)
    handles, labels = ax.get_legend_handles_labels()
    ax.legend(handles, labels, loc="upper right", ncols=2, borderaxespad=0.1)


def draw_by_ship(ax: Axes, voyage: Series, field: str, at: np.ndarray) -> None:
    """One quantity of every ship of note over time, in her colour and with her marker."""
    by_id = ship_styles(voyage)
    for ship in ships_of_note(voyage):
        look, values = by_id[ship.id], getattr(ship, field)
        ax.plot(
            voyage.minutes, values, color=look.colour, lw=1.2, marker=look.marker, ms=4.5,
            mec="white", mew=0.4, markevery=list(at),
        )  # fmt: skip


def _bars(ax: Axes, voyage: Series, k: int, span: TimeSeries) -> None:
    by_id = ship_styles(voyage)
    here = [s for s in ships_of_note(voyage) if np.isfinite(s.priority[k])]
    rows = [
        ("waypoint", voyage.priority_waypoint[k], WAYPOINT_INK),
        *((by_id[s.id].label, s.priority[k], by_id[s.id].colour) for s in here),
        ("all ships", voyage.priority_collision[k], "#b8bfc6"),
    ]
    places = np.arange(len(rows))[::-1]
    ax.barh(places, [r[1] for r in rows], color=[r[2] for r in rows], height=0.62)
    ax.axvline(0, color=SOFT, lw=0.7)
    ax.set_yticks(places, [r[0] for r in rows])
    ax.tick_params(axis="y", length=0)
    ax.set_xlim(*span)
    if _spread(voyage) > WIDE:
        ax.set_xscale("symlog", linthresh=1.0)
        ax.set_xlim(span[0], 40.0 * span[1])
        plain_powers(ax.xaxis)
    else:
        ax.xaxis.set_major_locator(MaxNLocator(5))
    for place, (_, value, _) in zip(places, rows, strict=True):
        ax.annotate(
            signed(value), (value, place), xytext=(4 if value >= 0 else -4, 0),
            textcoords="offset points", ha="left" if value >= 0 else "right", va="center",
            fontsize=7.5,
        )  # fmt: skip
    ax.set_xlabel(f"priority [reward]: worse ← than {_reference(voyage)} → better")
    ax.set_title("Priorities")
    ax.spines["left"].set_visible(False)


def _reference(voyage: Series) -> str:
    """What the choice is compared with (Eq. 22)."""
    compares = any(frame.manoeuvre is not None for frame in voyage.frames)
    return "keeping on" if compares else "rudder 0"


def plain_powers(axis: Axis) -> None:
    """Few ticks, in plain digits."""
    axis.set_major_locator(FixedLocator([-1000.0, -10.0, 0.0, 10.0, 1000.0]))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}".replace("-", "−")))


def _spread(voyage: Series) -> float:
    """The largest priority, as a size."""
    both = np.concatenate([voyage.priority_waypoint, voyage.priority_collision])
    return float(np.nanmax(np.abs(both), initial=0.0))


def signed(value: float) -> str:
    """Three decimals, one from ten on, with a sign; a rounded zero has none."""
    text = f"{value:+.3f}" if abs(value) < 10.0 else f"{value:+.1f}"
    return "0.000" if float(text) == 0 else text.replace("-", "\u2212")


def _span(voyage: Series, chosen: Sequence[int]) -> TimeSeries:
    """One scale for the bars of all instants, with room for their numbers."""
    rows = [voyage.priority_waypoint, voyage.priority_collision]
    rows += [s.priority for s in ships_of_note(voyage)]
    values = np.array([0.0, *(r[k] for r in rows for k in chosen if np.isfinite(r[k]))])
    room = 0.28 * max(float(np.ptp(values)), 1e-4)
    return np.array([values.min() - room, values.max() + room])
