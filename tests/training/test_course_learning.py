"""A critic of courses that learns from its own experience, and steers."""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.training.test_trainer import QUIET, Interrupting, assert_same

import glasshelm
from glasshelm.core.errors import InputError
from glasshelm.networks.checkpoint import file_sha256
from glasshelm.pilots.glassbox import GlassboxPilot
from glasshelm.pilots.registry import pilot_named
from glasshelm.planning.course_critic import CourseCritic, CourseCriticSizes
from glasshelm.planning.manoeuvres import Manoeuvres
from glasshelm.planning.simulated_critic import simulate_manoeuvres
from glasshelm.planning.situation import situation_of
from glasshelm.ship.nomoto import SHIPS
from glasshelm.training.config import preset_named
from glasshelm.training.course_learning import (
    CourseLearningSettings,
    Rows,
    collect_experience,
    course_loss,
)
from glasshelm.training.encounter_mix import EncounterMix
from glasshelm.training.init_actor import init_actor
from glasshelm.training.trainer import BEST_FILE, FINAL_FILE, train
from glasshelm.training.training_state import STATE_FILE
from glasshelm.training.vector_env import reset_batch

SHIP, SIZES = SHIPS["paper"], CourseCriticSizes((8,), (8,))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A training from beginning to end, never interrupted."""
    folder = tmp_path_factory.mktemp("tiny-course")
    assert train(preset_named("tiny-course"), folder, QUIET, False, Interrupting())
    return folder


@pytest.mark.slow
def test_interrupted_and_resumed_is_bit_identical(folder, tmp_path):
    config = preset_named("tiny-course")
    assert not train(config, tmp_path, QUIET, False, Interrupting("course", 2))
    assert train(config, tmp_path, QUIET, True, Interrupting())
    for name in (BEST_FILE, FINAL_FILE):
        assert file_sha256(folder / name) == file_sha256(tmp_path / name)
    assert_same(folder / STATE_FILE, tmp_path / STATE_FILE)


@pytest.mark.slow
def test_the_file_is_a_pilot_whose_explanation_is_its_decision(folder):
    pilot = glasshelm.load(folder / BEST_FILE)
    assert isinstance(pilot, GlassboxPilot)
    assert pilot.weights_sha256 == file_sha256(folder / BEST_FILE)
    frame = next(iter(glasshelm.simulate(glasshelm.scenario("random:35"), pilot)))
    assert frame.weights_sha256 == pilot.weights_sha256
    assert frame.outside_training == ["4 ships selected (trained: at most 2)"]
    assert {a.name for a in frame.alternatives} >= {"keep", "to the waypoint", "without ships"}
    for value in (frame.value, *(a.value for a in frame.alternatives)):
        parts = value.waypoint + value.collision + value.helm
        assert parts == pytest.approx(value.total, abs=1e-4)
        assert value.total <= frame.value.total + 1e-4
    assert sum(t.q for t in frame.targets) == pytest.approx(frame.value.collision, abs=1e-4)


@pytest.mark.slow
def test_it_has_no_actor_to_be_guarded_or_to_start_from(folder):
    with pytest.raises(InputError, match="cannot be guarded"):
        pilot_named(f"{folder / BEST_FILE}-guarded")
    config = dataclasses.replace(preset_named("tiny"), init_from=str(folder / BEST_FILE))
    with pytest.raises(InputError, match="holds no actor"):
        init_actor(config)


@functools.cache
def tried() -> tuple:
    """One manoeuvre in each of twelve encounters, from the start, to the end."""
    settings = CourseLearningSettings(
        EncounterMix((0, 4, 4, 4)), decisions=40, labelled=1, begins_before=1, explore=1.0
    )
    critic = jax.jit(CourseCritic, static_argnums=0)(SIZES, jax.random.key(1))

    @jax.jit
    def collected(key):
        encounters = settings.mix.draw(key, SHIP)
        experience = collect_experience(critic, encounters, key, SHIP, settings)
        return encounters, reset_batch(encounters, SHIP).observation, experience

    return collected(jax.random.key(2))


def test_returns_are_what_the_manoeuvres_lead_to():
    """Found a second time by simulating them ahead."""
    encounters, observation, experience = tried()
    turn_sine, turn_cosine, held = experience.waypoint.inputs[:, jnp.array([0, 1, 4])].T
    costs = dataclasses.replace(SIZES.costs, horizon_s=2400.0)

    def ahead(observation, turn, held):
        at = situation_of(observation, SHIP)
        zero = jnp.zeros(1)
        one = Manoeuvres((turn - at.bearing_rad)[None], held[None], zero, zero)
        waypoint, met = simulate_manoeuvres(one, at, SHIP, costs)
        return waypoint[0], -jnp.stack([m.value(SHIP.loa_m, costs)[0] for m in met])

    turn = jnp.arctan2(turn_sine, turn_cosine)
    reward, cost = jax.jit(jax.vmap(ahead))(observation, turn, 1000.0 * held)
    np.testing.assert_allclose(experience.waypoint.cost, 0.2 * 480 - reward, rtol=0.03, atol=0.3)
    np.testing.assert_allclose(
        experience.target.cost, cost[np.asarray(encounters.present)], rtol=0.1, atol=2.0
    )
    assert np.asarray(experience.target.cost).max() > 10.0
    assert np.asarray(experience.target.weight).all()


def test_a_cost_below_zero_is_right_where_there_is_none():
    rows = Rows(jnp.zeros((3, 1)), jnp.array([0.0, 0.0, 1.0]), jnp.ones(3))
    exact = jnp.array([-5.0, 0.0, np.log(2.0)])
    assert float(course_loss(exact, rows)) == pytest.approx(0.0, abs=1e-9)
    high, low = (float(course_loss(exact + d, rows, caution=2.0)) for d in (0.1, -0.1))
    assert high == pytest.approx(2 * 0.01 / 3, rel=1e-3)
    assert low == pytest.approx(3 * 0.01 / 3, rel=1e-3)


def test_what_was_not_tried_does_not_count():
    rows = Rows(jnp.zeros((2, 1)), jnp.array([10.0, 3.0]), jnp.array([0.0, 1.0]))
    assert float(course_loss(jnp.array([7.0, np.log(4.0)]), rows)) == pytest.approx(0.0, abs=1e-9)
