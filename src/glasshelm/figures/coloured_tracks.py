"""Figures 9, 13 and 14, and their like: tracks coloured by what is made of each ship."""

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.colors import Colormap, Normalize, SymLogNorm
from matplotlib.figure import Figure

from glasshelm.figures import maps
from glasshelm.figures.priorities import WIDE, plain_powers
from glasshelm.figures.style import legend_below, new_figure, one_hue, ship_styles, styled, two_hues
from glasshelm.figures.trajectories import panels
from glasshelm.frames.series import Frames, Series, ShipSeries, TimeSeries, ships_of_note, to_series

DANGER = one_hue("danger", "#8f1d14")
ATTENTION = one_hue("attention", "#0b3c78")
MOVES = two_hues("moves", "#9c4a00", "#00594f")
INTENTION = two_hues("intention", "#b35806", "#3f1d74")


@dataclasses.dataclass(frozen=True)
class Colouring:
    """A quantity of each ship, and the colours that tell it."""

    of: Callable[[ShipSeries], TimeSeries]
    label: str
    cmap: Colormap
    norm: Normalize


@styled
def danger(frames: Frames) -> Figure | None:
    """Figure 9: relative tracks coloured by the critic's evaluation Q_ca; darker = more danger.

    Danger is Q_far − Q_ca, how much lower the critic values a ship than one far
    off (negative: higher, drawn as none). None if the pilot has no critic.
    """
    voyage = to_series(frames)
    if not voyage.has("q") or not voyage.has("q_far"):
        return None
    top = _top([s.critic_danger for s in voyage.ships])
    colouring = Colouring(
        lambda s: s.critic_danger,
        "danger by the critic, Q far off − Q [reward]",
        DANGER,
        Normalize(0, top),
    )
    figure = new_figure(5.4, 5.3)
    ax = figure.add_subplot()
    _draw(ax, voyage, colouring, relative=True)
    _finish(figure, [ax], voyage, colouring, own=False)
    return figure


@styled
def value_panels(voyages: Sequence[Frames]) -> Figure | None:
    """Figure 9 of several voyages: relative tracks coloured by Q_ca itself; lower = darker.

    One scale for all of them. It is logarithmic where the values span more than a few points.
    None if the pilot has no critic.
    """
    series = [to_series(frames) for frames in voyages]
    ships = [ship for voyage in series for ship in voyage.ships]
    values = np.concatenate([ship.q for ship in ships]) if ships else np.array([])
    values = values[np.isfinite(values)]
    if not values.size:
        return None
    low, high = np.quantile(values, (0.01, 1.0))
    high = max(float(high), float(low) + 1e-3)
    wide = high - low > WIDE
    norm = SymLogNorm(1.0, vmin=float(low), vmax=high) if wide else Normalize(float(low), high)
    colouring = Colouring(
        lambda s: s.q, "value of the ship to the critic, Q [reward]", DANGER.reversed(), norm
    )
    figure = panels(
        series,
        lambda ax, voyage, title: _draw(ax, voyage, colouring, True, title),
        own=False,
        coloured=False,
    )
    bar = _bar(figure, [ax for ax in figure.axes if ax.get_visible()], colouring, "min")
    if wide:
        plain_powers(bar.ax.yaxis)
    return figure


@styled
def attention(frames: Frames) -> Figure | None:
    """Figure 13: tracks north-up and relative, coloured by attention (Eq. 23).

    None if the pilot has no attention.
    """
    voyage = to_series(frames)
    if not voyage.has("attention"):
        return None
    colouring = Colouring(
        lambda s: s.attention, "attention, share of 1", ATTENTION, Normalize(0, 1)
    )
    return _both(voyage, colouring)


