"""The band holds every rudder that errors can bring, and is the rudder without errors."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.untrained import untrained

from glasshelm.certify.attack import attacked_rudders, random_rudders
from glasshelm.certify.band import action_bounds, certified_band
from glasshelm.certify.scene import Scene, SensorErrors, observed
from glasshelm.errors import InputError
from glasshelm.pilots.catalogue import load

#: Scenes of three slots: one program for all tests.
SCENES, SLOTS = 8, 3
LEVELS = ((0.0, 0.0, 0.0), (10.0, 0.5, 0.05), (100.0, 3.0, 0.25))


def errors(position_m: float, course_deg: float, speed_m_s: float) -> SensorErrors:
    numbers = (position_m, np.radians(course_deg), speed_m_s) * 2
    return SensorErrors(*(jnp.asarray(x, jnp.float32) for x in numbers))


def scenes(astern: bool = False) -> Scene:
    """Straight runners around a turning own ship; ``astern``: all within 0.2° of dead astern."""
    drawn = np.random.default_rng(3)
    shape = (SCENES, SLOTS, 5)
    age = 5.0 * np.arange(5)
    heading = drawn.uniform(-3, 3, (SCENES, 1)) - 0.004 * age * drawn.integers(0, 2, (SCENES, 1))
    range_m = drawn.uniform(800, 12_000, (SCENES, SLOTS, 1))
    away = drawn.uniform(-np.pi, np.pi, (SCENES, SLOTS, 1))
    if astern:
        away = heading[:, None, :1] + np.pi + drawn.uniform(-0.003, 0.003, (SCENES, SLOTS, 1))
    course = drawn.uniform(-np.pi, np.pi, (SCENES, SLOTS, 1))
    speed = drawn.uniform(3, 8, (SCENES, SLOTS, 1))
    east = range_m * np.sin(away) - age * speed * np.sin(course)
    north = range_m * np.cos(away) - age * speed * np.cos(course)
    own = np.broadcast_to(heading[:, None], shape)
    rows = [east, north, own, np.full(shape, 5.144), course + 0 * age, speed + 0 * age]
    ahead = [0 * heading + 9_000, 0 * heading + 20_000, heading, 0 * heading + 5.144]
    ahead += [0 * heading, 0 * heading]
    present = np.ones((SCENES, SLOTS), bool)
    present[0], present[1, 1:] = False, False
    arrays = [np.stack(np.broadcast_arrays(*x), -1).astype(np.float32) for x in (ahead, rows)]
    return Scene(jnp.asarray(arrays[0]), jnp.asarray(arrays[1]), jnp.asarray(present))


@pytest.fixture(scope="module")
def actor():
    return load("paper-sum").actor


@pytest.fixture(scope="module")
def bounds(actor):
    quick = {"xla_backend_optimization_level": 0, "xla_llvm_disable_expensive_passes": True}
    return jax.jit(jax.vmap(lambda s, e: action_bounds(actor, s, e), (0, None)), compiler_options=quick)


@pytest.fixture(scope="module")
def rudders(actor):
    def one(scene, errors, key):
        drawn = random_rudders(actor, scene, errors, key, 256)
        return jnp.concatenate([drawn, attacked_rudders(actor, scene, errors, key, 2, 10)])

    return jax.jit(jax.vmap(one, (0, None, 0)))


@pytest.mark.parametrize("level", LEVELS, ids=str)
@pytest.mark.parametrize("astern", [False, True], ids=["around", "astern"])
def test_no_error_brings_a_rudder_out_of_the_band(actor, bounds, rudders, level, astern):
    scene = scenes(astern)
    low, high = map(np.asarray, bounds(scene, errors(*level)))
    found = np.asarray(rudders(scene, errors(*level), jax.random.split(jax.random.key(0), SCENES)))
    assert np.all(found >= low[:, None])
    assert np.all(found <= high[:, None])
    if level == LEVELS[0] and not astern:
        rudder = np.asarray(actor(jax.vmap(observed)(scene)))
        np.testing.assert_allclose(low, rudder, atol=2e-3)
        np.testing.assert_allclose(high, rudder, atol=2e-3)


def test_who_is_not_there_does_not_matter(bounds):
    scene = scenes()
    other = Scene(scene.waypoint, scene.targets.at[0].multiply(-3.0), scene.present)
    for one, two in zip(
        bounds(scene, errors(*LEVELS[1])), bounds(other, errors(*LEVELS[1])), strict=True
    ):
        assert float(one[0]) == float(two[0])


def test_only_a_sum_can_be_certified():
    scene = jax.tree.map(lambda x: x[0], scenes())
    with pytest.raises(InputError, match="only the rudder of a sum actor"):
        certified_band(untrained("attention"), scene, errors(*LEVELS[1]))
