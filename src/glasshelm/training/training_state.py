"""The complete state of a training on disk, so that it continues bit for bit.

``state.safetensors`` holds everything but the replay buffer; the buffer (hundreds of
megabytes) has a file of its own, written before and named in the header of the
state. The old pair is deleted last: a crash at any instant leaves one complete pair.
"""

import dataclasses
import os
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import msgspec

from glasshelm import __version__
from glasshelm.core.errors import InputError
from glasshelm.networks.checkpoint import load_tree, read_header, save_tree
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.training.config import TrainConfig, config_from_dict, config_to_dict
from glasshelm.training.ddpg import DdpgState
from glasshelm.training.init_actor import init_files
from glasshelm.training.manoeuvre_regression import HeldCourses
from glasshelm.training.validation import AnyPolicy

STATE_FILE = "state.safetensors"


@dataclasses.dataclass(frozen=True)
class StagePosition:
    """How far a training is: units done of a stage, the best selection loss yet, seconds spent."""

    stage: int = 0
    units: int = 0
    best_loss: float | None = None
    seconds: float = 0.0


class _Header(msgspec.Struct):
    version: str
    config: dict[str, Any]
    position: StagePosition
    replay: str | None


def save_snapshot(
    folder: Path,
    state: Any,
    best_policy: AnyPolicy,
    position: StagePosition,
    config: TrainConfig,
) -> None:
    """Write the pair of files."""
    replay_file = None
    if isinstance(state, DdpgState):
        replay_file = f"replay-{position.stage}-{position.units}.safetensors"
        save_tree(folder / replay_file, state.replay, {})
        state = _without_replay(state)
    header = _Header(__version__, config_to_dict(config), position, replay_file)
    tree = {"state": state, "best_policy": best_policy}
    save_tree(folder / STATE_FILE, tree, msgspec.to_builtins(header))
    # Also what a killed process left half-written.
    for old in (*folder.glob("replay-*.safetensors"), *folder.glob(".*-replay-*.safetensors")):
        if old.name != replay_file:
            old.unlink(missing_ok=True)


def read_position(folder: Path) -> tuple[StagePosition, TrainConfig]:
    """How far a snapshot is and its configuration; InputError if there is none."""
    if not os.path.isfile(folder / STATE_FILE):
        raise InputError(f"{folder}: no {STATE_FILE} to resume; leave --resume out to start anew")
    header = _read_header(folder)
    return header.position, config_from_dict(header.config)


def _read_header(folder: Path) -> _Header:
    try:
        return msgspec.convert(read_header(folder / STATE_FILE), _Header)
    except msgspec.ValidationError as error:
        raise InputError(f"{folder / STATE_FILE}: not the state of a training ({error})") from None


def load_snapshot(folder: Path, state: Any, best_policy: AnyPolicy) -> tuple[Any, AnyPolicy]:
    """The saved state and best policy; the arguments give their structure."""
    header = _read_header(folder)
    replay = None
    if isinstance(state, DdpgState):
        replay = load_tree(folder / Path(header.replay or "").name, state.replay)
        state = _without_replay(state)
    stored = load_tree(folder / STATE_FILE, {"state": state, "best_policy": best_policy})
    loaded = stored["state"]
    if replay is not None:
        loaded = eqx.tree_at(lambda s: s.replay, loaded, replay, is_leaf=lambda x: x is None)
    # Own copies: what was read may share memory with the file's buffer, and is donated later.
    return jax.tree.map(jnp.copy, loaded), stored["best_policy"]


def save_pilot(
    path: Path,
    policy: AnyPolicy,
    critic: SubTaskCritic | None,
    config: TrainConfig,
    summary: dict[str, Any],
) -> None:
    """Write a pilot: its networks, how they are read again, and how it was trained."""
    described = config_to_dict(config)
    if config.init_from is not None:
        # The names alone: folders are private.
        described["init_from"] = ",".join(file.name for file in init_files(config.init_from))
    tree, networks = _described(policy, critic, config)
    header = {
        "version": __version__,
        **networks,
        "ship": config.ship,
        "encounters": dataclasses.asdict(config.encounters),
        "env": dataclasses.asdict(config.env),
        "config": described,
        "summary": summary,
    }
    save_tree(path, tree, header)


def _described(
    policy: AnyPolicy, critic: SubTaskCritic | None, config: TrainConfig
) -> tuple[Any, dict[str, Any]]:
    """The networks of a pilot as a pytree, and what the header says of them."""
    if isinstance(policy, HeldCourses) and config.algorithm == "course":
        sizes = {"kind": "course", **dataclasses.asdict(config.course_sizes)}
        return {"critic": policy.critic}, {"actor": None, "critic": sizes}
    if isinstance(policy, HeldCourses):
        sizes = {"kind": "manoeuvres", **dataclasses.asdict(config.manoeuvre_critic)}
        return {"critic": policy.critic}, {"actor": None, "critic": sizes}
    return {"actor": policy, "critic": critic}, {
        "actor": {"kind": config.actor, **dataclasses.asdict(config.actor_sizes)},
        "critic": None if critic is None else dataclasses.asdict(config.critic_sizes),
    }


def _without_replay(state: DdpgState) -> DdpgState:
    return eqx.tree_at(lambda s: s.replay, state, None)
