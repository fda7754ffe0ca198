"""The complete state of a training on disk, so that it continues bit for bit.

``state.safetensors`` holds everything but the replay; the replay (hundreds of
megabytes) has a file of its own, written before and named in the header of the
state. The old pair is deleted last: a crash at any instant leaves one whole
pair.
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
from glasshelm.networks.actors import Actor
from glasshelm.networks.checkpoint import load_tree, read_header, save_tree
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.training.config import TrainConfig, config_from_dict, config_to_dict
from glasshelm.training.ddpg import DdpgState
from glasshelm.training.init_actor import start_files

STATE = "state.safetensors"


@dataclasses.dataclass(frozen=True)
class Place:
    """How far a training is. ``number`` counts units of the stage, ``best`` the best fault yet."""

    stage: int = 0
    number: int = 0
    best: float | None = None
    seconds: float = 0.0


class _Header(msgspec.Struct):
    version: str
    config: dict[str, Any]
    place: Place
    replay: str | None


def save_snapshot(folder: Path, state: Any, kept: Actor, place: Place, config: TrainConfig) -> None:
    """Write the pair of files. ``kept`` is the best actor so far."""
    replay_file = None
    if isinstance(state, DdpgState):
        replay_file = f"replay-{place.stage}-{place.number}.safetensors"
        save_tree(folder / replay_file, state.replay, {})
        state = _without_replay(state)
    header = _Header(__version__, config_to_dict(config), place, replay_file)
    save_tree(folder / STATE, {"state": state, "kept": kept}, msgspec.to_builtins(header))
    # And what one who was killed left half-written.
    for old in (*folder.glob("replay-*.safetensors"), *folder.glob(".*-replay-*.safetensors")):
        if old.name != replay_file:
            old.unlink(missing_ok=True)


def read_place(folder: Path) -> tuple[Place, TrainConfig]:
    """Where a snapshot stands and its configuration; InputError if there is none."""
    if not os.path.isfile(folder / STATE):
        raise InputError(f"{folder}: no {STATE} to resume; leave --resume out to begin")
    header = _state_header(folder)
    return header.place, config_from_dict(header.config)


def _state_header(folder: Path) -> _Header:
    try:
        return msgspec.convert(read_header(folder / STATE), _Header)
    except msgspec.ValidationError as error:
        raise InputError(f"{folder / STATE}: not the state of a training ({error})") from None


def load_snapshot(folder: Path, state: Any, kept: Actor) -> tuple[Any, Actor]:
    """The saved state and best actor; the arguments give their structure."""
    header = _state_header(folder)
    replay = None
    if isinstance(state, DdpgState):
        replay = load_tree(folder / Path(header.replay or "").name, state.replay)
        state = _without_replay(state)
    stored = load_tree(folder / STATE, {"state": state, "kept": kept})
    loaded = stored["state"]
    if replay is not None:
        loaded = eqx.tree_at(lambda s: s.replay, loaded, replay, is_leaf=lambda x: x is None)
    # Own copies: what was read may share memory with the file's buffer, and is donated later.
    return jax.tree.map(jnp.copy, loaded), stored["kept"]


def pilot_header(config: TrainConfig, critic: SubTaskCritic | None, summary: dict[str, Any]):
    """The header from which :func:`glasshelm.pilots.load_networks.rebuild` makes the networks."""
    described = config_to_dict(config)
    if config.start is not None:
        # Where they lay is nobody's business.
        described["start"] = ",".join(file.name for file in start_files(config.start))
    return {
        "version": __version__,
        "actor": {"kind": config.actor, **dataclasses.asdict(config.actor_sizes)},
        "critic": None if critic is None else dataclasses.asdict(config.critic_sizes),
        "ship": config.ship,
        "config": described,
        "summary": summary,
    }


def save_pilot(
    path: Path,
    actor: Actor,
    critic: SubTaskCritic | None,
    config: TrainConfig,
    summary: dict[str, Any],
) -> str:
    """Write a pilot: actor, critic if there is one, configuration, summary; returns the SHA-256."""
    return save_tree(
        path, {"actor": actor, "critic": critic}, pilot_header(config, critic, summary)
    )


def _without_replay(state: DdpgState) -> DdpgState:
    return eqx.tree_at(lambda s: s.replay, state, None)
