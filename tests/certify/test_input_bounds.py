"""The forms of the networks' inputs hold what the pilot sees, whatever the errors are."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.certify.scenes import KINDS, LEVELS, SCENES, SLOTS, errors, scenes

from glasshelm.certify.input_bounds import AffineForm, target_inputs, waypoint_inputs
from glasshelm.certify.measurements import N_OWN_ERRORS, N_TARGET_ERRORS, observe_plots, with_errors
from glasshelm.networks.input_features import encode

TRIES = 64


@jax.jit
def _inputs(scene, own, target):
    """The inputs [try, scene, ...], flat and fine, by the code that the pilot sails with."""

    def one(scene, own, target):
        observation = observe_plots(with_errors(scene, own, target))
        return [
            (encode(lens, observation.waypoint), encode(lens, observation.targets))
            for lens in LENSES
        ]

    return jax.vmap(jax.vmap(one), (None, 0, 0))(scene, own, target)


LENSES = ("flat", "fine")


def _holds(form: AffineForm, symbols: np.ndarray, found: np.ndarray) -> np.ndarray:
    midpoint = form.centre + np.einsum("...dk,...k->...d", form.slope, symbols)
    return np.abs(found - midpoint) <= form.slack + 1e-7


@pytest.mark.parametrize("level", LEVELS, ids=str)
@pytest.mark.parametrize("kind", KINDS)
def test_forms_hold_the_inputs(level, kind):
    scene, most = scenes(kind), errors(*level)
    drawn = np.random.default_rng(5)
    own = drawn.uniform(-1, 1, (TRIES, SCENES, N_OWN_ERRORS))
    target = drawn.uniform(-1, 1, (TRIES, SCENES, SLOTS, N_TARGET_ERRORS))
    own[::2], target[::2] = np.sign(own[::2]), np.sign(target[::2])
    units = np.asarray(most.own()), np.asarray(most.target())
    found = _inputs(
        scene,
        *(jnp.asarray(x * unit, jnp.float32) for x, unit in zip((own, target), units, strict=True)),
    )
    mine = np.broadcast_to(units[0], (SCENES, N_OWN_ERRORS)).astype(float)
    hers = np.broadcast_to(units[1], (SCENES, SLOTS, N_TARGET_ERRORS)).astype(float)
    waypoint, targets = (np.asarray(x, np.float64) for x in (scene.waypoint, scene.targets))
    both = np.concatenate([np.broadcast_to(own[:, :, None], target.shape), target], -1)
    alone = np.concatenate([own, np.zeros_like(own)], -1)
    for lens, (ahead, around) in zip(LENSES, found, strict=True):
        assert np.all(_holds(waypoint_inputs(lens, waypoint, mine), alone, np.asarray(ahead)))
        ours = np.broadcast_to(mine[:, None], hers.shape)
        form = target_inputs(lens, targets, ours, hers)
        held = _holds(form, both, np.asarray(around))
        assert np.all(held | ~np.asarray(scene.present)[..., None])
        if not any(level) and kind == "around":
            assert np.all(form.slack[np.asarray(scene.present)] < 2e-3)
