"""All scores on real voyages of a bundled pilot: what is known of it must come out."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.untrained import observation, untrained

from glasshelm.evaluation.result_cache import ResultCache
from glasshelm.evaluation.statistics import clustered_mean
from glasshelm.faithfulness.counterfactual import heading_effects
from glasshelm.faithfulness.explainers import EXPLAINERS, explainers_for
from glasshelm.faithfulness.faithfulness_scores import MEASURES, randomised_top, score_explanations
from glasshelm.faithfulness.sanity_checks import count_layers, perturb_sensors, randomise_weights
from glasshelm.faithfulness.scenes import collect_scenes
from glasshelm.faithfulness.score_cache import cache_key, load_or_compute
from glasshelm.faithfulness.score_tables import scores_report
from glasshelm.faithfulness.subjects import subject_of
from glasshelm.pilots.registry import load


@pytest.fixture(scope="module")
def pilot():
    return load("paper-attention")


@pytest.fixture(scope="module")
def scored(pilot):
    return score_explanations(pilot, encounters=32, max_scenes=12, counts=(3,))


def mean(scored, explainer, measure):
    return float(np.nanmean(scored.scores[explainer][measure]))


def test_every_explanation_has_every_score_in_every_scene(scored):
    assert set(scored.scores) == {e.name for e in EXPLAINERS}
    for by in scored.scores.values():
        assert set(MEASURES) | {randomised_top(top) for top in range(1, 7)} == set(by)
        assert {len(v) for v in by.values()} == {len(scored.voyage)}


def test_the_shapley_value_has_full_marks_against_itself_and_nulls_have_not(scored):
    assert mean(scored, "shapley", "kendall") == pytest.approx(1.0)
    assert mean(scored, "shapley", "sign") == pytest.approx(1.0)
    assert mean(scored, "uniform", "kendall") == pytest.approx(0.0)
    assert abs(mean(scored, "random", "kendall")) < 0.35
    assert mean(scored, "shapley", "deletion") > mean(scored, "random", "deletion") + 0.3


def test_nulls_do_not_notice_that_the_pilot_forgot_everything(scored):
    assert mean(scored, "cpa", "randomised") == pytest.approx(1.0)
    assert mean(scored, "random", randomised_top(1)) == pytest.approx(1.0)
    assert np.isnan(scored.scores["uniform"]["randomised"]).all()


def test_what_is_made_of_the_networks_is_forgotten_and_may_come_back_upside_down(scored):
    for explainer in ("shapley", "leave_one_out", "attention"):
        found = scored.scores[explainer]["randomised"]
        assert found.min() < 0
        assert mean(scored, explainer, "randomised") < 0.6


def test_layers_are_forgotten_one_after_the_other_from_the_output_down(scored):
    assert scored.subject.layers == 7
    # Attention is what the bottom three layers say: the head of the actor has no part in it.
    assert mean(scored, "attention", randomised_top(4)) == pytest.approx(1.0)
    assert mean(scored, "attention", randomised_top(6)) < 1.0
    asked = np.isfinite(scored.scores["shapley"][randomised_top(1)])
    assert asked.sum() == -(-len(asked) // 4)


def test_what_is_a_rudder_is_also_taken_as_it_is_told(scored):
    for name, by in scored.scores.items():
        defined = np.isfinite(by["unscaled_infidelity"])
        assert (
            defined.all() if name in ("shapley", "leave_one_out", "gradient") else not defined.any()
        )
        assert np.all(by["unscaled_infidelity"][defined] >= by["infidelity"][defined] - 1e-5)
    assert mean(scored, "shapley", "unscaled_infidelity") < 1.0


def test_scores_are_kept_to_the_bit_and_not_computed_again(scored, tmp_path):
    def never():
        raise AssertionError("scored again")

    pilot, kept = scored.pilot, ResultCache(tmp_path)
    key = cache_key(pilot, 32, 12, (3,))
    first, stored = load_or_compute(lambda: scored, kept, key, pilot)
    assert first is scored
    assert not stored
    again, before = load_or_compute(never, kept, key, pilot)
    assert before
    assert scores_report("p", [again], "c", "m") == scores_report("p", [scored], "c", "m")
    assert cache_key(pilot, 32, 13, (3,)) != key
    assert cache_key(load("paper-sum"), 32, 12, (3,)) != key


def test_the_report_names_scenes_weights_and_a_verdict(scored):
    text = scores_report("paper-attention", [scored], "glasshelm faithfulness", "a machine")
    assert f"{len(scored.voyage):,} scenes" in text
    assert scored.pilot.weights_sha256[:8] in text
    assert "20 comparisons with DCPA and TCPA" in text
    assert "| explanation | 1 | 2 | 3 | 4 | 5 | 6 | 7 |" in text


def test_scenes_are_those_in_which_a_ship_matters(pilot):
    for group in collect_scenes(subject_of(pilot), 32, 5, (3,)):
        assert group.size <= 5
        assert group.observation.present.shape == (group.size, group.ships)
        assert bool(group.observation.present.all())
        assert bool((group.state.step % 20 == 0).all())
    subject = subject_of(pilot)
    assert subject.least * subject.ship.rudder_limit_rad == pytest.approx(np.radians(0.25))


@pytest.mark.slow
def test_a_ship_whom_nobody_sees_turns_nobody(pilot):
    group = collect_scenes(subject_of(pilot), 32, 3, (3,))[0]
    encounter, state = jax.tree.map(lambda x: x[0], (group.encounter, group.state))
    turned = heading_effects(pilot.actor, encounter, state, pilot.trained.ship)
    assert float(jnp.abs(turned).max()) > 0

    def blind(seen):
        return jnp.float32(0.1)

    nobody = heading_effects(blind, encounter, state, pilot.trained.ship)
    np.testing.assert_allclose(nobody, 0.0, atol=1e-6)


@pytest.mark.slow
def test_shaken_scenes_are_near_and_consistent():
    seen = observation(3)
    other = perturb_sensors(seen, jax.random.key(0))
    gap = np.abs(np.asarray(other.targets - seen.targets))[..., 0]
    assert 0 < gap.max() <= 10.0 / 20_000.0 + 1e-6
    distance = np.hypot(other.targets[..., 0], other.targets[..., 1]) / 2**0.5
    np.testing.assert_allclose(other.targets[..., 5], distance, atol=1e-5)


def test_forgetting_keeps_the_scale_of_every_matrix():
    actor = untrained("sum").actor
    other = randomise_weights(actor, 0)
    for a, b in zip(jax.tree.leaves(actor), jax.tree.leaves(other), strict=True):
        np.testing.assert_allclose(np.sort(np.ravel(a)), np.sort(np.ravel(b)))
    assert float(actor(observation(3))) != float(other(observation(3)))


def test_a_network_forgets_from_its_output_down_and_keeps_the_rest():
    actor = untrained("attention").actor
    assert count_layers(actor) == 4
    assert count_layers(None) == 0
    first, two = randomise_weights(actor, 0, 1), randomise_weights(actor, 0, 2)
    for other in (first, two, randomise_weights(actor, 0)):
        assert not np.array_equal(other.head.weights[-1], actor.head.weights[-1])
        np.testing.assert_array_equal(other.head.weights[-1], first.head.weights[-1])
    np.testing.assert_array_equal(first.head.weights[-2], actor.head.weights[-2])
    assert not np.array_equal(two.head.weights[-2], actor.head.weights[-2])
    np.testing.assert_array_equal(two.encode_target.weights[-1], actor.encode_target.weights[-1])


def test_what_a_pilot_does_not_have_is_not_examined():
    names = {e.name for e in explainers_for(subject_of(untrained("sum", critic=False)))}
    assert names.isdisjoint({"attention", "intention", "danger", "shapley_decision"})
    assert {"shapley", "cpa"} <= names


def test_the_interval_of_dependent_scenes_is_that_of_their_voyages():
    rng = np.random.default_rng(1)
    by_voyage = rng.normal(size=50)
    values = np.repeat(by_voyage, 20)
    found = clustered_mean([values], [np.repeat(np.arange(50), 20)])
    assert found.high - found.low == pytest.approx(2 * 1.96 / np.sqrt(50), rel=0.35)
