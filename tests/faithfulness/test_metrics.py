"""The scores of an explanation against what can be worked out by hand."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.stats import kendalltau, spearmanr

from glasshelm.explanation.coalitions import coalitions, exact_from_worths
from glasshelm.faithfulness.metrics import kendall_tau, score_attribution
from glasshelm.faithfulness.sanity_checks import spearman


def additive(parts):
    return jnp.asarray(coalitions(len(parts)) @ np.array(parts, np.float32) + 0.3, jnp.float32)


def rough(seed, players=4):
    return jnp.asarray(np.random.default_rng(seed).normal(size=2**players), jnp.float32)


def test_the_truth_itself_has_full_marks_where_ships_add_up():
    worth = additive([0.5, -0.2, 0.1])
    found = score_attribution(jnp.array([0.5, -0.2, 0.1]), worth, True, True)
    assert float(found.kendall) == pytest.approx(1.0)
    assert float(found.sign) == pytest.approx(1.0)
    assert float(found.top) == 1.0
    assert float(found.infidelity) == pytest.approx(0.0, abs=1e-6)


def test_the_wrong_side_and_the_wrong_order_are_told():
    worth = additive([0.5, 0.2, 0.1])
    found = score_attribution(jnp.array([-0.1, -0.2, 0.5]), worth, True, True)
    assert float(found.sign) == pytest.approx(0.1 / 0.8, abs=1e-6)
    assert float(found.kendall) == pytest.approx(-1.0)
    assert float(found.top) == 0.0
    assert float(found.deletion) < 0
    assert float(found.insertion) < 0


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_over_all_orders_a_random_one_scores_0_and_the_best_1(seed):
    worth = rough(seed)
    found = [
        score_attribution(jnp.array(order, jnp.float32), worth, False, False)
        for order in itertools.permutations([4.0, 3.0, 2.0, 1.0])
    ]
    for measure in ("deletion", "insertion"):
        values = np.array([float(getattr(f, measure)) for f in found])
        assert values.mean() == pytest.approx(0.0, abs=1e-5)
        assert values.max() == pytest.approx(1.0, abs=1e-5)


def test_infidelity_is_the_variation_that_no_multiple_of_the_explanation_says():
    worth = rough(5)
    told = jnp.array([0.3, -1.0, 0.2, 0.7])
    inside = coalitions(4).astype(float)
    drop = np.asarray(worth)[-1] - np.asarray(worth)[::-1]
    said = inside @ np.asarray(told)
    c = np.linalg.lstsq(said[:, None], drop, rcond=None)[0][0]
    expected = np.sum((drop - c * said) ** 2) / np.sum(drop**2)
    assert float(score_attribution(told, worth, False, False).infidelity) == pytest.approx(
        expected, rel=1e-4
    )


def test_with_the_scale_as_told_an_explanation_of_half_the_size_misses_a_quarter():
    worth = additive([0.5, -0.2, 0.1])
    half = jnp.array([0.25, -0.1, 0.05])
    assert float(score_attribution(half, worth, True, True).infidelity) == pytest.approx(
        0.0, abs=1e-6
    )
    assert float(score_attribution(half, worth, True, True).unscaled_infidelity) == pytest.approx(
        0.25, abs=1e-5
    )
    assert np.isnan(float(score_attribution(half, worth, False, False).unscaled_infidelity))
    only_the_side = score_attribution(half, worth, True, False)
    assert float(only_the_side.sign) == pytest.approx(1.0)
    assert np.isnan(float(only_the_side.unscaled_infidelity))


def test_where_no_ship_matters_nothing_can_be_ordered():
    found = score_attribution(jnp.array([1.0, 2.0]), jnp.full(4, 0.2), False, False)
    assert np.isnan(float(found.deletion))
    assert np.isnan(float(found.sign))


def test_rank_correlations_are_those_of_scipy():
    rng = np.random.default_rng(0)
    for _ in range(5):
        a, b = rng.integers(0, 4, 6).astype(float), rng.normal(size=6)
        x, y = jnp.asarray(a, jnp.float32), jnp.asarray(b, jnp.float32)
        assert float(kendall_tau(x, y)) == pytest.approx(kendalltau(a, b).statistic, abs=1e-6)
        assert float(spearman(x, y)) == pytest.approx(spearmanr(a, b).statistic, abs=1e-5)


def test_the_shapley_value_itself_is_imperfect_where_ships_work_together():
    worth = rough(7)
    found = score_attribution(exact_from_worths(worth).by_ship, worth, True, True)
    assert 0.0 < float(found.infidelity) < 1.0
    assert jax.tree.all(jax.tree.map(lambda x: bool(jnp.isfinite(x)), found))
