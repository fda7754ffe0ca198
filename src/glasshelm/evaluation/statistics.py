"""Intervals for rates, ratios of rates and returns.

Rates of one trained pilot over independent encounters: Clopper and Pearson
(1934), exact, never below its nominal cover. Ratios of two rates over the same
encounters: the score interval of Nam and Blackwelder (2002), which knows that
the encounters are paired and has an answer where nothing happened. Returns, and
everything over several training seeds: the interquartile mean and a percentile bootstrap
after Agarwal et al. (2021), with one difference: a seed sails all
encounters, so seeds are drawn as wholes, and encounters within their strata.
"""

import dataclasses
import itertools
import math
from collections.abc import Callable

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.stats import beta

#: Two-sided 95 %.
LEVEL = 0.95
#: With fewer events (or fewer others) than this a seed, resampling does not see how many there
#: might have been.
FEW = 5
_Z = 1.959963984540054

Values = Float[np.ndarray, "seeds n"]


@dataclasses.dataclass(frozen=True)
class ConfidenceInterval:
    """An estimate and its 95 % interval."""

    value: float
    low: float
    high: float


def clopper_pearson(events: int | float, of: int, level: float = LEVEL) -> ConfidenceInterval:
    """The exact interval of a rate: ``events`` of ``of`` independent trials (a mean of several)."""
    tail = (1.0 - level) / 2
    low = float(beta.ppf(tail, events, of - events + 1)) if events else 0.0
    high = float(beta.ppf(1.0 - tail, events + 1, of - events)) if events < of else 1.0
    return ConfidenceInterval(events / of, low, high)


def interquartile_mean(values: Float[np.ndarray, "..."]) -> float:
    """The mean of the middle half of all values; ends of the half count in part."""
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
    resamples: int = 1000,
    seed: int = 0,
) -> ConfidenceInterval:
    """A statistic of [seeds, encounters] and its percentile interval.

    Each resample draws encounters with replacement within every stratum (the
    same for all seeds) and, where there are several, seeds as wholes.
    """
    rng = np.random.default_rng(seed)
    seeds, _ = values.shape
    members = [np.flatnonzero(strata == s) for s in np.unique(strata)]
    found = np.empty(resamples)
    for i in range(resamples):
        drawn = np.concatenate([m[rng.integers(len(m), size=len(m))] for m in members])
        rows = rng.integers(seeds, size=seeds) if seeds > 1 else np.zeros(1, np.int64)
        found[i] = statistic(values[np.ix_(rows, drawn)])
    low, high = np.quantile(found, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return ConfidenceInterval(statistic(values), float(low), float(high))


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
    found = bootstrap(events.astype(np.float64), np.zeros(number, np.int64), mean)
    return found if FEW <= count <= number - FEW else _hull(found, exact)


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
    found = np.empty(1000)
    for i in range(len(found)):
        drawn = rng.integers(both.shape[1], size=both.shape[1])
        a = both[rng.integers(split, size=split)][:, drawn].mean()
        b = both[split + rng.integers(len(theirs), size=len(theirs))][:, drawn].mean()
        found[i] = a / b if b > 0 else math.inf
    low, high = np.quantile(found, [(1 - LEVEL) / 2, (1 + LEVEL) / 2], method="nearest")
    whole = ConfidenceInterval(float(ours.mean() / theirs.mean()), float(low), float(high))
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
    Medicine 21: 689) is ±1.96; found by bisection. It must have happened to them.
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
    for _ in range(60):
        middle = math.sqrt(inside * outside)
        if (score(middle) - level) * (factor - 1) <= 0:
            outside = middle
        else:
            inside = middle
    return math.sqrt(inside * outside)
