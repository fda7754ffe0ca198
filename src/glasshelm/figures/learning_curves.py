"""How pilots learned: intrusions and return on the fixed validation set while they were trained."""

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from glasshelm.figures.style import legend_below, line_style, new_figure, styled


@dataclasses.dataclass(frozen=True)
class LearningCurve:
    """Validations of one training, in order: steps so far, share of intrusions, mean return."""

    name: str
    env_steps: Float[np.ndarray, " t"]
    intrusions: Float[np.ndarray, " t"]
    returns: Float[np.ndarray, " t"]


@styled
def learning_curves(curves: Sequence[LearningCurve]) -> Figure:
    """Intrusions and return over the steps of the environment, a line a training."""
    figure = new_figure(8.6, 3.5)
    left, right = figure.subplots(1, 2)
    looks = [line_style(number, curve.name) for number, curve in enumerate(curves)]
    for curve, look in zip(curves, looks, strict=True):
        for ax, values in ((left, curve.intrusions), (right, curve.returns)):
            ax.plot(
                curve.env_steps / 1e6, values, color=look.colour, lw=1.2, marker=look.marker,
                ms=4.5, mec="white", mew=0.4, markevery=max(1, len(values) // 12),
            )  # fmt: skip
    left.set_ylim(0, 1)
    left.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    left.set_title("Encounters with an intrusion in 1200 s")
    right.set_title("Return over 1200 s")
    for ax in (left, right):
        ax.set_xlabel("steps of the environment [million]")
        ax.set_xscale("log")
        ax.grid(True, axis="y")
    legend_below(figure, [look.handle() for look in looks])
    return figure
