import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import jax
import numpy as np
import pytest
from safetensors.numpy import load_file

import glasshelm
from glasshelm.cli.train import run
from glasshelm.core.errors import InputError
from glasshelm.core.terminal import Terminal
from glasshelm.encounters.random_encounters import random_scenario
from glasshelm.env.step import reset
from glasshelm.networks.checkpoint import file_sha256, read_header
from glasshelm.pilots.learned import read_pilot
from glasshelm.ship.nomoto import ship_named
from glasshelm.training.config import preset_named
from glasshelm.training.init_actor import init_actor
from glasshelm.training.metrics_log import read_metrics
from glasshelm.training.stages import initial_policy
from glasshelm.training.trainer import BEST_FILE, FINAL_FILE, TrainerSettings, train
from glasshelm.training.training_progress import TrainingProgress
from glasshelm.training.training_state import STATE_FILE

pytestmark = pytest.mark.slow

QUIET = TrainerSettings(tensorboard=False)


class Interrupting(TrainingProgress):
    """Sends Ctrl-C when a stage has reached a unit."""

    def __init__(self, stage=None, number=None):
        super().__init__(Terminal(quiet=True))
        self.wanted, self.stage = (stage, number), None

    def start_stage(self, name, unit, total, completed):
        super().start_stage(name, unit, total, completed)
        self.stage = name

    def advance(self, number):
        super().advance(number)
        if (self.stage, number) == self.wanted:
            os.kill(os.getpid(), signal.SIGINT)


@pytest.fixture(scope="module", params=["tiny", "tiny-fast", "tiny-glassbox"])
def whole(request, tmp_path_factory):
    """A training from beginning to end, never interrupted."""
    folder = tmp_path_factory.mktemp(request.param)
    assert train(preset_named(request.param), folder, QUIET, False, Interrupting())
    return request.param, folder


def assert_same(first: Path, second: Path):
    one, two = load_file(first), load_file(second)
    assert set(one) == set(two)
    for name, tensor in one.items():
        assert tensor.tobytes() == two[name].tobytes(), name


def assert_same_training(first: Path, second: Path):
    for name in (BEST_FILE, FINAL_FILE):
        assert file_sha256(first / name) == file_sha256(second / name)
    assert_same(first / STATE_FILE, second / STATE_FILE)
    replays = [sorted(p.name for p in f.glob("replay-*.safetensors")) for f in (first, second)]
    assert replays[0] == replays[1]
    for replay in replays[0]:
        assert_same(first / replay, second / replay)


def test_interrupted_and_resumed_is_bit_identical(whole, tmp_path):
    name, reference = whole
    config = preset_named(name)
    stops = {
        "tiny": [("ddpg", 7), ("ddpg", 53)],
        "tiny-fast": [("dagger", 2), ("critic", 41)],
        "tiny-glassbox": [("regression", 1), ("regression", 2)],
    }
    for number, stop in enumerate(stops[name]):
        assert not train(config, tmp_path, QUIET, number > 0, Interrupting(*stop))
    assert train(config, tmp_path, QUIET, True, Interrupting())
    assert_same_training(reference, tmp_path)
    numbers = [line["number"] for line in read_metrics(tmp_path)]
    assert numbers == [line["number"] for line in read_metrics(reference)]


def test_killed_and_resumed_is_bit_identical(whole, tmp_path):
    name, reference = whole
    if name != "tiny":
        pytest.skip("one subprocess is enough")
    command = [sys.executable, "-m", "glasshelm", "train", "--preset", name]
    command += ["--out", str(tmp_path), "--snapshot-s", "0", "--no-tensorboard"]
    cache = {"JAX_COMPILATION_CACHE_DIR": str(jax.config.jax_compilation_cache_dir)}
    process = subprocess.Popen(command, env=os.environ | cache, stdout=subprocess.DEVNULL)
    deadline = time.monotonic() + 600
    try:
        while not (tmp_path / STATE_FILE).exists():
            assert process.poll() is None
            assert time.monotonic() < deadline, "it does not train"
            time.sleep(0.01)
    finally:
        process.kill()
        process.wait()
    assert not (tmp_path / FINAL_FILE).exists()
    assert train(preset_named(name), tmp_path, QUIET, True, Interrupting())
    assert_same_training(reference, tmp_path)


def test_the_log_has_losses_rates_and_speed(whole):
    name, folder = whole
    last = read_metrics(folder)[-1]
    of_the_fit = (
        ("cost_deviance",) if name == "tiny-glassbox" else ("critic_loss", "waypoint_correlation")
    )
    for key in (*of_the_fit, "intrusions", "collisions_long", "updates_per_s", "env_steps"):
        assert np.isfinite(last[key])


def test_the_file_alone_rebuilds_the_pilot(whole):
    _, folder = whole
    header = read_header(folder / FINAL_FILE)
    assert json.dumps(header["config"])
    pilot = read_pilot(folder / FINAL_FILE, "final")
    assert pilot.critic is not None
    ship = ship_named("paper")
    observation = reset(random_scenario(0, ship).encounter, ship).observation
    assert -1 < float(glasshelm.explain(pilot, observation).rudder) < 1


def test_weights_have_moved_and_stay_finite(whole):
    name, folder = whole
    trained = load_file(folder / FINAL_FILE)
    if name == "tiny-glassbox":
        key, untrained = (
            "critic.network.weights.0",
            initial_policy(preset_named(name)).critic.network,
        )
    else:
        key, untrained = "actor.head.weights.0", init_actor(preset_named(name)).head
    assert not np.array_equal(trained[key], np.asarray(untrained.weights[0]))
    assert all(np.isfinite(tensor).all() for tensor in trained.values())


def test_the_time_limit_stops_cleanly_and_can_be_resumed(whole, tmp_path):
    name, reference = whole
    config = preset_named(name)
    assert train(config, tmp_path, TrainerSettings(0.0, tensorboard=False), False, Interrupting())
    assert read_header(tmp_path / FINAL_FILE)["summary"]["validation"]["stopped_early"]
    if name == "tiny":
        assert train(config, tmp_path, QUIET, True, Interrupting())
        assert_same(reference / FINAL_FILE, tmp_path / FINAL_FILE)


def test_folders_that_cannot_be_used(whole, tmp_path):
    name, folder = whole
    config = preset_named(name)
    with pytest.raises(InputError, match="holds a training"):
        train(config, folder, QUIET, False, Interrupting())
    with pytest.raises(InputError, match="no state"):
        train(config, tmp_path, QUIET, True, Interrupting())
    with pytest.raises(InputError, match="another configuration"):
        train(preset_named("paper"), folder, QUIET, True, Interrupting())


def test_critics_alone_for_an_actor_that_is_there(whole, tmp_path):
    name, folder = whole
    if name != "tiny-fast":
        pytest.skip("of the preset with DAgger")
    start = folder / BEST_FILE
    overrides = (f"init_from={start}", "dagger.iterations=0", "ddpg.env_steps=300")
    run(name, out=tmp_path, overrides=overrides, tensorboard=False)
    before, after = load_file(start), load_file(tmp_path / FINAL_FILE)
    actor = [key for key in before if key.startswith("actor.")]
    assert actor
    for key in actor:
        np.testing.assert_array_equal(before[key], after[key])
    assert read_header(tmp_path / FINAL_FILE)["config"]["init_from"] == BEST_FILE
