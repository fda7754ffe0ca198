"""What an exam found of one pilot, kept in a file, so that it is not asked again."""

import hashlib
from collections.abc import Callable, Sequence

import numpy as np

from glasshelm.evaluation.contenders import code_digest, digest_of
from glasshelm.evaluation.result_cache import Found, ResultCache
from glasshelm.faithfulness.exam_runner import Examined
from glasshelm.faithfulness.explainers import explainers_for
from glasshelm.pilots.learned import LearnedPilot

#: The rooms whose code decides the scores: not those that only show them.
_ROOMS = (
    "core/fast_trig.py", "core/geometry.py", "encounters", "env", "explanation", "networks", "ship",
    *(f"faithfulness/{name}.py" for name in
      ("chunking", "counterfactual", "exam_runner", "explainers", "metrics", "sanity_checks",
       "scenes")),
)  # fmt: skip


def key_of(pilot: LearnedPilot, encounters: int, most: int, counts: Sequence[int]) -> str:
    """What everything that the scores depend on comes to: weights, ship, scenes, code."""
    told = f"{code_digest(_ROOMS)} {digest_of(pilot)} {encounters} {most} {tuple(counts)}"
    return "explanations-" + hashlib.sha256(told.encode()).hexdigest()[:32]


def kept_or(
    examine: Callable[[], Examined], kept: ResultCache, key: str, pilot: LearnedPilot
) -> tuple[Examined, bool]:
    """The scores kept under ``key``, or those of ``examine``, which are then kept; and whether
    they were there already."""
    found = kept.read(key)
    if found is not None:
        return _examined(pilot, found), True
    examined = examine()
    kept.write(key, _found(examined))
    return examined, False


def _found(examined: Examined) -> Found:
    scores = {
        f"told.{name}.{measure}": np.asarray(values)
        for name, measures in examined.told.items()
        for measure, values in measures.items()
    }
    return scores | {
        "voyage": examined.voyage,
        "ships": examined.ships,
        "own_sensitivity": examined.own_sensitivity,
    }


def _examined(pilot: LearnedPilot, found: Found) -> Examined:
    told: dict[str, dict[str, np.ndarray]] = {}
    for place, values in found.items():
        if place.startswith("told."):
            _, name, measure = place.split(".")
            told.setdefault(name, {})[measure] = values
    return Examined(
        pilot,
        explainers_for(pilot.actor, pilot.critic),
        told,
        found["voyage"],
        found["ships"],
        found["own_sensitivity"],
    )
