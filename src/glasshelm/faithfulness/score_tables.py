"""The scores in words and tables: which explanation tells the truth about the pilot."""

from collections.abc import Sequence

import numpy as np

from glasshelm.core.text import markdown_code, markdown_text
from glasshelm.evaluation.statistics import (
    ConfidenceInterval,
    clustered_mean,
    clustered_p_value,
    holm,
)
from glasshelm.evaluation.tables import markdown_table, percent
from glasshelm.faithfulness.explainers import Explainer
from glasshelm.faithfulness.faithfulness_scores import MEASURES, ExplanationScores, randomised_top
from glasshelm.faithfulness.manoeuvre_checks import CHECKS, SURPRISES

MEASURE_TITLES = {
    "kendall": "τ_b with φ",
    "top": "same first ship",
    "sign": "right side",
    "deletion": "deletion",
    "insertion": "insertion",
    "infidelity": "infidelity",
    "unscaled_infidelity": "infidelity, c = 1",
    "simulated": "ρ with simulation",
    "sensitivity": "sensitivity",
    "randomised": "ρ after randomising",
}
#: Measures of truth by which the verdict is given: larger is better.
TRUTH_MEASURES = ("kendall", "deletion", "insertion", "simulated")

#: The null that explanations are held against.
NULL = "cpa"

Seeds = Sequence[ExplanationScores]


def scores_report(name: str, seeds: Seeds, command: str, machine: str) -> str:
    """The table of one pilot (its training seeds together) and the conclusions."""
    scenes = sum(len(s.voyage) for s in seeds)
    voyages = sum(len(np.unique(s.voyage)) for s in seeds)
    weights = [getattr(s.pilot, "weights_sha256", None) for s in seeds]
    hashes = ", ".join(f"`{sha256[:8]}`" for sha256 in weights if sha256)
    hashes = f"Weights (SHA-256): {hashes}. " if hashes else ""
    own = np.mean([np.median(s.own_sensitivity) for s in seeds])
    plural = "s" if len(seeds) > 1 else ""
    quantity, layers = seeds[0].subject.quantity, min(s.subject.layers for s in seeds)
    parts = [
        f"## {markdown_text(name)}",
        f"{scenes:,} scenes of {voyages:,} voyages, {len(seeds)} seed{plural}. {hashes}{machine}. "
        f"{markdown_code(command)}",
        f"Ships move the {quantity}: φ is the Shapley value of that, and deletion, insertion and "
        "infidelity are about it.",
        _table(seeds, seeds[0].explainers, MEASURES, [MEASURE_TITLES[m] for m in MEASURES]),
        f"The {quantity}'s own sensitivity: {own:.2f} (median). In brackets 95 % intervals, "
        "each for itself.",
    ]
    if layers:
        learned = [e for e in seeds[0].explainers if e.kind != "null"]
        cascade = [randomised_top(top) for top in range(1, layers)] + ["randomised"]
        parts += [
            "ρ after randomising the weights, layer by layer from the output down "
            f"(of {layers}; before the last of one scene in four):",
            _table(seeds, learned, cascade, list(map(str, range(1, layers + 1)))),
        ]
    if seeds[0].checks:
        parts += checks_tables(seeds)
    parts.append("\n".join(conclusions(seeds)))
    return "\n\n".join(parts) + "\n"


def checks_tables(seeds: Seeds) -> list[str]:
    """What holds exactly, checked in every scene, and what is exact and may surprise."""
    header = ("scenes", "of")
    return [
        "What the explanation says exactly, checked by asking the pilot again with every set of "
        "ships. The full marks above that follow from it are checks, not findings:",
        markdown_table(("must hold", *header), [_count(seeds, *item) for item in CHECKS.items()]),
        "Exact, and yet it may surprise who reads it:",
        markdown_table(
            ("surprise", *header, "share"),
            [[*_count(seeds, *item), _share(seeds, item[0])] for item in SURPRISES.items()],
        ),
    ]


