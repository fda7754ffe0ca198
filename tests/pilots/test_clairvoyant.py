"""The clairvoyant search sails the world's own voyages and is never worse than its start."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.encounters.random import RandomEncounters
from glasshelm.learning.evaluate import sail_remembering
from glasshelm.learning.worlds import draw_encounters
from glasshelm.pilots.clairvoyant import Playback, record
from glasshelm.pilots.straight import StraightPilot
from glasshelm.planning.clairvoyant import SearchSettings, as_sailed, improve_all
from glasshelm.ships import SHIPS

SHIP, STEPS = SHIPS["large_ship"], 240
SETTINGS = SearchSettings(knots=6, samples=12, elites=3, iterations=4)


@pytest.fixture(scope="module")
def encounters():
    return draw_encounters(jax.random.key(3), 8, SHIP, RandomEncounters(targets=(2, 2)))


@jax.jit
def sail_all(encounters, rudders):
    return jax.vmap(lambda e, r: as_sailed(e, SHIP, r * SHIP.rudder_limit_rad))(encounters, rudders)


@jax.jit
def values(sailed):
    return jax.vmap(lambda s: s.value(SHIP, SETTINGS))(sailed)


def in_the_world(encounters, rudders):
    helm = Playback(jnp.asarray(rudders))
    return sail_remembering(helm, jnp.zeros((), jnp.int32), encounters, SHIP, STEPS, STEPS)


def test_an_imagined_voyage_is_the_world_s(encounters):
    rudders = 0.6 * jnp.sin(jnp.arange(STEPS) / 20.0 + jnp.arange(8)[:, None])
    imagined, real = sail_all(encounters, rudders), in_the_world(encounters, rudders)
    np.testing.assert_allclose(imagined.margin, real.margin[1], atol=1e-3)
    np.testing.assert_allclose(imagined.range_m, real.range_m[1], rtol=1e-3, atol=2.0)
    np.testing.assert_allclose(imagined.returned, real.return_by_task.sum(-1), atol=0.2)


def test_what_is_found_is_never_worse_than_where_it_began_and_mostly_better(encounters):
    start = record(StraightPilot(), encounters, SHIP, STEPS)
    np.testing.assert_array_equal(start, 0.0)
    bases = sail_all(encounters, start)
    found = improve_all(encounters, SHIP, bases, jax.random.key(0), SETTINGS)
    before, after = np.asarray(values(bases)), np.asarray(values(found))
    assert (after >= before - 1e-3 * np.abs(before)).all()
    assert (bases.margin > 0).sum() >= 3  # doing nothing does not do
    assert (found.margin > 0).sum() < (bases.margin > 0).sum()
    rudders = found.rudder_rad / SHIP.rudder_limit_rad
    assert float(jnp.abs(rudders).max()) <= 1.0 + 1e-6
    real = in_the_world(encounters, rudders)
    np.testing.assert_allclose(real.margin[1], found.margin, atol=2e-3)
