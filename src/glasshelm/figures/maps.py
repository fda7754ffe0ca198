"""The two maps that figures share: north-up with tracks, and own ship's body frame.

Both have equal scales along x and y, tracks with markers at equal times (the
same times for every ship), own ship's markers open, the others' filled.
"""

import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Colormap, Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon
from matplotlib.transforms import Affine2D

from glasshelm.figures.style import FAINT, INK, SOFT, ShipStyle, nice_minutes, nm, ship_styles
from glasshelm.frames.schema import Ship
from glasshelm.frames.series import Series, ShipSeries, TimeSeries, ships_of_note
from glasshelm.ship.domain import AHEAD_LOA, ASTERN_LOA, PORT_LOA, STARBOARD_LOA
from glasshelm.ship.nomoto import NAUTICAL_MILE_M

#: A white rim that keeps small print readable over lines.
HALO = [patheffects.withStroke(linewidth=2.2, foreground="white")]
#: Tracks farther off than own ship's run do not widen a map, within these limits; they run out.
REACH_NM = (2.0, 5.0)
#: At most so many of own ship's markers carry their minutes.
MOST_LABELS = 5


def domain_outline(loa_m: float, points: int = 181) -> np.ndarray:
    """The edge of the ship domain (Eq. 14-15) as [points, 2] (starboard, ahead) in metres."""
    angle = np.linspace(0, 2 * np.pi, points)
    across, along = np.sin(angle), np.cos(angle)
    x = across * np.where(across >= 0, STARBOARD_LOA, PORT_LOA) * loa_m
    y = along * np.where(along >= 0, AHEAD_LOA, ASTERN_LOA) * loa_m
    return np.stack([x, y], axis=-1)


def hull_outline(length_m: float, beam_m: float) -> np.ndarray:
    """A ship seen from above, bow up, to scale: [5, 2] (starboard, ahead) in metres."""
    half, bow = beam_m / 2, length_m / 2
    return np.array(
        [[-half, -bow], [half, -bow], [half, 0.55 * bow], [0, bow], [-half, 0.55 * bow]]
    )


def marks(voyage: Series) -> tuple[np.ndarray, float]:
    """Frames at equal times (indices) and the interval between them [min]."""
    step = nice_minutes(float(voyage.minutes[-1]))
    times = np.arange(0, voyage.minutes[-1] + 1e-6, step)
    return np.unique([np.argmin(np.abs(voyage.minutes - t)) for t in times]), step


