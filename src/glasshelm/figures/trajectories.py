"""Figures 7 and 8: trajectories north-up, and relative to own ship with her domain."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from glasshelm.figures import maps
from glasshelm.figures.style import INK, SOFT, legend_below, new_figure, nm, ship_styles, styled
from glasshelm.frames.series import Frames, Series, ships_of_note, to_series
from glasshelm.ship.nomoto import NAUTICAL_MILE_M

#: Maps in a row of a figure of several voyages.
PER_ROW = 3


@styled
def absolute(frames: Frames) -> Figure:
    """Figure 7: the tracks of all ships north-up, markers at equal times.

    Own ship's markers are open and carry the minutes, the others' are filled.
    The closest approach is drawn as a line between the two ships.
    """
    voyage = to_series(frames)
    figure = new_figure(5.4, 5.6)
    ax = figure.add_subplot()
    draw_absolute(ax, voyage)
    legend_below(figure, [maps.own_handle(), *maps.ship_handles(voyage)])
    return figure


@styled
def relative(frames: Frames) -> Figure | None:
    """Figure 8: the targets' tracks in own ship's body frame, with the domain (Eq. 14-15).

    None if there is no other ship.
    """
    voyage = to_series(frames)
    if not voyage.ships:
        return None
    figure = new_figure(5.4, 5.6)
    ax = figure.add_subplot()
    draw_relative(ax, voyage)
    legend_below(figure, maps.ship_handles(voyage))
    return figure


@styled
def absolute_panels(voyages: Sequence[Frames]) -> Figure:
    """Figure 7 of several voyages, side by side."""
    return panels(voyages, draw_absolute)


@styled
def relative_panels(voyages: Sequence[Frames]) -> Figure:
    """Figure 8 of several voyages, side by side."""
    return panels(voyages, draw_relative, own=False)


def panels(
    voyages: Sequence[Frames],
    draw: Callable[[Axes, Series, str], None],
    own: bool = True,
    coloured: bool = True,
) -> Figure:
    """A map a voyage, three in a row, each with its number and source, and one legend for all.

    Args:
        voyages: A ship has the colour and marker of its place in the order.
        draw: Draws one on given axes, with a title.
        own: Whether own ship's track is in the maps.
        coloured: Whether a track has its ship's colour.
    """
    series = [to_series(frames) for frames in voyages]
    rows = -(-len(series) // PER_ROW)
    figure = new_figure(9.6, 3.35 * rows + 0.4)
    axes = figure.subplots(rows, PER_ROW, squeeze=False).ravel()
    for number, (ax, voyage) in enumerate(zip(axes, series, strict=False), start=1):
        _, step = maps.marks(voyage)
        draw(ax, voyage, f"{number}: {voyage.frames[0].source}, every {step:g} min")
        if not own:
            ax.set_xlabel("across own ship, starboard + [NM]")
    for ax in axes[len(series) :]:
        ax.set_visible(False)
    most = max(series, key=lambda voyage: len(voyage.ships))
    handles = maps.ship_handles(most, coloured)
    legend_below(figure, [maps.own_handle(), *handles] if own else handles)
    return figure


def draw_absolute(ax: Axes, voyage: Series, title: str = "") -> None:
    """The north-up map of figure 7 on given axes."""
    at, step = maps.marks(voyage)
    maps.draw_others(ax, voyage, relative=False)
    by_id = ship_styles(voyage)
    for ship in ships_of_note(voyage):
        maps.draw_track(ax, *maps.track(ship, False), at, by_id[ship.id])
    maps.draw_own(ax, voyage, at)
    maps.frame_absolute(ax, voyage)
    _closest(ax, voyage)
    _waypoint(ax, voyage)
    ax.set_title(title or f"Tracks, a marker every {step:g} min (own ship's numbered)")


def draw_relative(ax: Axes, voyage: Series, title: str = "") -> None:
    """The body-frame map of figure 8 on given axes."""
    at, step = maps.marks(voyage)
    maps.frame_relative(ax, voyage)
    maps.draw_domain(ax, voyage.frames[0].ship)
    maps.draw_others(ax, voyage, relative=True)
    by_id = ship_styles(voyage)
    for ship in ships_of_note(voyage):
        maps.draw_track(ax, *maps.track(ship, True), at, by_id[ship.id])
    ax.set_title(title or f"Seen from own ship, a marker every {step:g} min")


def _closest(ax: Axes, voyage: Series) -> None:
    """A line across the closest approach of all, with its length."""
    if not voyage.ships:
        return
    ship = min(voyage.ships, key=lambda s: float(np.nanmin(s.range_m)))
    k = ship.nearest
    x = nm(np.array([voyage.east_m[k], ship.east_m[k]]))
    y = nm(np.array([voyage.north_m[k], ship.north_m[k]]))
    ax.plot(x, y, color=INK, lw=1.0, ls=(0, (1.5, 1.5)), zorder=4.5)
    side = _clearer_side(ax, voyage, x, y)
    ax.annotate(
        f"{ship.range_m[k] / NAUTICAL_MILE_M:.2f} NM",
        (x.mean(), y.mean()),
        xytext=(6 * side[0], 9 * side[1]),
        textcoords="offset points",
        ha="left" if side[0] > 0.3 else "right" if side[0] < -0.3 else "center",
        va="center",
        fontsize=7.5,
        path_effects=maps.HALO,
        zorder=7,
    )


def _clearer_side(ax: Axes, voyage: Series, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The direction square to a line on which its label stays clearer of all tracks."""
    along = np.array([np.diff(x)[0], np.diff(y)[0]])
    square = np.array([along[1], -along[0]]) / max(float(np.linalg.norm(along)), 1e-9)
    tracks = [(voyage.east_m, voyage.north_m), *((s.east_m, s.north_m) for s in voyage.ships)]
    points = np.concatenate([np.stack([nm(e), nm(n)], -1) for e, n in tracks])
    reach = 0.045 * float(np.diff(ax.get_ylim())[0])

    def room(side: np.ndarray) -> float:
        label = np.array([x.mean(), y.mean()]) + reach * side
        return float(np.nanmin(np.hypot(*(points - label).T)))

    return max((square, -square), key=room)


def _waypoint(ax: Axes, voyage: Series) -> None:
    """The waypoint where it is in the map; else its bearing and distance from the track's end."""
    waypoint = voyage.frames[-1].waypoint
    x, y = waypoint.east_m / NAUTICAL_MILE_M, waypoint.north_m / NAUTICAL_MILE_M
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    if left <= x <= right and low <= y <= high:
        ax.plot([x], [y], marker="*", ms=10, color=SOFT, ls="", zorder=4)
        ax.annotate("waypoint", (x, y), xytext=(7, 0), textcoords="offset points", fontsize=7.5,
                    va="center", color=SOFT)  # fmt: skip
        return
    east = x - voyage.east_m[-1] / NAUTICAL_MILE_M
    north = y - voyage.north_m[-1] / NAUTICAL_MILE_M
    bearing = round(np.degrees(np.arctan2(east, north))) % 360
    ax.text(
        0.99, 0.99, f"waypoint {bearing:03d}°, {np.hypot(east, north):.1f} NM", fontsize=7.5,
        color=SOFT, ha="right", va="top", transform=ax.transAxes, path_effects=maps.HALO, zorder=7,
    )  # fmt: skip
