"""The result of the exam in words and tables: which explanation tells the truth about the pilot."""

from collections.abc import Sequence

import numpy as np

from glasshelm.faithfulness.exam import MEASURES, Examined, mean_with_interval

HEADERS = {
    "kendall": "τ_b with φ",
    "top": "same first ship",
    "sign": "right side",
    "deletion": "deletion",
    "insertion": "insertion",
    "infidelity": "infidelity",
    "simulated": "ρ with simulation",
    "sensitivity": "sensitivity",
    "forgotten": "ρ after forgetting",
}
#: Measures of truth by which the verdict is given: larger is better.
DECIDING = ("kendall", "deletion", "insertion", "simulated")

Seeds = Sequence[Examined]


def report(name: str, seeds: Seeds, command: str, machine: str) -> str:
    """The table of one pilot (its training seeds together) and the verdict."""
    first = seeds[0]
    scenes = sum(len(s.voyage) for s in seeds)
    voyages = sum(len(np.unique(s.voyage)) for s in seeds)
    hashes = ", ".join(f"`{(s.pilot.weights_sha256 or '')[:8]}`" for s in seeds)
    own = np.mean([np.median(s.own_sensitivity) for s in seeds])
    plural = "s" if len(seeds) > 1 else ""
    lines = [
        f"## {name}",
        "",
        f"{scenes:,} scenes of {voyages:,} voyages, {len(seeds)} seed{plural}. Weights (SHA-256): "
        f"{hashes}. {machine}. `{command}`",
        "",
        "| explanation | " + " | ".join(HEADERS[m] for m in MEASURES) + " |",
        "|---|" + "---|" * len(MEASURES),
    ]
    for explainer in first.explainers:
        cells = [_cell(seeds, explainer.name, measure) for measure in MEASURES]
        lines.append(f"| {explainer.title} | " + " | ".join(cells) + " |")
    lines += [
        "",
        f"The rudder's own sensitivity: {own:.2f} (median). In brackets 95 % intervals.",
        "",
        *(f"- {sentence}" for sentence in verdicts(seeds)),
    ]
    return "\n".join(lines) + "\n"


def _cell(seeds: Seeds, explainer: str, measure: str) -> str:
    if measure == "sensitivity":
        middle = np.median(np.concatenate([s.told[explainer][measure] for s in seeds]))
        return f"{middle:.2f}"
    value, low, high = score_of(seeds, explainer, measure)
    if not np.isfinite(value):
        return "–"
    return f"{value:.2f} [{low:.2f}, {high:.2f}]"


def score_of(seeds: Seeds, explainer: str, measure: str) -> tuple[float, float, float]:
    """The mean of a measure and its interval."""
    return mean_with_interval(
        [np.asarray(s.told[explainer][measure]) for s in seeds], [s.voyage for s in seeds]
    )


def verdicts(seeds: Seeds) -> list[str]:
    """Does each explanation of the paper tell more than the CPA figures alone? In words."""
    names = {e.name: e.title for e in seeds[0].explainers}
    said = []
    for explainer in ("attention", "danger", "priority", "intention", "intention_level"):
        if explainer in names:
            said.append(_against(seeds, explainer, "cpa", names))
    best = max(
        (e.name for e in seeds[0].explainers if e.name != "shapley"),
        key=lambda e: np.nanmean([score_of(seeds, e, m)[0] for m in DECIDING]),
    )
    said.append(f"Next to the Shapley value of the rudder itself, the truest is: {names[best]}.")
    return said


def _against(seeds: Seeds, ours: str, null: str, names: dict[str, str]) -> str:
    better, worse = [], []
    for measure in DECIDING:
        gaps = [np.asarray(s.told[ours][measure]) - s.told[null][measure] for s in seeds]
        _, low, high = mean_with_interval(gaps, [s.voyage for s in seeds])
        if low > 0:
            better.append(HEADERS[measure])
        elif high < 0:
            worse.append(HEADERS[measure])
    title, other = names[ours], names[null]
    if better and not worse:
        return f"{title} tells more of the pilot than {other} ({', '.join(better)})."
    if worse and not better:
        return f"{title} tells **less** of the pilot than {other} ({', '.join(worse)})."
    if better and worse:
        return (
            f"{title} against {other}: better in {', '.join(better)}, worse in {', '.join(worse)}."
        )
    return f"{title} and {other}: no difference that these scenes show."
