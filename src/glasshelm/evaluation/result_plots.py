"""Figures of an evaluation: rates by number of ships, nearest distances, the worst voyages."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from glasshelm.core.text import file_name, safe_name
from glasshelm.evaluation.evaluation_run import (
    EvaluationResult,
    results_by_contender,
    stack_seeds,
    suites_of,
)
from glasshelm.evaluation.measure_columns import SuiteResult
from glasshelm.evaluation.statistics import rate_interval
from glasshelm.evaluation.worst_cases import replay_cases, worst_cases
from glasshelm.figures.maps import HALO
from glasshelm.figures.style import (
    INK,
    SOFT,
    ShipStyle,
    legend_below,
    line_style,
    new_figure,
    save,
    styled,
)
from glasshelm.figures.trajectories import draw_absolute
from glasshelm.frames.series import to_series
from glasshelm.ship.nomoto import NAUTICAL_MILE_M

#: Voyages in the figure of the worst.
WORST = 10
Seeds = Sequence[SuiteResult]


def draw_all(evaluation: EvaluationResult, out: Path) -> Iterator[Path]:
    """Draw and write every figure into a folder, each as PDF and PNG; gives the PNGs."""
    for suite in suites_of(evaluation):
        contenders = results_by_contender(evaluation, suite.name)
        for seeds in contenders:
            if (seeds[0].columns["ships"] > 0).any():
                figure = worst_voyages(_worst_seed(seeds))
                who = f"{seeds[0].contender.name}-{seeds[0].contender.ship_name}"
                yield save(figure, out / f"{file_name(suite.name)}_worst_{file_name(who)}")[1]
        for ship_name in dict.fromkeys(s[0].contender.ship_name for s in contenders):
            same = [s for s in contenders if s[0].contender.ship_name == ship_name]
            stem = f"{file_name(suite.name)}_{{}}_{ship_name}"
            counts = np.unique(same[0][0].columns["ships"])
            if suite.size > 100 and len(counts) > 1:
                yield save(rates_by_ships(same), out / stem.format("rates"))[1]
            if (counts > 0).any():
                yield save(nearest_distances(same), out / stem.format("nearest"))[1]


def _worst_seed(seeds: Seeds) -> SuiteResult:
    return max(seeds, key=lambda s: (s.columns["collided"].sum(), s.columns["intruded"].sum()))


def _looks(contenders: Sequence[Seeds]) -> list[ShipStyle]:
    return [line_style(k, seeds[0].contender.name) for k, seeds in enumerate(contenders)]


@styled
def rates_by_ships(contenders: Sequence[Seeds]) -> Figure:
    """Collisions and intrusions by number of ships, with 95 % intervals, on a scale of roots.

    The root keeps a rate of 0 on the figure and parts small rates, as a logarithm would.
    """
    figure = new_figure(7.2, 3.4)
    axes = figure.subplots(1, 2)
    looks = _looks(contenders)
    counts = np.unique(contenders[0][0].columns["ships"])
    beside = min(0.06, 0.5 / len(contenders))
    spread = beside * (np.arange(len(contenders)) - (len(contenders) - 1) / 2)
    for ax, (column, what) in zip(
        axes, (("collided", "Collisions"), ("intruded", "Domain intrusions")), strict=True
    ):
        for seeds, look, aside in zip(contenders, looks, spread, strict=True):
            of_ships = seeds[0].columns["ships"]
            rates = [rate_interval(stack_seeds(seeds, column)[:, of_ships == n]) for n in counts]
            value = np.array([f.value for f in rates])
            error = np.array([[f.value - f.low, f.high - f.value] for f in rates]).T
            ax.errorbar(
                counts + aside, value, yerr=np.maximum(error, 0), color=look.colour,
                marker=look.marker, ms=4.5, mec="white", mew=0.5, lw=0.9, elinewidth=0.9,
                capsize=1.8, zorder=3, clip_on=False,
            )  # fmt: skip
        _root_scale(ax)
        ax.set_xticks(counts)
        ax.set_xlabel("ships")
        ax.set_title(f"{what}, share of encounters")
        ax.grid(True, axis="y")
    legend_below(figure, [look.handle() for look in looks])
    return figure


def _root_scale(ax: Axes) -> None:
    """Shares on a scale of square roots."""
    ax.set_yscale("function", functions=(lambda y: np.sqrt(np.maximum(y, 0.0)), np.square))
    ax.set_ylim(0, 1)
    ax.set_yticks([0, 0.01, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0])
    ax.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))


@styled
def nearest_distances(contenders: Sequence[Seeds]) -> Figure:
    """How many encounters with traffic came nearer than each distance, a line a pilot."""
    figure = new_figure(5.4, 3.6)
    ax = figure.add_subplot()
    looks = _looks(contenders)
    for seeds, look in zip(contenders, looks, strict=True):
        near = stack_seeds(seeds, "nearest_m")
        near = np.sort(near[np.isfinite(near)]) / NAUTICAL_MILE_M
        share = np.arange(1, len(near) + 1) / len(near)
        at = np.searchsorted(near, np.linspace(0.25, 1.75, 4)) - 1
        ax.step(near, share, where="post", color=look.colour, lw=1.3, zorder=3)
        shown = at[at >= 0]
        ax.plot(
            near[shown], share[shown], ls="", marker=look.marker, ms=5, color=look.colour,
            mec="white", mew=0.5, zorder=3.5,
        )  # fmt: skip
    loa = float(np.median(np.asarray(contenders[0][0].suite.cases.ship.loa_m))) / NAUTICAL_MILE_M
    for x, name in ((loa, "LOA"), (0.5, "0.5 NM"), (1.0, "1 NM")):
        ax.axvline(x, color=SOFT, lw=0.8, ls=(0, (3, 2)), zorder=2)
        ax.annotate(
            name, (x, 0.0), xytext=(3, 3), textcoords="offset points", fontsize=7.5, color=SOFT,
            va="bottom", xycoords=("data", "axes fraction"), path_effects=HALO, zorder=6,
        )  # fmt: skip
    ax.set_xlim(0, 2)
    _root_scale(ax)
    ax.set_xlabel("nearest distance of any ship, centre to centre [NM]")
    ax.set_title("Share of encounters in which a ship came nearer")
    ax.grid(True, axis="y")
    legend_below(figure, [look.handle() for look in looks])
    return figure


@styled
def worst_voyages(one: SuiteResult) -> Figure:
    """The tracks of the encounters with the deepest intrusions, worst first."""
    which = worst_cases(one, WORST)
    columns = min(5, len(which))
    rows = math.ceil(len(which) / columns)
    figure = new_figure(2.9 * columns, 3.1 * rows + 0.35)
    axes = np.atleast_1d(figure.subplots(rows, columns, squeeze=False)).ravel()
    for ax, number, frames in zip(axes, which, replay_cases(one, which), strict=False):
        draw_absolute(ax, to_series(frames), _title(one, int(number)))
        _small(ax)
    for ax in axes[len(which) :]:
        ax.set_visible(False)
    name, ship_name = safe_name(one.contender.name), one.contender.ship_name
    figure.suptitle(
        f"{name} on {ship_name}, {one.suite.name}: the {len(which)} worst of "
        f"{one.suite.size:,} encounters (own ship black, minutes beside its track)",
        fontsize=9, color=INK, x=0.005, ha="left",
    )  # fmt: skip
    return figure


def _title(one: SuiteResult, number: int) -> str:
    c = one.columns
    margin = c["margin"][number]
    what = f"depth {margin:.2f}" if margin > 0 else f"clear by {-margin:.2f}"
    what = "collision" if c["collided"][number] else what
    label = safe_name(one.suite.labels[number].split("/")[-1])
    return f"{label}: {what}"


def _small(ax: Axes) -> None:
    ax.tick_params(labelsize=6.5)
    ax.xaxis.label.set_fontsize(7)
    ax.yaxis.label.set_fontsize(7)
    ax.title.set_fontsize(7.5)
