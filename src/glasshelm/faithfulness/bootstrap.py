"""How sure a mean over scenes is, and which of many comparisons still hold when all are made."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

#: Resamples of an interval, and of a probability, which Holm divides by the comparisons left.
RESAMPLES, FINE = 1_000, 4_000
#: Chance of one false verdict or more among all those about one pilot.
LEVEL = 0.05

Seeds = Sequence[Float[np.ndarray, " s"]]
#: Sum and number of the scenes of each voyage of one training seed.
Voyages = tuple[np.ndarray, np.ndarray]


def clustered_mean(seeds: Seeds, voyages: Sequence[np.ndarray]) -> tuple[float, float, float]:
    """A mean over scenes and its 95 % interval: seeds and voyages are drawn as wholes.

    Scenes of one voyage resemble each other, and all scenes of one training
    do; nan scenes (a score that is not defined there) are left out.
    """
    parts = _by_voyage(seeds, voyages)
    if not any(count.sum() for _, count in parts):
        return float("nan"), float("nan"), float("nan")
    mean = np.mean([total.sum() / count.sum() for total, count in parts if count.sum()])
    low, high = np.nanquantile(_resampled(parts, RESAMPLES), [0.025, 0.975])
    return float(mean), float(low), float(high)


def clustered_p_value(seeds: Seeds, voyages: Sequence[np.ndarray]) -> float:
    """Two-sided bootstrap probability (p) of a mean of 0, drawn as above; nan if there is none."""
    parts = _by_voyage(seeds, voyages)
    if not any(count.sum() for _, count in parts):
        return float("nan")
    drawn = _resampled(parts, FINE)
    drawn = drawn[np.isfinite(drawn)]
    side = min((drawn <= 0).sum(), (drawn >= 0).sum())
    return float(min(1.0, 2.0 * (side + 1) / (len(drawn) + 1)))


def holm(chances: Sequence[float]) -> list[bool]:
    """Which of many comparisons hold, at :data:`LEVEL` for all of them together (Holm 1979).

    nan is no comparison: it neither holds nor counts.
    """
    held = [False] * len(chances)
    made = [i for i in np.argsort(chances) if np.isfinite(chances[i])]
    for done, place in enumerate(made):
        if chances[place] > LEVEL / (len(made) - done):
            break
        held[place] = True
    return held


def _by_voyage(seeds: Seeds, voyages: Sequence[np.ndarray]) -> list[Voyages]:
    parts = []
    for values, whose in zip(seeds, voyages, strict=True):
        fine = np.isfinite(values)
        _, place = np.unique(whose, return_inverse=True)
        total = np.bincount(place[fine], values[fine], minlength=place.max() + 1)
        count = np.bincount(place[fine], minlength=place.max() + 1)
        parts.append((total, count))
    return parts


def _resampled(parts: Sequence[Voyages], resamples: int) -> Float[np.ndarray, " r"]:
    """Means of resamples: as many seeds as there are, of each as many voyages as she has."""
    rng = np.random.default_rng(0)
    seeds = rng.integers(len(parts), size=(resamples, len(parts)))
    means = np.full(seeds.shape, np.nan)
    for seed, (total, count) in enumerate(parts):
        rows, columns = np.nonzero(seeds == seed)
        voyage = rng.integers(len(total), size=(len(rows), len(total)), dtype=np.int32)
        scenes = count[voyage].sum(1)
        means[rows, columns] = np.where(
            scenes > 0, total[voyage].sum(1) / np.maximum(scenes, 1), np.nan
        )
    defined = np.isfinite(means)
    number = defined.sum(1)
    summed = np.where(defined, means, 0.0).sum(1)
    return np.where(number > 0, summed / np.maximum(number, 1), np.nan)
