import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.untrained import SHIP, observation, untrained, write_weights

import glasshelm
from glasshelm.core.errors import InputError
from glasshelm.encounters.random_encounters import PAPER
from glasshelm.env.step import EnvSettings
from glasshelm.env.training_envelope import MAX_FEATURE
from glasshelm.networks.checkpoint import CheckpointError, file_sha256, read_header, save_tree
from glasshelm.pilots import decide, registry
from glasshelm.pilots.glassbox import GlassboxPilot
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.straight import StraightPilot
from glasshelm.training.config import preset_named
from glasshelm.training.init_actor import init_actor
from glasshelm.training.stages import initial_policy
from glasshelm.training.training_state import save_pilot


@pytest.fixture
def weights(tmp_path):
    path = tmp_path / "mine.safetensors"
    write_weights(path)
    return path


def one_line(caught) -> str:
    text = str(caught.value)
    assert "\n" not in text
    return text


@pytest.mark.parametrize(("kind", "critic"), [("attention", True), ("sum", True), ("sum", False)])
def test_weights_come_back_as_they_went(tmp_path, kind, critic):
    path = tmp_path / f"{kind}.safetensors"
    sha = write_weights(path, kind, critic)
    pilot, original = glasshelm.load(path), untrained(kind, critic)
    assert isinstance(pilot, Pilot)
    assert (pilot.name, pilot.weights_sha256) == (kind, sha)
    assert (pilot.critic is None) == (not critic)
    assert eqx.tree_equal((pilot.actor, pilot.critic), (original.actor, original.critic))
    assert pilot.trained.ship == SHIP


@pytest.mark.slow
def test_decision_is_the_actors_and_within_the_rudder_limit(weights):
    pilot = glasshelm.load(str(weights))
    for ships in (0, 3):
        seen = observation(ships)
        decided = glasshelm.explain(pilot, seen)
        np.testing.assert_allclose(decided.rudder, pilot.actor(seen), atol=1e-6)
        assert abs(float(decided.rudder)) <= 1
        assert decided.explanation.value.by_ship.shape == (ships,)


def test_more_ships_within_the_same_slots_compile_nothing():
    pilot = untrained()
    glasshelm.explain(pilot, observation(4))
    before = decide._decide._cached._cache_size()
    glasshelm.explain(pilot, observation(3))
    assert decide._decide._cached._cache_size() == before


def test_a_number_that_is_none_is_named():
    pilot, seen = untrained(), observation(3)
    bad = eqx.tree_at(lambda o: o.targets, seen, seen.targets.at[1, 2, 4].set(jnp.nan))
    with pytest.raises(InputError, match=r"ship 2 .*vy") as caught:
        glasshelm.explain(pilot, bad)
    one_line(caught)
    bad = eqx.tree_at(lambda o: o.waypoint, seen, seen.waypoint.at[0, 1].set(jnp.inf))
    with pytest.raises(InputError, match=r"waypoint .*dy"):
        glasshelm.explain(pilot, bad)
    empty = eqx.tree_at(lambda o: o.present, seen, jnp.zeros(3, bool))
    hidden = eqx.tree_at(lambda o: o.targets, empty, jnp.full_like(seen.targets, jnp.nan))
    assert np.isfinite(glasshelm.explain(pilot, hidden).rudder)


def test_an_unknown_pilot_is_answered_with_the_known_ones(monkeypatch, tmp_path):
    write_weights(tmp_path / "bundled-one.safetensors")
    monkeypatch.setattr(registry, "WEIGHTS", tmp_path)
    with pytest.raises(
        InputError, match=r"unknown pilot 'nobody'.*bundled-one, bundled-one-guarded, straight"
    ) as caught:
        registry.pilot_named("nobody")
    one_line(caught)
    assert registry.pilot_named("bundled-one").name == "bundled-one"
    assert isinstance(registry.pilot_named("straight"), StraightPilot)
    with pytest.raises(InputError, match="unknown pilot 'nobody': choose one of bundled-one"):
        registry.load("nobody")
    with pytest.raises(InputError, match=r"'straight' is no learned one: glasshelm.pilot"):
        registry.load("straight")
    with pytest.raises(InputError, match="can only be evaluated"):
        registry.pilot_named("paper-clairvoyant")


def test_missing_damaged_and_truncated_files(weights):
    with pytest.raises(CheckpointError, match="no such weights file"):
        glasshelm.load(weights.with_name("none.safetensors"))
    whole = weights.read_bytes()
    for bad in (b"", whole[:5], whole[:300], whole[:-7], b"\x00" * 100, b"pickle" * 100):
        weights.write_bytes(bad)
        with pytest.raises(CheckpointError, match=r"mine\.safetensors: damaged") as caught:
            glasshelm.load(weights)
        one_line(caught)


