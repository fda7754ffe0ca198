"""One figure: every explanation's scores with their intervals."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from glasshelm.core.text import safe_name
from glasshelm.faithfulness.faithfulness_scores import ExplanationScores
from glasshelm.faithfulness.score_tables import MEASURE_TITLES, NULL, TRUTH_MEASURES, score_of
from glasshelm.figures.style import INK, SOFT, new_figure, styled

_COLOURS = {"paper": "#0072B2", "ours": "#009E73", "null": SOFT}
_SAID = {
    "paper": "the paper's",
    "ours": "by asking the pilot again",
    "null": "knows nothing of the pilot",
}


@styled
def scores_figure(seeds: Sequence[ExplanationScores], name: str) -> Figure:
    """One panel a measure, one row an explanation: mean and 95 % interval; right is truer.

    The dashed line is what DCPA and TCPA alone tell.
    """
    explainers = seeds[0].explainers
    rows = np.arange(len(explainers))[::-1]
    figure = new_figure(8.4, 0.9 + 0.24 * len(explainers))
    axes = figure.subplots(1, len(TRUTH_MEASURES), sharex=True, sharey=True)
    lowest = -0.25
    for ax, measure in zip(axes, TRUTH_MEASURES, strict=True):
        ax.axvline(0, color=SOFT, lw=0.7)
        for row, explainer in zip(rows, explainers, strict=True):
            score = score_of(seeds, explainer.name, measure)
            if np.isfinite(score.value):
                colour = _COLOURS[explainer.kind]
                ax.plot([score.low, score.high], [row, row], color=colour, lw=1.8)
                ax.plot(score.value, row, "o", color=colour, ms=3.5)
                lowest = min(lowest, score.low - 0.05)
                if explainer.name == NULL:
                    ax.axvline(score.value, color=SOFT, lw=0.7, ls="--")
        ax.set_title(MEASURE_TITLES[measure], fontsize=8)
        ax.grid(axis="x")
    axes[0].set_xlim(lowest, 1.05)
    axes[0].set_yticks(rows, [e.title for e in explainers])
    for kind, colour in _COLOURS.items():
        axes[-1].plot([], [], "o-", color=colour, ms=3.5, label=_SAID[kind])
    axes[-1].plot([], [], color=SOFT, lw=0.7, ls="--", label="DCPA and TCPA")
    figure.legend(loc="outside lower center", ncols=4)
    title = f"Which explanations of {safe_name(name)} are true (0: chance, 1: best)"
    figure.suptitle(title, color=INK, fontsize=9, x=0.01, ha="left")
    return figure
