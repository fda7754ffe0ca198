"""The clairvoyant search sails the world's own voyages and is never worse than its start."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.core.geometry import Vector
from glasshelm.encounters.random_encounters import RandomEncounters, random_encounters
from glasshelm.pilots.clairvoyant import Clairvoyant, OraclePilot, Playback, record
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.straight import StraightPilot
from glasshelm.planning.cross_entropy_search import (
    KnownEncounter,
    SearchSettings,
    improve_all,
    rollout_rudders,
)
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.rollout import Case, rollout

pytestmark = pytest.mark.slow

SHIP, STEPS, WORLDS = SHIPS["large_ship"], 240, 8
SETTINGS = SearchSettings(knots=6, samples=12, elites=3, iterations=4)


@pytest.fixture(scope="module")
def known() -> KnownEncounter:
    settings = RandomEncounters(targets=(2, 2))
    return KnownEncounter.still(
        random_encounters(jax.random.key(3), WORLDS, SHIP, settings), SHIP, STEPS
    )


@jax.jit
def sail_all(known, rudders):
    return jax.vmap(lambda k, r: rollout_rudders(k, r * k.ship.rudder_limit_rad))(known, rudders)


@jax.jit
def values(sailed):
    return jax.vmap(lambda s: s.value(SHIP, SETTINGS))(sailed)


def in_the_world(known, rudders):
    """What an examination measures of the same rudders."""
    hull = np.full(known.encounter.present.shape, 100.0, np.float32)
    cases = Case(known.encounter, known.ship, known.steps, hull, hull)
    return rollout(Playback(jnp.asarray(rudders)), cases, STEPS)


def weaving():
    return 0.6 * jnp.sin(jnp.arange(STEPS) / 20.0 + jnp.arange(WORLDS)[:, None])


def test_an_imagined_voyage_is_the_world_s(known):
    imagined, real = sail_all(known, weaving()), in_the_world(known, weaving())
    np.testing.assert_allclose(imagined.margin, real.margin[:, 1], atol=1e-3)
    np.testing.assert_allclose(imagined.range_m, real.range_m[:, 1], rtol=1e-3, atol=2.0)
    np.testing.assert_allclose(imagined.returned, real.return_by_task.sum(-1), atol=0.2)


def test_what_comes_after_the_last_step_or_the_last_waypoint_does_not_count(known):
    """Steps: some voyages last half as long. Waypoint: some are all but there at once."""
    steps = jnp.where(jnp.arange(WORLDS) % 2 == 0, STEPS // 2, STEPS)
    short = dataclasses.replace(known, steps=steps)
    ahead = known.encounter.own.speed_m_s[:, None] * 600.0
    near = jnp.where(jnp.arange(WORLDS)[:, None] % 3 == 0, ahead, known.encounter.route.y)
    route = Vector(jnp.zeros_like(near), near)
    short = eqx.tree_at(lambda k: k.encounter.route, short, route)
    imagined, real = sail_all(short, 0.1 * weaving()), in_the_world(short, 0.1 * weaving())
    assert real.arrived.any()
    assert not real.arrived.all()
    np.testing.assert_allclose(imagined.margin, real.margin[:, 1], atol=1e-3)
    np.testing.assert_allclose(imagined.range_m, real.range_m[:, 1], rtol=1e-3, atol=2.0)
    longer = sail_all(known, 0.1 * weaving())
    assert (np.abs(longer.margin - imagined.margin) > 1e-2).any()


def test_what_is_found_is_never_worse_than_where_it_began_and_mostly_better(known):
    start = record(StraightPilot(), known, STEPS)
    np.testing.assert_array_equal(start, 0.0)
    bases = sail_all(known, start)
    found = improve_all(known, bases, jax.random.key(0), SETTINGS)
    before, after = np.asarray(values(bases)), np.asarray(values(found))
    assert (after >= before - 1e-3 * np.abs(before)).all()
    assert (bases.margin > 0).sum() >= 3  # doing nothing does not do
    assert (found.margin > 0).sum() < (bases.margin > 0).sum()
    rudders = found.rudder_rad / SHIP.rudder_limit_rad
    assert float(jnp.abs(rudders).max()) <= 1.0 + 1e-6
    real = in_the_world(known, rudders)
    np.testing.assert_allclose(real.margin[:, 1], found.margin, atol=2e-3)


def test_what_is_found_does_not_depend_on_the_company(known):
    seer = Clairvoyant(SHIP, "seer", (StraightPilot(),), SETTINGS)
    assert isinstance(seer, OraclePilot)
    assert not isinstance(seer, Pilot)
    assert not isinstance(StraightPilot(), OraclePilot)
    all_of_them = seer.policy_for(known).rudders
    some = np.array([5, 2, 5])
    np.testing.assert_array_equal(
        seer.policy_for(jax.tree.map(lambda x: x[some], known)).rudders, all_of_them[some]
    )
    assert np.abs(all_of_them).max() > 0.1
