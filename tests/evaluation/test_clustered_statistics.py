"""Which of many comparisons hold when all of them are made."""

import numpy as np
import pytest

from glasshelm.evaluation.statistics import clustered_p_value, holm


def test_holm_asks_more_of_each_the_more_there_are():
    # 0.05/4, 0.05/3, 0.05/2, 0.05: the third fails, and with it the fourth.
    assert holm([0.04, 0.001, 0.015, 0.03]) == [False, True, True, False]
    assert holm([0.04]) == [True]
    assert holm([float("nan"), 0.04]) == [False, True]
    assert holm([]) == []


def test_the_chance_is_that_of_voyages_not_of_scenes():
    rng = np.random.default_rng(1)
    by_voyage = rng.normal(size=40)
    by_voyage += 2.0 / np.sqrt(40) - by_voyage.mean()  # two standard errors: p ≈ 0.05
    voyages = np.repeat(np.arange(40), 20)
    found = clustered_p_value([np.repeat(by_voyage, 20)], [voyages])
    assert 0.01 < found < 0.1
    assert clustered_p_value([np.zeros(40)], [np.arange(40)]) == 1.0
    assert np.isnan(clustered_p_value([np.full(40, np.nan)], [np.arange(40)]))


def test_a_certain_difference_is_below_what_holm_asks_of_twenty():
    found = clustered_p_value([np.ones(40)], [np.arange(40)])
    assert found == pytest.approx(2 / 4_001)
    assert found < 0.05 / 20
