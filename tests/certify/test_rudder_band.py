"""The band holds every rudder that errors can bring, and is the rudder without errors."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from benchmarks.certify import attacked_rudders, random_rudders
from tests.certify.scenes import KINDS, LEVELS, SCENES, errors, one_of, scenes
from tests.untrained import untrained

from glasshelm.certify.measurements import RawPlots, observe_plots
from glasshelm.certify.rudder_band import RudderBand, action_bounds, certified_band
from glasshelm.core.errors import InputError
from glasshelm.pilots.registry import load

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def actor():
    return load("paper-sum").actor


@pytest.fixture(scope="module")
def rudders(actor):
    def one(scene, errors, key):
        drawn = random_rudders(actor, scene, errors, key, 256)
        return jnp.concatenate([drawn, attacked_rudders(actor, scene, errors, key, 2, 10)])

    return jax.jit(jax.vmap(one, (0, None, 0)))


@pytest.mark.parametrize("level", LEVELS, ids=str)
@pytest.mark.parametrize("kind", KINDS)
def test_no_error_brings_a_rudder_out_of_the_band(actor, rudders, level, kind):
    scene = scenes(kind)
    low, high = action_bounds(actor, scene, errors(*level), cells=5)
    found = np.asarray(rudders(scene, errors(*level), jax.random.split(jax.random.key(0), SCENES)))
    assert np.all(found >= low[:, None])
    assert np.all(found <= high[:, None])
    if not any(level) and kind == "around":
        rudder = np.asarray(jax.jit(lambda: actor(jax.vmap(observe_plots)(scene)))())
        np.testing.assert_allclose(low, rudder, atol=2e-3)
        np.testing.assert_allclose(high, rudder, atol=2e-3)


def test_more_cells_make_it_no_wider(actor):
    bands = [action_bounds(actor, scenes(), errors(*LEVELS[1]), cells) for cells in (1, 9)]
    (low, high), (lower, higher) = bands
    assert np.all(low <= lower)
    assert np.all(high >= higher)
    assert np.sum(higher - lower) < 0.95 * np.sum(high - low)


def test_who_is_not_there_does_not_matter(actor):
    scene = scenes()
    other = RawPlots(scene.waypoint, scene.targets.at[0].multiply(-3.0), scene.present)
    one, two = (action_bounds(actor, x, errors(*LEVELS[1])) for x in (scene, other))
    assert one[0][0] == two[0][0]
    assert one[1][0] == two[1][0]


def test_a_band_beyond_the_dead_zone_is_a_turn():
    assert RudderBand(0.02, 0.05).certain_side == 1
    assert RudderBand(-0.05, -0.02).certain_side == -1
    assert RudderBand(-0.05, 0.02).certain_side == 0
    assert RudderBand(0.001, 0.05).certain_side == 0


def test_only_a_sum_can_be_certified():
    with pytest.raises(InputError, match="attention actor; only a sum"):
        certified_band(untrained("attention"), one_of(scenes(), 0), errors(*LEVELS[1]))


def test_a_scene_alone_is_the_same_as_among_others_and_may_be_empty():
    pilot, limit = load("paper-sum"), np.radians(5.0)
    together = action_bounds(pilot.actor, scenes(), errors(*LEVELS[1]), cells=5)
    for number in (0, 3):  # nobody is there in the first
        alone = certified_band(pilot, one_of(scenes(), number), errors(*LEVELS[1]), cells=5)
        assert alone.low_rad == pytest.approx(limit * together[0][number], abs=1e-5)
        assert alone.high_rad == pytest.approx(limit * together[1][number], abs=1e-5)