def draw_own(ax: Axes, voyage: Series, at: np.ndarray, labels: bool = True) -> None:
    """Own ship's track with open markers, some of them with the minutes."""
    x, y = nm(voyage.east_m), nm(voyage.north_m)
    ax.plot(x, y, color=INK, lw=1.6, zorder=4)
    draw_arrow(ax, x, y, INK)
    ax.plot(x[at], y[at], ls="", marker="o", ms=5, mfc="white", mec=INK, mew=1.1, zorder=5)
    if not labels:
        return
    for k in at[:: -(-len(at) // MOST_LABELS)]:
        side = voyage.heading_rad[k] + np.pi / 2
        ax.annotate(
            f"{voyage.minutes[k]:g}",
            (x[k], y[k]),
            xytext=(9 * np.sin(side), 9 * np.cos(side)),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=7,
            color=SOFT,
            path_effects=HALO,
            zorder=6,
        )


def draw_track(ax: Axes, x: TimeSeries, y: TimeSeries, at: np.ndarray, look: ShipStyle) -> None:
    """One target's track with filled markers."""
    ax.plot(x, y, color=look.colour, lw=1.4, zorder=3)
    draw_arrow(ax, x, y, look.colour)
    ax.plot(
        x[at], y[at], ls="", marker=look.marker, ms=5, color=look.colour, mec="white", mew=0.5,
        zorder=3.5,
    )  # fmt: skip


def draw_valued(
    ax: Axes, x: TimeSeries, y: TimeSeries, value: TimeSeries, at: np.ndarray, marker: str,
    cmap: Colormap,
    norm: Normalize,
) -> None:  # fmt: skip
    """One target's track coloured by a value along it; a hairline where the value is absent."""
    ax.plot(x, y, color="#b8bfc6", lw=0.5, zorder=2)
    draw_arrow(ax, x, y, SOFT)
    pieces, values = _pieces(x, y, value, norm)
    lines = LineCollection(pieces, cmap=cmap, norm=norm, linewidths=2.6, capstyle="round", zorder=3)
    lines.set_array(values)
    ax.add_collection(lines, autolim=False)
    shown = at[np.isfinite(x[at]) & np.isfinite(value[at])]
    ax.scatter(
        x[shown], y[shown], c=value[shown], cmap=cmap, norm=norm, marker=marker, s=26,
        edgecolors=INK, linewidths=0.6, zorder=3.5,
    )  # fmt: skip


def _pieces(
    x: TimeSeries, y: TimeSeries, value: TimeSeries, norm: Normalize
) -> tuple[list[np.ndarray], np.ndarray]:
    """A track cut where its colour changes by one of 64 steps: polylines and their values."""
    step = np.round(np.clip(np.asarray(norm(value), float), 0, 1) * 64)
    known = np.isfinite(x) & np.isfinite(y) & np.isfinite(value)
    pieces, values, start = [], [], 0
    for k in range(1, len(x)):
        if not (known[k - 1] and known[k]):
            start = k
        elif k == len(x) - 1 or step[k] != step[start] or not known[k + 1]:
            pieces.append(np.stack([x[start : k + 1], y[start : k + 1]], axis=-1))
            values.append(value[start])
            start = k
    return pieces, np.array(values)


def draw_arrow(ax: Axes, x: TimeSeries, y: TimeSeries, colour: str) -> None:
    """An arrowhead where a track ends, the way the ship was going."""
    known = np.flatnonzero(np.isfinite(x))
    if len(known) < 2:
        return
    end = known[-1]
    start = known[max(len(known) - 4, 0)]
    if np.hypot(x[end] - x[start], y[end] - y[start]) < 1e-4:
        return
    ax.annotate(
        "", (x[end], y[end]), (x[start], y[start]), zorder=4.2,
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 0.1, "mutation_scale": 9,
                    "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip


def draw_others(ax: Axes, voyage: Series, relative: bool) -> int:
    """Tracks of the ships that have no colour of their own, thin and grey; returns how many."""
    noted = {s.id for s in ships_of_note(voyage)}
    others = [s for s in voyage.ships if s.id not in noted]
    for ship in others:
        x, y = (ship.starboard_m, ship.ahead_m) if relative else (ship.east_m, ship.north_m)
        ax.plot(nm(x), nm(y), color="#b8bfc6", lw=0.6, zorder=1.5)
    return len(others)


def draw_domain(
    ax: Axes, ship: Ship, east_nm: float = 0.0, north_nm: float = 0.0, heading_rad: float = 0.0
) -> None:
    """Own ship's hull and domain to scale, at a place and heading."""
    place = Affine2D().rotate(-heading_rad).translate(east_nm, north_nm) + ax.transData
    edge = domain_outline(ship.loa_m) / NAUTICAL_MILE_M
    ax.add_patch(
        Polygon(edge, closed=True, fc="#eef1f4", ec=SOFT, lw=0.9, ls=(0, (4, 2)), zorder=1.2,
                transform=place)
    )  # fmt: skip
    hull = hull_outline(ship.loa_m, ship.beam_m) / NAUTICAL_MILE_M
    ax.add_patch(Polygon(hull, closed=True, fc="white", ec=INK, lw=0.9, zorder=5, transform=place))


def draw_rings(ax: Axes, reach_nm: float) -> None:
    """Faint range rings with their radius in NM."""
    step = next(s for s in (0.25, 0.5, 1, 2, 3, 5, 10, 20) if reach_nm / s <= 5)
    for radius in np.arange(step, reach_nm * 1.6, step):
        ax.add_patch(Circle((0, 0), radius, fc="none", ec=FAINT, lw=0.6, zorder=0.5))
        corner = radius * np.sqrt(0.5)
        ax.text(
            corner, -corner, f"{radius:g} NM", fontsize=6.5, color=SOFT, ha="center", va="center",
            rotation=45, path_effects=HALO, zorder=0.6, clip_on=True,
        )  # fmt: skip
    ax.grid(False)


def frame_absolute(ax: Axes, voyage: Series) -> None:
    """Limits and labels of a north-up map: own track, and the others while within reach."""
    xs, ys = [nm(voyage.east_m)], [nm(voyage.north_m)]
    for ship in ships_of_note(voyage):
        close = nm(ship.range_m) <= reach(voyage)
        xs.append(nm(ship.east_m)[close])
        ys.append(nm(ship.north_m)[close])
    limits(ax, np.concatenate(xs), np.concatenate(ys))
    ax.set_xlabel("east [NM]")
    ax.set_ylabel("north [NM]")
    ax.grid(True)


def frame_relative(ax: Axes, voyage: Series) -> None:
    """Limits and labels of the body-frame map, always with the whole domain in it."""
    edge = domain_outline(voyage.frames[0].ship.loa_m) / NAUTICAL_MILE_M * 1.3
    xs, ys = [edge[:, 0]], [edge[:, 1]]
    for ship in ships_of_note(voyage):
        close = nm(ship.range_m) <= min(reach(voyage), 4.0)
        xs.append(nm(ship.starboard_m)[close])
        ys.append(nm(ship.ahead_m)[close])
    x, y = np.concatenate(xs), np.concatenate(ys)
    limits(ax, x, y)
    draw_rings(ax, float(np.hypot(x, y).max()))
    ax.set_xlabel("to port  ←  across own ship [NM]  →  to starboard")
    ax.set_ylabel("ahead of own ship [NM]")


def reach(voyage: Series) -> float:
    """How far off ships still shape a map [NM]: own ship's run, within limits; the nearest."""
    run = float(np.hypot(np.diff(voyage.east_m), np.diff(voyage.north_m)).sum())
    usual = float(np.clip(1.2 * run / NAUTICAL_MILE_M, *REACH_NM))
    nearest = [float(np.nanmin(s.range_m)) for s in ships_of_note(voyage)]
    return max(usual, 1.1 * min(nearest, default=0.0) / NAUTICAL_MILE_M)


def limits(ax: Axes, x: np.ndarray, y: np.ndarray, least_nm: float = 0.5) -> None:
    """A square view of all points, equal scales."""
    half = 0.56 * max(np.ptp(x), np.ptp(y), least_nm)
    middle_x, middle_y = (x.min() + x.max()) / 2, (y.min() + y.max()) / 2
    ax.set_xlim(middle_x - half, middle_x + half)
    ax.set_ylim(middle_y - half, middle_y + half)
    ax.set_aspect("equal")


def own_handle() -> Line2D:
    """The legend's entry for own ship."""
    return Line2D(
        [], [], color=INK, lw=1.6, marker="o", ms=5, mfc="white", mec=INK, label="own ship"
    )


def ship_handles(voyage: Series, coloured: bool = True) -> list[Line2D]:
    """The legend's entries for the targets; grey where colour means a value."""
    out = []
    by_id = ship_styles(voyage)
    for look in by_id.values():
        face = look.colour if coloured else "white"
        edge = "white" if coloured else INK
        line = look.colour if coloured else "#b8bfc6"
        out.append(
            Line2D([], [], color=line, marker=look.marker, ms=5.5, mfc=face, mec=edge,
                   mew=0.6, label=look.label)
        )  # fmt: skip
    left = len(voyage.ships) - len(by_id)
    if left:
        out.append(Line2D([], [], color="#b8bfc6", lw=0.8, label=f"{left} other ships"))
    return out


def track(ship: ShipSeries, relative: bool) -> tuple[TimeSeries, TimeSeries]:
    """A target's track in NM, in own ship's body frame or north-up."""
    if relative:
        return nm(ship.starboard_m), nm(ship.ahead_m)
    return nm(ship.east_m), nm(ship.north_m)
