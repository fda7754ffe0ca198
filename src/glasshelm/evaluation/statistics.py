"""Confidence intervals for rates, ratios of rates, returns and scores, and Holm's correction.

Rates of one trained pilot over independent encounters: Clopper and Pearson (1934), exact.
Ratios of two rates over the same encounters: the score interval of Nam and Blackwelder (2002),
which takes account of the pairing and is defined where nothing happened. Returns, and everything
over several training seeds: a percentile bootstrap after Agarwal et al. (2021), with one
difference. A seed sails all encounters, so seeds are drawn as wholes, and encounters within
their strata. Scores of scenes: the same, with voyages drawn as wholes.
"""

import dataclasses
import itertools
import math
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.optimize import root_scalar
from scipy.stats import beta

#: Two-sided 95 %.
LEVEL = 0.95
#: With fewer events (or fewer others) a seed than this, resampling underestimates how many there
#: might have been.
FEW = 5
#: Resamples of an interval, and of a p-value, which Holm divides by the number of comparisons.
RESAMPLES, P_VALUE_RESAMPLES = 1_000, 4_000
_Z = 1.959963984540054

Values = Float[np.ndarray, "seeds n"]


@dataclasses.dataclass(frozen=True)
class ConfidenceInterval:
    """An estimate and its 95 % confidence interval."""

    value: float
    low: float
    high: float


def clopper_pearson(events: int | float, of: int, level: float = LEVEL) -> ConfidenceInterval:
    """The exact interval of a rate: ``events`` of ``of`` independent trials.

    ``events`` may be a mean over several series of trials, hence no whole number.
    """
    tail = (1.0 - level) / 2
    low = float(beta.ppf(tail, events, of - events + 1)) if events else 0.0
    high = float(beta.ppf(1.0 - tail, events + 1, of - events)) if events < of else 1.0
    return ConfidenceInterval(events / of, low, high)


def interquartile_mean(values: Float[np.ndarray, "..."]) -> float:
    """The mean of the middle half of all values; values at its ends count in part."""
    ordered = np.sort(np.asarray(values, np.float64), axis=None)
    quarter = len(ordered) / 4
    place = np.arange(len(ordered))
    lower = np.clip(place + 1 - quarter, 0.0, 1.0)
    upper = np.clip(len(ordered) - place - quarter, 0.0, 1.0)
    weight = np.minimum(lower, upper)
    return float(np.sum(weight * ordered) / weight.sum())


def mean(values: Float[np.ndarray, "..."]) -> float:
    """The plain mean."""
    return float(np.mean(values))


