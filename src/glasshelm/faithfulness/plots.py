"""The exam as one figure: every explanation's scores with their intervals."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from glasshelm.faithfulness.exam import Examined
from glasshelm.faithfulness.tables import DECIDING, HEADERS, score_of
from glasshelm.figures.style import INK, SOFT, new_figure, styled

_COLOURS = {"paper": "#0072B2", "ours": "#009E73", "null": SOFT}
_SAID = {
    "paper": "the paper's",
    "ours": "by asking the actor again",
    "null": "knows nothing of the pilot",
}


@styled
def scores_figure(seeds: Sequence[Examined], name: str) -> Figure:
    """One panel a measure, one row an explanation: mean and 95 % interval; right is truer."""
    explainers = seeds[0].explainers
    rows = np.arange(len(explainers))[::-1]
    figure = new_figure(8.4, 0.9 + 0.24 * len(explainers))
    axes = figure.subplots(1, len(DECIDING), sharey=True)
    for ax, measure in zip(axes, DECIDING, strict=True):
        ax.axvline(0, color=SOFT, lw=0.7)
        for row, explainer in zip(rows, explainers, strict=True):
            value, low, high = score_of(seeds, explainer.name, measure)
            if np.isfinite(value):
                colour = _COLOURS[explainer.kind]
                ax.plot([low, high], [row, row], color=colour, lw=1.4)
                ax.plot(value, row, "o", color=colour, ms=4)
        ax.set_xlim(-1.05, 1.05)
        ax.set_title(HEADERS[measure], fontsize=8)
        ax.grid(axis="x")
    axes[0].set_yticks(rows, [e.title for e in explainers])
    for kind, colour in _COLOURS.items():
        axes[-1].plot([], [], "o-", color=colour, ms=4, label=_SAID[kind])
    figure.legend(loc="outside lower center", ncols=3)
    figure.suptitle(
        f"Which explanations of {name} are true", color=INK, fontsize=9, x=0.01, ha="left"
    )
    return figure
