"""Intervals cover what they say they cover."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.stats import binom

from glasshelm.evaluation.statistics import (
    _discordance,
    bootstrap,
    clopper_pearson,
    interquartile_mean,
    mean,
    paired_ratio,
    rate_interval,
    risk_ratio,
)


@pytest.mark.parametrize(("of", "p"), [(50, 0.02), (50, 0.3), (400, 0.005), (400, 0.5)])
def test_clopper_pearson_covers_at_least_95_in_100(of, p):
    """Summed over every possible outcome, so exact: conservative, never below nominal."""
    found = [clopper_pearson(k, of) for k in range(of + 1)]
    holds = np.array([i.low <= p <= i.high for i in found])
    cover = float(binom.pmf(np.arange(of + 1), of, p)[holds].sum())
    assert 0.95 <= cover <= 1.0
    if of * p * (1 - p) > 50:
        assert cover <= 0.965


def test_clopper_pearson_at_the_ends():
    none, all_ = clopper_pearson(0, 100), clopper_pearson(100, 100)
    assert none.low == 0.0
    assert none.high == pytest.approx(1 - 0.025 ** (1 / 100))
    assert (all_.low, all_.high) == (pytest.approx(1 - none.high), 1.0)


def paired(rng, count, cells):
    drawn = rng.choice(4, size=count, p=cells)
    return (drawn == 0) | (drawn == 1), (drawn == 0) | (drawn == 2)


@pytest.mark.slow
def test_the_paired_ratio_covers_95_in_100():
    rng = np.random.default_rng(1)
    both, ours, theirs, neither = cells = (0.1, 0.05, 0.2, 0.65)
    true = (both + ours) / (both + theirs)
    found = [paired_ratio(*paired(rng, 200, cells)) for _ in range(3000)]
    cover = np.mean([i.low <= true <= i.high for i in found])
    assert abs(cover - 0.95) <= 0.01
    assert neither > 0


def test_the_constrained_probabilities_are_the_likeliest():
    """Against a search along the constraint p_ours = ratio · p_theirs."""
    rng = np.random.default_rng(2)
    for _ in range(5):
        both, ours, theirs, _ = rng.dirichlet([1, 1, 1, 3])
        ratio = float(np.exp(0.5 * rng.normal()))
        some = both + ours + theirs

        def others(x, ratio=ratio, some=some):
            y = ratio * x - (ratio - 1) * some
            return y, some - x - y

        def unlikely(x, both=both, ours=ours, theirs=theirs, others=others):
            y, rest = others(x)
            logs = [math.log(max(v, 1e-300)) for v in (rest, x, y)]
            return -(both * logs[0] + ours * logs[1] + theirs * logs[2])

        low = max(0.0, (ratio - 1) * some / ratio)
        best = minimize_scalar(
            unlikely, bounds=(low, some * ratio / (1 + ratio)), method="bounded",
            options={"xatol": 1e-12},
        ).x  # fmt: skip
        found = _discordance(ratio, both + ours, both + theirs, ours, theirs)
        assert found == pytest.approx(best + others(best)[0], rel=1e-4)


def test_no_event_of_ours_still_has_an_upper_end():
    theirs = np.arange(100) < 30
    found = paired_ratio(np.zeros(100, bool), theirs)
    assert (found.value, found.low) == (0.0, 0.0)
    assert 0.05 < found.high < 0.2
    assert risk_ratio(theirs[None], np.zeros((1, 100), bool)) is None


def test_the_interquartile_mean_takes_the_middle_half():
    assert interquartile_mean(np.array([9.0, 1.0, 2.0, -50.0])) == 1.5
    # Six values: a quarter is one and a half, so the second and the fifth count half.
    assert interquartile_mean(np.arange(6.0) ** 2) == pytest.approx((0.5 + 4 + 9 + 8) / 3)


@pytest.mark.slow
@pytest.mark.parametrize("statistic", [mean, interquartile_mean])
def test_the_bootstrap_over_encounters_covers_about_95_in_100(statistic):
    rng = np.random.default_rng(3)
    strata = np.repeat([0, 1], 60)
    covered = []
    for i in range(400):
        values = rng.normal(strata * 3.0, 1.0)[None]
        found = bootstrap(values, strata, statistic, resamples=300, seed=i)
        covered.append(found.low <= 1.5 <= found.high)
    assert 0.92 <= np.mean(covered) <= 0.98


def test_strata_are_kept_and_seeds_are_drawn_as_wholes():
    strata = np.repeat([0, 1], 50)
    apart = bootstrap(100.0 * strata[None].astype(float), strata, mean)
    assert (apart.low, apart.high) == (50.0, 50.0)
    seeds = np.array([[0.0] * 100, [1.0] * 100])
    by_seed = bootstrap(seeds, strata, mean)
    assert (by_seed.low, by_seed.high) == (0.0, 1.0)


def test_a_rate_over_several_seeds_is_wider_than_over_one():
    events = np.zeros((5, 200), bool)
    events[0, :100] = True
    pooled = clopper_pearson(100, 1000)
    found = rate_interval(events)
    assert found.value == pooled.value
    assert found.high - found.low > 3 * (pooled.high - pooled.low)


def test_several_seeds_without_an_event_still_have_an_upper_end():
    none = np.zeros((5, 1000), bool)
    assert rate_interval(none).high == clopper_pearson(0, 1000).high
    assert rate_interval(~none).low == clopper_pearson(1000, 1000).low
    theirs = none.copy()
    theirs[:, :40] = True
    ratio = risk_ratio(none, theirs)
    assert ratio is not None
    assert ratio.value == 0.0
    assert ratio.high == pytest.approx(paired_ratio(none[0], theirs[0]).high)
    once = np.eye(5, 1000, dtype=bool)
    back = risk_ratio(theirs, once)
    assert back is not None
    assert back.low <= paired_ratio(theirs[0], once[0]).low


@pytest.mark.slow
def test_a_rare_rate_over_several_seeds_covers_95_in_100():
    """Encounters with a danger of their own, the same for all seeds; two events a seed."""
    rng = np.random.default_rng(3)
    covered = 0
    for _ in range(300):
        danger = np.where(rng.random(400) < 0.05, 0.1, 0.0)
        found = rate_interval(rng.random((5, 400)) < danger)
        covered += found.low <= 0.005 <= found.high
    assert covered / 300 > 0.95