def bootstrap(
    values: Values,
    strata: Int[np.ndarray, " n"],
    statistic: Callable[[Values], float] = interquartile_mean,
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> ConfidenceInterval:
    """A statistic of [seeds, encounters] and its percentile interval.

    Each resample draws encounters with replacement within every stratum (the
    same for all seeds) and, where there are several, seeds as wholes.
    """
    rng = np.random.default_rng(seed)
    seeds, _ = values.shape
    members = [np.flatnonzero(strata == s) for s in np.unique(strata)]
    resampled = np.empty(resamples)
    for i in range(resamples):
        drawn = np.concatenate([m[rng.integers(len(m), size=len(m))] for m in members])
        rows = rng.integers(seeds, size=seeds) if seeds > 1 else np.zeros(1, np.int64)
        resampled[i] = statistic(values[np.ix_(rows, drawn)])
    return _percentiles(statistic(values), resampled)


def _percentiles(
    value: float, resampled: np.ndarray, method: Literal["linear", "nearest"] = "linear"
) -> ConfidenceInterval:
    low, high = np.nanquantile(resampled, [(1 - LEVEL) / 2, (1 + LEVEL) / 2], method=method)
    return ConfidenceInterval(float(value), float(low), float(high))


def rate_interval(events: Bool[np.ndarray, "seeds n"]) -> ConfidenceInterval:
    """A rate: exact for one seed, by the bootstrap over seeds and encounters for several.

    Several seeds of few events (``FEW``): at least as wide as if their mean number were one seed's.
    All seeds sail the same encounters, so more of them are not more trials.
    """
    seeds, number = events.shape
    count = events.sum() / seeds
    exact = clopper_pearson(count, number)
    if seeds == 1:
        return exact
    resampled = bootstrap(events.astype(np.float64), np.zeros(number, np.int64), mean)
    return resampled if FEW <= count <= number - FEW else _hull(resampled, exact)


def _hull(first: ConfidenceInterval, second: ConfidenceInterval) -> ConfidenceInterval:
    """The first's estimate, within both."""
    return ConfidenceInterval(first.value, min(first.low, second.low), max(first.high, second.high))


def risk_ratio(
    ours: Bool[np.ndarray, "seeds n"], theirs: Bool[np.ndarray, "other n"]
) -> ConfidenceInterval | None:
    """How many times as often it happens to us, over the same encounters.

    None where it never happens to them. Several seeds: by the bootstrap; of few events (``FEW``)
    at least as wide as the score interval of any seed of ours with any of theirs.
    """
    if not theirs.any():
        return None
    if ours.shape[0] == 1 and theirs.shape[0] == 1:
        return paired_ratio(ours[0], theirs[0])
    split = ours.shape[0]
    both = np.concatenate([ours, theirs]).astype(np.float64)
    rng = np.random.default_rng(0)
    resampled = np.empty(RESAMPLES)
    for i in range(RESAMPLES):
        drawn = rng.integers(both.shape[1], size=both.shape[1])
        a = both[rng.integers(split, size=split)][:, drawn].mean()
        b = both[split + rng.integers(len(theirs), size=len(theirs))][:, drawn].mean()
        resampled[i] = a / b if b > 0 else math.inf
    whole = _percentiles(ours.mean() / theirs.mean(), resampled, method="nearest")
    if min(events.sum() / len(events) for events in (ours, theirs)) >= FEW:
        return whole
    for one, other in itertools.product(ours, theirs):
        unknown = ConfidenceInterval(math.nan, 0.0, math.inf)
        whole = _hull(whole, paired_ratio(one, other) if other.any() else unknown)
    return whole


def paired_ratio(
    ours: Bool[np.ndarray, " n"], theirs: Bool[np.ndarray, " n"]
) -> ConfidenceInterval:
    """The ratio of two rates over the same trials, with its score interval.

    The ends are where the score statistic of Nam and Blackwelder (2002, Statistics in
    Medicine 21: 689) is ±1.96; the roots are found numerically. It must have happened to them.
    """
    count = len(ours)
    only_ours = int(np.sum(ours & ~theirs)) / count
    only_theirs = int(np.sum(theirs & ~ours)) / count
    p_ours, p_theirs = float(ours.mean()), float(theirs.mean())

    def score(ratio: float) -> float:
        spread = _discordance(ratio, p_ours, p_theirs, only_ours, only_theirs)
        apart = math.sqrt(count) * (p_ours - ratio * p_theirs)
        return apart / math.sqrt(max(ratio * spread, 1e-300))

    value = p_ours / p_theirs
    low = 0.0 if p_ours == 0 else _crossing(score, value, _Z, 0.5)
    return ConfidenceInterval(value, low, _crossing(score, max(value, 1e-9), -_Z, 2.0))


def _discordance(
    ratio: float, p_ours: float, p_theirs: float, only_ours: float, only_theirs: float
) -> float:
    """P(only one of us), of the multinomial likeliest under p_ours = ratio · p_theirs."""
    either = p_theirs + only_ours
    root = (p_ours - ratio**2 * p_theirs) ** 2 + 4 * ratio**2 * only_ours * only_theirs
    ours = -p_ours + ratio**2 * (p_theirs + 2 * only_ours) + math.sqrt(root)
    ours /= 2 * ratio * (ratio + 1)
    return max(ours + ratio * ours - (ratio - 1) * either, 0.0)


def _crossing(score: Callable[[float], float], start: float, level: float, factor: float) -> float:
    """Where a falling function of the ratio crosses a level, sought outwards from ``start``."""
    inside, outside = start, start * factor
    for _ in range(200):
        if (score(outside) - level) * (factor - 1) <= 0:
            break
        inside, outside = outside, outside * factor
    ends = math.log(inside), math.log(outside)
    root = root_scalar(lambda x: score(math.exp(x)) - level, bracket=ends, method="brentq").root
    return math.exp(float(root))


Scores = Sequence[Float[np.ndarray, " s"]]
#: Sum and number of the scores of each voyage of one training seed.
_Sums = tuple[np.ndarray, np.ndarray]


def clustered_mean(seeds: Scores, voyages: Sequence[np.ndarray]) -> ConfidenceInterval:
    """A mean over scenes and its interval: seeds and voyages are drawn as wholes.

    Scenes of one voyage resemble each other, and so do all scenes of one training.

    Args:
        seeds: The scores of each seed's scenes; nan (not defined there) is left out.
        voyages: The voyage that each scene is of.
    """
    sums = _by_voyage(seeds, voyages)
    if not sums:
        return ConfidenceInterval(math.nan, math.nan, math.nan)
    mean = np.mean([total.sum() / count.sum() for total, count in sums if count.sum()])
    return _percentiles(float(mean), _resampled(sums, RESAMPLES))


def clustered_p_value(seeds: Scores, voyages: Sequence[np.ndarray]) -> float:
    """Two-sided bootstrap p-value of a mean of 0, drawn as above; nan if there are no scores."""
    sums = _by_voyage(seeds, voyages)
    if not sums:
        return math.nan
    drawn = _resampled(sums, P_VALUE_RESAMPLES)
    drawn = drawn[np.isfinite(drawn)]
    side = min((drawn <= 0).sum(), (drawn >= 0).sum())
    return float(min(1.0, 2.0 * (side + 1) / (len(drawn) + 1)))


def holm(p_values: Sequence[float]) -> list[bool]:
    """Which comparisons are significant at 5 % for all of them together (Holm 1979).

    nan is no comparison: it is never significant and does not count.
    """
    significant = [False] * len(p_values)
    made = [i for i in np.argsort(p_values) if np.isfinite(p_values[i])]
    for done, i in enumerate(made):
        if p_values[i] > (1 - LEVEL) / (len(made) - done):
            break
        significant[i] = True
    return significant


def _by_voyage(seeds: Scores, voyages: Sequence[np.ndarray]) -> list[_Sums]:
    """The sums of each seed; empty if no score is defined."""
    sums = []
    for values, voyage in zip(seeds, voyages, strict=True):
        fine = np.isfinite(values)
        _, index = np.unique(voyage, return_inverse=True)
        total = np.bincount(index[fine], values[fine], minlength=index.max() + 1)
        sums.append((total, np.bincount(index[fine], minlength=index.max() + 1)))
    return sums if any(count.any() for _, count in sums) else []


def _resampled(sums: Sequence[_Sums], resamples: int) -> Float[np.ndarray, " r"]:
    """Means of resamples: as many seeds as there are, of each as many voyages as it has."""
    rng = np.random.default_rng(0)
    seeds = rng.integers(len(sums), size=(resamples, len(sums)))
    means = np.full(seeds.shape, np.nan)
    for seed, (total, count) in enumerate(sums):
        rows, columns = np.nonzero(seeds == seed)
        voyage = rng.integers(len(total), size=(len(rows), len(total)), dtype=np.int32)
        scenes = count[voyage].sum(1)
        mean = total[voyage].sum(1) / np.maximum(scenes, 1)
        means[rows, columns] = np.where(scenes > 0, mean, np.nan)
    defined = np.isfinite(means)
    summed, number = np.where(defined, means, 0.0).sum(1), defined.sum(1)
    return np.where(number > 0, summed / np.maximum(number, 1), np.nan)
