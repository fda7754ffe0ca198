"""Scores in files, so that nothing is computed twice."""

import hashlib
from collections.abc import Callable, Sequence

import numpy as np

from glasshelm.evaluation.contenders import code_digest, pilot_digest
from glasshelm.evaluation.result_cache import ResultCache
from glasshelm.faithfulness.explainers import explainers_for
from glasshelm.faithfulness.faithfulness_scores import ExplanationScores
from glasshelm.faithfulness.subjects import subject_of
from glasshelm.pilots.protocols import Pilot

#: The code that decides the scores, not that which only shows them.
_SCORE_CODE = (
    "core/fast_trig.py", "core/geometry.py", "encounters", "env", "explanation", "networks",
    "pilots", "planning", "ship",
    *(f"faithfulness/{name}.py" for name in (
        "counterfactual", "explainers", "faithfulness_scores", "manoeuvre_checks", "metrics",
        "sanity_checks", "scenes", "subjects",
    )),
)  # fmt: skip
_ARRAYS = ("voyage", "ships", "own_sensitivity")


def cache_key(pilot: Pilot, encounters: int, max_scenes: int, counts: Sequence[int]) -> str:
    """A digest of everything that the scores depend on: weights, ship, scenes, code."""
    code, weights = code_digest(_SCORE_CODE), pilot_digest(pilot)
    text = f"{code} {weights} {encounters} {max_scenes} {tuple(counts)}"
    return "explanations-" + hashlib.sha256(text.encode()).hexdigest()[:32]


def load_or_compute(
    compute: Callable[[], ExplanationScores], cache: ResultCache, key: str, pilot: Pilot
) -> tuple[ExplanationScores, bool]:
    """The result stored under ``key``, or that of ``compute``, which is then stored.

    Returns:
        The result, and whether it was stored before.
    """
    columns = cache.read(key)
    if columns is None:
        result = compute()
        arrays = {name: getattr(result, name) for name in _ARRAYS}
        scores = {
            f"scores.{explainer}.{measure}": np.asarray(values)
            for explainer, measures in result.scores.items()
            for measure, values in measures.items()
        }
        checks = {f"checks.{name}": np.asarray(values) for name, values in result.checks.items()}
        cache.write(key, scores | checks | arrays)
        return result, False
    loaded: dict[str, dict[str, np.ndarray]] = {}
    checks: dict[str, np.ndarray] = {}
    for name, values in columns.items():
        kind, *place = name.split(".")
        if kind == "scores":
            loaded.setdefault(place[0], {})[place[1]] = values
        elif kind == "checks":
            checks[place[0]] = values
    subject = subject_of(pilot)
    assert subject is not None  # scored before
    arrays = {name: columns[name] for name in _ARRAYS}
    explainers = explainers_for(subject)
    return ExplanationScores(pilot, subject, explainers, loaded, checks, **arrays), True