@styled
def intention(frames: Frames, level: bool = False) -> Figure | None:
    """Figure 14: tracks north-up and relative, coloured by intention (Eq. 24).

    The journal's reading, increment of Q_ca × attention, is signed: violet where
    the chosen rudder improves matters with this ship, orange where it worsens
    them. ``level`` draws the preprint's Q_ca × attention instead. None if the
    pilot has no attention.
    """
    voyage = to_series(frames)
    field = "intention_level" if level else "intention"
    if not voyage.has(field):
        return None
    if level:
        top = _top([-s.intention_level for s in voyage.ships])
        colouring = Colouring(
            lambda s: -s.intention_level, "intention, −Q × attention [reward]", DANGER,
            Normalize(0, top),
        )  # fmt: skip
    else:
        top = _top([np.abs(s.intention) for s in voyage.ships])
        colouring = Colouring(
            lambda s: s.intention, "intention, increment of Q × attention [reward]", INTENTION,
            Normalize(-top, top),
        )  # fmt: skip
    return _both(voyage, colouring)


@styled
def shapley_tracks(frames: Frames) -> Figure | None:
    """Tracks coloured by each ship's Shapley value of the rudder: how far she moves it, and where.

    Green where she moves it to starboard, brown to port. None if the frames have no
    Shapley values.
    """
    voyage = to_series(frames)
    if not voyage.has("shapley_rad"):
        return None
    top = _top([np.degrees(np.abs(s.shapley_rad)) for s in voyage.ships])
    colouring = Colouring(
        lambda s: np.degrees(s.shapley_rad), "port ← rudder moved by this ship [°] → starboard",
        MOVES, Normalize(-top, top),
    )  # fmt: skip
    return _both(voyage, colouring)


def _both(voyage: Series, colouring: Colouring) -> Figure:
    figure = new_figure(8.6, 4.7)
    left, right = figure.subplots(1, 2)
    _draw(left, voyage, colouring, relative=False)
    _draw(right, voyage, colouring, relative=True)
    _finish(figure, [left, right], voyage, colouring, own=True)
    return figure


def _draw(ax: Axes, voyage: Series, colouring: Colouring, relative: bool, title: str = "") -> None:
    at, step = maps.marks(voyage)
    if relative:
        maps.frame_relative(ax, voyage)
        maps.draw_domain(ax, voyage.frames[0].ship)
        ax.set_title(title or f"Seen from own ship, a marker every {step:g} min")
    else:
        maps.draw_own(ax, voyage, at)
        maps.frame_absolute(ax, voyage)
        ax.set_title("Tracks, own ship's minutes numbered")
    maps.draw_others(ax, voyage, relative)
    by_id = ship_styles(voyage)
    for ship in ships_of_note(voyage):
        maps.draw_valued(
            ax, *maps.track(ship, relative), colouring.of(ship), at, by_id[ship.id].marker,
            colouring.cmap, colouring.norm,
        )  # fmt: skip


def _finish(
    figure: Figure, axes: list[Axes], voyage: Series, colouring: Colouring, own: bool
) -> None:
    _bar(figure, axes, colouring, _extend(voyage, colouring))
    handles = maps.ship_handles(voyage, coloured=False)
    legend_below(figure, [maps.own_handle(), *handles] if own else handles)


def _bar(figure: Figure, axes: list[Axes], colouring: Colouring, extend: str) -> Colorbar:
    bar = figure.colorbar(
        ScalarMappable(colouring.norm, colouring.cmap),
        ax=axes, label=colouring.label, shrink=0.8, aspect=28, pad=0.015, extend=extend,
    )  # fmt: skip
    bar.outline.set_visible(False)  # type: ignore[attr-defined]
    return bar


def _top(rows: list[TimeSeries]) -> float:
    """Where the scale ends: all but the most extreme hundredth lies below. Never zero."""
    values = np.concatenate(rows)
    values = values[np.isfinite(values) & (values > 0)]
    return max(float(np.quantile(values, 0.99)), 1e-4) if values.size else 1e-3


def _extend(voyage: Series, colouring: Colouring) -> str:
    """Which ends of the colour bar carry an arrow: values lie beyond them."""
    values = np.concatenate([colouring.of(ship) for ship in voyage.ships])
    low = bool(np.nanmin(values) < colouring.norm.vmin)
    high = bool(np.nanmax(values) > colouring.norm.vmax)
    return {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[(low, high)]
