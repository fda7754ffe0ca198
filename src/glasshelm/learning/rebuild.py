"""From a weights file to its networks: the header alone says how they are built."""

from pathlib import Path
from typing import Any

import equinox as eqx
import jax

from glasshelm.errors import InputError
from glasshelm.learning.checkpoint import CheckpointError, load_tree, read_header
from glasshelm.learning.presets import config_from_dict
from glasshelm.networks.actors import Actor, ActorSizes, make_actor
from glasshelm.networks.critics import CriticSizes, SubTaskCritic
from glasshelm.ships import ShipParams, check_ship, ship_named
from glasshelm.world.outside import Trained


class Networks(eqx.Module):
    """What a weights file holds; the critic may be absent."""

    actor: Actor
    critic: SubTaskCritic | None


def rebuild(header: dict[str, Any]) -> tuple[Networks, Trained]:
    """Untrained networks of the sizes in a header, and what they were trained on.

    ``header["actor"]`` has ``kind`` and the fields of :class:`ActorSizes`,
    ``header["critic"]`` those of :class:`CriticSizes` or is ``null``,
    ``header["ship"]`` is a preset's name or the fields of :class:`ShipParams`;
    ``header["config"]`` is the training's configuration, if there was one.
    InputError names the first thing that is missing or unknown.
    """
    actor = dict(_part(header, "actor"))
    kind = actor.pop("kind", None)
    actor_key, critic_key = jax.random.split(jax.random.key(0))
    critic = None
    if header.get("critic") is not None:
        critic = SubTaskCritic(_sizes(CriticSizes, "critic", _part(header, "critic")), critic_key)
    networks = Networks(make_actor(kind, _sizes(ActorSizes, "actor", actor), actor_key), critic)
    return networks, _trained(header)


def read_networks(path: Path) -> tuple[Networks, Trained]:
    """The networks of a weights file, and what they were trained on.

    CheckpointError, in one line, if the file is missing, damaged, truncated,
    not ours, or holds the weights of another architecture.
    """
    try:
        like, trained = rebuild(read_header(path))
    except CheckpointError:
        raise
    except InputError as error:
        raise CheckpointError(f"{path}: weights of another architecture: {error}") from None
    return load_tree(path, like), trained


def _trained(header: dict[str, Any]) -> Trained:
    name = header.get("ship")
    if isinstance(name, str):
        ship = ship_named(name)
    else:
        ship = check_ship(_sizes(ShipParams, "ship", _part(header, "ship")))
    if header.get("config") is None:
        return Trained(ship)
    config = config_from_dict(_part(header, "config"))
    way = config.ddpg if config.way == "ddpg" else config.analytic
    return Trained(ship, way.encounters, config.ddpg.world)


def _part(header: dict[str, Any], name: str) -> dict[str, Any]:
    part = header.get(name)
    if not isinstance(part, dict):
        raise InputError(f"the header has no {name!r}: save the weights with their configuration")
    return part


def _sizes(kind: Any, name: str, part: dict[str, Any]) -> Any:
    try:
        return kind(**{k: tuple(v) if isinstance(v, list) else v for k, v in part.items()})
    except TypeError as error:
        raise InputError(f"the header's {name!r} does not fit this version ({error})") from None
