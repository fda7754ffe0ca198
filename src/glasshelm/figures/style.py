"""How every figure looks: type, inks, one colour and one marker a ship, and how it is saved.

Colours are Okabe and Ito's (2008), told apart by readers with any colour vision;
a marker goes with each, so that grey prints work too. The values of a critic
are drawn in one hue that darkens with the value.
"""

import dataclasses
import functools
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MultipleLocator

from glasshelm.core.output_dir import atomic_write
from glasshelm.frames.series import Series, ships_of_note
from glasshelm.ship.nomoto import NAUTICAL_MILE_M

INK = "#1b1f24"
SOFT = "#6b7480"
FAINT = "#d5dade"
#: The sub-tasks that are not one ship.
WAYPOINT_INK = "#1b1f24"
SUM_INK = "#6b7480"

_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_MARKERS = ("s", "^", "D", "v", "P", "X")

RC: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "axes.titlesize": 9,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 8.5,
    "axes.labelcolor": INK,
    "axes.edgecolor": SOFT,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "text.color": INK,
    # A name is text, whatever signs are in it.
    "text.parse_math": False,
    "text.usetex": False,
    "axes.formatter.use_mathtext": False,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "grid.color": FAINT,
    "grid.linewidth": 0.6,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "lines.linewidth": 1.4,
    "lines.solid_capstyle": "round",
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "pdf.fonttype": 42,
    "svg.fonttype": "path",
    "svg.hashsalt": "glasshelm",
}

P = ParamSpec("P")
Drawn = TypeVar("Drawn")


def styled(draw: Callable[P, Drawn]) -> Callable[P, Drawn]:
    """A drawing function that works in our style and leaves matplotlib's settings alone."""

    @functools.wraps(draw)
    def inside(*args: P.args, **kwargs: P.kwargs) -> Drawn:
        with mpl.rc_context(RC):
            return draw(*args, **kwargs)

    return inside


@dataclasses.dataclass(frozen=True)
class ShipStyle:
    """How one ship is drawn, the same in every figure of a voyage."""

    colour: str
    marker: str
    label: str

    def handle(self) -> Line2D:
        """The legend's entry for a line that looks so."""
        return Line2D(
            [], [], color=self.colour, lw=1.4, marker=self.marker, ms=5, mec="white", mew=0.5,
            label=self.label,
        )  # fmt: skip


def line_style(number: int, name: str) -> ShipStyle:
    """How the ``number``-th of several lines is drawn; thirty look different."""
    return ShipStyle(
        _COLOURS[number % len(_COLOURS)],
        _MARKERS[(number + number // len(_COLOURS)) % len(_MARKERS)],
        shorten(name),
    )


def ship_styles(voyage: Series) -> dict[str, ShipStyle]:
    """Colour, marker and label of every ship of note, by her id."""
    ships = ships_of_note(voyage)
    return {
        ship.id: ShipStyle(
            _COLOURS[k % len(_COLOURS)], _MARKERS[k % len(_MARKERS)], shorten(ship.name)
        )
        for k, ship in enumerate(ships)
    }


def shorten(name: str, most: int = 22) -> str:
    """A name that fits into a legend."""
    return name if len(name) <= most else name[: most - 1].rstrip() + "…"


def new_figure(width_in: float, height_in: float) -> Figure:
    """An empty figure that lays itself out; apart from pyplot, so any thread may draw."""
    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def nm(metres: np.ndarray) -> np.ndarray:
    """Metres as nautical miles."""
    return metres / NAUTICAL_MILE_M


def one_hue(name: str, dark: str) -> Colormap:
    """A map from a pale grey that still shows on white to a dark ink: stronger = darker."""
    return LinearSegmentedColormap.from_list(name, ["#dde1e5", dark])


def two_hues(name: str, low: str, high: str) -> Colormap:
    """A map for values of both signs: pale grey at zero, one hue each way."""
    return LinearSegmentedColormap.from_list(name, [low, "#dde1e5", high])


def nice_minutes(span_min: float, parts: int = 10) -> float:
    """A round interval that cuts a span into ``parts`` at most."""
    for step in (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 240.0):
        if span_min / step <= parts:
            return step
    return 480.0


def time_axis(ax: Axes, voyage: Series, label: bool = True) -> None:
    """Minutes since the start along x; says when the start was, if known."""
    span = float(voyage.minutes[-1])
    ax.set_xlim(0, max(span, 1e-3))
    ax.xaxis.set_major_locator(MultipleLocator(nice_minutes(span)))
    if label:
        start = voyage.start_utc
        since = "" if start is None else f" after {start:%H:%M:%S} UTC"
        ax.set_xlabel(f"time [min]{since}")


def legend_below(figure: Figure, handles: list[Line2D]) -> None:
    """One legend for the whole figure under it, in as many columns as its labels allow."""
    if not handles:
        return
    widest = max(len(str(h.get_label())) for h in handles)
    columns = int(figure.get_figwidth() / (0.47 + 0.07 * widest))
    figure.legend(
        handles=handles, loc="outside lower center", ncols=max(1, min(columns, len(handles)))
    )


@styled
def save(figure: Figure, stem: Path) -> list[Path]:
    """Write ``stem.pdf`` (vector) and ``stem.png`` (200 dpi), alike for the same frames."""
    _settle(figure)
    pdf, png = stem.with_suffix(".pdf"), stem.with_suffix(".png")
    with atomic_write(pdf) as partial:
        figure.savefig(partial, metadata={"CreationDate": None})
    with atomic_write(png) as partial:
        figure.savefig(partial, dpi=200)
    return [pdf, png]


@styled
def as_svg(figure: Figure) -> bytes:
    """The figure as SVG, letters as outlines, so that it looks the same everywhere."""
    out = io.BytesIO()
    _settle(figure)
    figure.savefig(out, format="svg", metadata={"Date": None})
    return out.getvalue()


def _settle(figure: Figure) -> None:
    """Lay the figure out once; every format then finds the same places at once."""
    if figure.get_layout_engine() is not None:
        figure.draw_without_rendering()
        figure.set_layout_engine("none")
