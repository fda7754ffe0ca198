"""Raw plots say the same as what the pilot saw."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from benchmarks.certify import empty_plots, push_plots

from glasshelm.certify.measurements import observe_plots, with_errors
from glasshelm.encounters.random_encounters import RandomEncounters, random_encounter
from glasshelm.env.step import reset, step, targets_at, waypoint_of
from glasshelm.ship.nomoto import SHIPS

SHIP = SHIPS["paper"]


@functools.cache
@jax.jit
def _sailed():
    encounter = random_encounter(jax.random.key(2), SHIP, RandomEncounters(targets=(3, 3)))
    state, scene, first = reset(encounter, SHIP), empty_plots(encounter.present.shape[-1]), True
    for rudder in (None, 0.08, 0.08, -0.05):
        if rudder is not None:
            state = step(encounter, state, jnp.asarray(rudder), SHIP).state
        motion = targets_at(encounter, state.step * 5.0)
        waypoint = waypoint_of(encounter, state.leg)
        scene = push_plots(scene, state.own, waypoint, motion, motion.present, first)
        first = False
    return state, scene


@pytest.mark.slow
def test_the_plots_of_a_voyage_show_what_the_pilot_saw():
    state, scene = _sailed()
    observation = observe_plots(scene)
    np.testing.assert_allclose(observation.waypoint, state.observation.waypoint, atol=3e-6)
    np.testing.assert_allclose(observation.targets, state.observation.targets, atol=2e-5)


def test_own_ship_shown_too_far_east_sees_all_too_far_west():
    _, scene = _sailed()
    none = jnp.zeros((scene.present.shape[0], 4))
    mine = with_errors(scene, jnp.array([50.0, 0.0, 0.0, 0.0]), none)
    theirs = with_errors(scene, jnp.zeros(4), none.at[:, 0].set(-50.0))
    np.testing.assert_allclose(mine.targets, theirs.targets, atol=1e-3)
    np.testing.assert_allclose(mine.waypoint[:, 0], scene.waypoint[:, 0] - 50.0, atol=1e-2)
    assert np.all(np.asarray(theirs.waypoint) == np.asarray(scene.waypoint))