@pytest.mark.parametrize(
    ("header", "said"),
    [
        ({"actor": {"kind": "transformer"}}, "unknown actor 'transformer'"),
        ({"actor": {"kind": "sum", "layers": 3}}, "'actor' does not fit this version"),
        ({"actor": {"kind": "sum"}}, "tensor"),
        ({"actor": None}, "'critic' does not fit this version (kind 'None')"),
        ({"critic": None}, "unexpected tensor critic"),
        ({"actor": None, "critic": {"kind": "course"}}, "unexpected tensor actor"),
        ({"actor": None, "critic": {"kind": "course", "of_target": [0]}}, "a layer of width 0"),
        ({"actor": None, "critic": {"kind": "course", "table": 3}}, "'critic' does not fit"),
        ({"critic": {"hidden": [7]}}, "tensor critic"),
        ({"critic": {"hidden": "wide"}}, "'critic' does not fit this version"),
        ({"critic": {"hidden": [-4]}}, "a layer of width -4"),
        ({"ship": "canoe"}, "unknown ship 'canoe'"),
        ({"ship": {"gain_1_s": 0.1}}, "'ship' does not fit this version"),
        ({"ship": {"gain_1_s": "much"}}, "'ship' does not fit this version"),
        ({"env": {"step_s": "short"}}, "'env' does not fit this version"),
        ({"encounters": {"ships": 3}}, "'encounters' does not fit this version"),
    ],
)
def test_another_architecture_is_told_in_one_line(tmp_path, header, said):
    path = tmp_path / "other.safetensors"
    write_weights(path, **{f"other_{name}": part for name, part in header.items()})
    with pytest.raises(CheckpointError, match="weights of another architecture") as caught:
        glasshelm.load(path)
    assert said in one_line(caught)
    assert "other.safetensors" in one_line(caught)


TINY = preset_named("tiny-glassbox")


def write_steering(path, **changed):
    """A critic that steers, with a header that may say something else."""
    policy = initial_policy(TINY)
    save_pilot(path, policy, None, TINY, {})
    if changed:
        header = read_header(path)
        header["critic"] |= changed
        save_tree(path, {"critic": policy.critic}, header)
    return policy


def test_a_critic_that_steers_comes_back_as_it_went(tmp_path):
    path = tmp_path / "steering.safetensors"
    policy = write_steering(path)
    pilot = glasshelm.pilot(path)
    assert isinstance(pilot, GlassboxPilot)
    assert isinstance(pilot, Pilot)
    assert eqx.tree_equal(pilot.critic, policy.critic)
    assert pilot.trained.env.episode_steps == 4 * 12
    assert pilot.weights_sha256 == file_sha256(path)
    why = jax.tree.map(jnp.asarray, glasshelm.explain(pilot, observation(3)).explanation)
    parts = why.value.waypoint + why.value.helm + why.value.by_ship.sum()
    np.testing.assert_allclose(why.value.total, parts, atol=1e-4)
    assert float(jnp.nanmax(why.manoeuvre.alternatives.total)) <= float(why.value.total) + 1e-4
    with pytest.raises(InputError, match="cannot be guarded"):
        registry.pilot_named(f"{path}-guarded")
    with pytest.raises(InputError, match="no actor to start from"):
        init_actor(dataclasses.replace(preset_named("tiny"), init_from=str(path)))
    again = initial_policy(dataclasses.replace(TINY, seed=1, init_from=str(path)))
    assert eqx.tree_equal(again.critic, policy.critic)
    with pytest.raises(InputError, match="critic is not the one to be trained"):
        initial_policy(dataclasses.replace(preset_named("glassbox"), init_from=str(path)))


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"kind": "oracle"}, "kind 'oracle'"),
        ({"hidden": [8, 8]}, "lacks tensor"),
        ({"table": {"durations_s": [1.0] * 90_000}}, "manoeuvres"),
        ({"costs": {"step_s": 0.0}}, "in steps of 0 s"),
        ({"costs": {"step_s": 1e-9}}, "in steps of 1e-09 s"),
        ({"layers": 3}, "unknown field 'layers'"),
    ],
)
def test_a_critic_of_another_kind_is_told_in_one_line(tmp_path, changed, said):
    path = tmp_path / "other.safetensors"
    write_steering(path, **changed)
    with pytest.raises(CheckpointError, match="weights of another architecture") as caught:
        glasshelm.pilot(path)
    assert said in one_line(caught)


def test_a_file_of_other_tensors_is_not_a_pilot(tmp_path):
    path = tmp_path / "state.safetensors"
    save_tree(path, {"state": jnp.zeros(3)}, {"place": 1})
    with pytest.raises(CheckpointError, match="no 'actor'"):
        glasshelm.load(path)


def test_a_trained_pilot_knows_what_it_was_trained_on(tmp_path):
    path = tmp_path / "trained.safetensors"
    env = EnvSettings(episode_steps=480)
    described = {"encounters": dataclasses.asdict(PAPER), "env": dataclasses.asdict(env)}
    write_weights(path, **{f"other_{name}": part for name, part in described.items()})
    pilot = glasshelm.load(path)
    assert pilot.trained.encounters == PAPER
    assert pilot.trained.env == env


@pytest.mark.slow
@pytest.mark.parametrize("name", registry.guardable_pilots())
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_largest_that_is_let_through_is_decided_in_numbers(name, sign):
    pilot, seen = glasshelm.load(name), observation(2)
    seen = jax.tree.map(
        lambda x: x if x.dtype == bool else jnp.full_like(x, sign * MAX_FEATURE), seen
    )
    told = jax.tree.leaves(eqx.filter(glasshelm.explain(pilot, seen), eqx.is_array))
    assert all(np.isfinite(leaf).all() for leaf in told if leaf.dtype.kind == "f")
    with pytest.raises(InputError, match="impossible"):
        glasshelm.explain(pilot, jax.tree.map(lambda x: x if x.dtype == bool else x * 1e32, seen))