def _count(seeds: Seeds, name: str, words: str) -> list[str]:
    found = np.concatenate([np.asarray(s.checks[name]) for s in seeds])
    defined = np.isfinite(found)
    return [words, f"{int(found[defined].sum()):,}", f"{defined.sum():,}"]


def _share(seeds: Seeds, name: str) -> str:
    share = clustered_mean([np.asarray(s.checks[name]) for s in seeds], [s.voyage for s in seeds])
    return percent(share) if np.isfinite(share.value) else "–"


def _table(
    seeds: Seeds, explainers: Sequence[Explainer], measures: Sequence[str], titles: Sequence[str]
) -> str:
    """One row an explanation, one column a measure."""
    rows = [[e.title, *(_cell(seeds, e.name, m) for m in measures)] for e in explainers]
    return markdown_table(["explanation", *titles], rows)


def _cell(seeds: Seeds, explainer: str, measure: str) -> str:
    if measure == "sensitivity":
        return f"{np.median(np.concatenate([s.scores[explainer][measure] for s in seeds])):.2f}"
    score = score_of(seeds, explainer, measure)
    if not np.isfinite(score.value):
        return "–"
    return f"{score.value:.2f} [{score.low:.2f}, {score.high:.2f}]"


def score_of(seeds: Seeds, explainer: str, measure: str) -> ConfidenceInterval:
    """The mean of a measure over all scenes, with its interval."""
    values = [np.asarray(s.scores[explainer][measure]) for s in seeds]
    return clustered_mean(values, [s.voyage for s in seeds])


def conclusions(seeds: Seeds) -> list[str]:
    """Does each explanation of the paper tell more than the CPA figures alone? In words.

    All comparisons of one pilot are corrected together.
    """
    names = {e.name: e.title for e in seeds[0].explainers}
    papers = [e.name for e in seeds[0].explainers if e.kind == "paper"]
    pairs = [(ours, measure) for ours in papers for measure in TRUTH_MEASURES]
    gaps = [_gap(seeds, ours, measure) for ours, measure in pairs]
    held = dict(zip(pairs, holm([chance for _, chance in gaps]), strict=True))
    sign = {pair: mean for pair, (mean, _) in zip(pairs, gaps, strict=True)}
    said = [
        f"{len(pairs)} comparisons with {names[NULL]}; the chance of one false difference or "
        "more among them all is at most 5 % (Holm 1979):",
        "",
    ]
    for ours in papers:
        better = [MEASURE_TITLES[m] for m in TRUTH_MEASURES if held[ours, m] and sign[ours, m] > 0]
        worse = [MEASURE_TITLES[m] for m in TRUTH_MEASURES if held[ours, m] and sign[ours, m] < 0]
        said.append(f"- {_against(names[ours], names[NULL], better, worse)}")
    best = max(
        (e.name for e in seeds[0].explainers if e.name != "shapley"),
        key=lambda e: np.nanmean([score_of(seeds, e, m).value for m in TRUTH_MEASURES]),
    )
    said.append(
        f"- By the mean of the same {len(TRUTH_MEASURES)} scores the truest, next to the Shapley "
        f"value of the {seeds[0].subject.quantity} itself, is: {names[best]}."
    )
    return said


def _gap(seeds: Seeds, ours: str, measure: str) -> tuple[float, float]:
    """How much more than the null an explanation has of a score, and the chance that it is 0."""
    gaps = [np.asarray(s.scores[ours][measure]) - s.scores[NULL][measure] for s in seeds]
    voyages = [s.voyage for s in seeds]
    return clustered_mean(gaps, voyages).value, clustered_p_value(gaps, voyages)


def _against(title: str, other: str, better: list[str], worse: list[str]) -> str:
    if better and not worse:
        return f"{title} tells more of the pilot than {other} ({', '.join(better)})."
    if worse and not better:
        return f"{title} tells **less** of the pilot than {other} ({', '.join(worse)})."
    if better and worse:
        return (
            f"{title} against {other}: better in {', '.join(better)}, worse in {', '.join(worse)}."
        )
    return f"{title} and {other}: no difference that these scenes show."
