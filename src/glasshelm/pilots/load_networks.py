"""From a weights file to its networks: the header alone says how they are built."""

import dataclasses
from pathlib import Path
from typing import Any, TypeVar

import equinox as eqx
import jax
import msgspec

from glasshelm.core.errors import InputError
from glasshelm.encounters.random_encounters import RandomEncounters
from glasshelm.env.step import EnvSettings
from glasshelm.env.training_envelope import TrainingEnvelope
from glasshelm.networks.actors import Actor, ActorSizes, make_actor
from glasshelm.networks.checkpoint import CheckpointError, load_tree, read_header
from glasshelm.networks.critics import CriticSizes, SubTaskCritic
from glasshelm.planning.course_critic import CourseCritic, CourseCriticSizes
from glasshelm.planning.learned_critic import LearnedCritic, ManoeuvreCriticSizes
from glasshelm.ship.nomoto import ShipParams, check_ship, ship_named

#: No network of ours has more layers, or wider ones.
MOST_LAYERS, WIDEST = 64, 65_536

#: No critic simulates its own ship's way in more steps.
MOST_STEPS = 10_000

Sizes = TypeVar("Sizes", ActorSizes, CriticSizes, ManoeuvreCriticSizes, CourseCriticSizes)
Fields = TypeVar(
    "Fields",
    ActorSizes,
    CriticSizes,
    ManoeuvreCriticSizes,
    CourseCriticSizes,
    RandomEncounters,
    EnvSettings,
)


class Networks(eqx.Module):
    """What a weights file holds: an actor with or without a critic, or a critic that steers."""

    actor: Actor | None
    critic: SubTaskCritic | LearnedCritic | CourseCritic | None


def rebuild(header: dict[str, Any]) -> tuple[Networks, TrainingEnvelope]:
    """The shapes of the networks of a header, and what they were trained on.

    In place of arrays the networks have :class:`jax.ShapeDtypeStruct`: nothing is allocated.

    ``header["actor"]`` has ``kind`` and the fields of :class:`ActorSizes`,
    ``header["critic"]`` those of :class:`CriticSizes` or is ``null``. Where ``actor`` is ``null``
    the critic steers: its ``kind`` is ``manoeuvres``, with the fields of
    :class:`ManoeuvreCriticSizes`, or ``course``, with those of :class:`CourseCriticSizes`.
    ``header["ship"]`` is a preset's name or the fields of :class:`ShipParams`.
    ``header["encounters"]`` has the fields of :class:`RandomEncounters` and ``header["env"]``
    those of :class:`EnvSettings`; without them, the envelope's defaults hold.
    InputError names the first thing that is missing or unknown.
    """
    if header.get("actor", "") is None:
        return _rebuild_steering(header)
    kind, actor = _kind_and_sizes(header, "actor")
    actor_sizes = _sizes(ActorSizes, "actor", actor)
    critic_sizes = None
    if header.get("critic") is not None:
        critic_sizes = _sizes(CriticSizes, "critic", _part(header, "critic"))

    def build() -> Networks:
        key = jax.random.key(0)
        critic = None if critic_sizes is None else SubTaskCritic(critic_sizes, key)
        return Networks(make_actor(kind, actor_sizes, key), critic)

    # Only the shapes are needed: nothing is drawn, nothing compiled.
    return eqx.filter_eval_shape(build), _trained(header)


def _rebuild_steering(header: dict[str, Any]) -> tuple[Networks, TrainingEnvelope]:
    """The same of a critic that steers."""
    kind, critic = _kind_and_sizes(header, "critic")
    if kind == "course":
        courses = _sizes(CourseCriticSizes, "critic", critic)
        like = eqx.filter_eval_shape(
            lambda: Networks(None, CourseCritic(courses, jax.random.key(0)))
        )
        return like, _trained(header)
    if kind != "manoeuvres":
        raise _unfit("critic", f"kind {kind[:100]!r}")
    sizes = _sizes(ManoeuvreCriticSizes, "critic", critic)
    if not 1 <= sizes.table.size <= WIDEST:
        raise _unfit("critic", f"{sizes.table.size} manoeuvres")
    horizon_s, step_s = sizes.costs.horizon_s, sizes.costs.step_s
    if not 0 < step_s <= horizon_s <= MOST_STEPS * step_s:
        raise _unfit("critic", f"a horizon of {horizon_s:g} s in steps of {step_s:g} s")
    networks = eqx.filter_eval_shape(
        lambda: Networks(None, LearnedCritic(sizes, jax.random.key(0)))
    )
    return networks, _trained(header)


def read_networks(path: Path) -> tuple[Networks, TrainingEnvelope]:
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


def _trained(header: dict[str, Any]) -> TrainingEnvelope:
    name = header.get("ship")
    ship = ship_named(name) if isinstance(name, str) else _ship(_part(header, "ship"))
    trained = TrainingEnvelope(ship)
    if header.get("encounters") is not None:
        encounters = _convert(RandomEncounters, "encounters", _part(header, "encounters"))
        trained = dataclasses.replace(trained, encounters=encounters)
    if header.get("env") is not None:
        trained = dataclasses.replace(
            trained, env=_convert(EnvSettings, "env", _part(header, "env"))
        )
    return trained


def _part(header: dict[str, Any], name: str) -> dict[str, Any]:
    part = header.get(name)
    if not isinstance(part, dict):
        raise InputError(f"the header has no {name!r}: save the weights with their configuration")
    return part


def _kind_and_sizes(header: dict[str, Any], name: str) -> tuple[str, dict[str, Any]]:
    """The kind of a network, and the fields of its sizes."""
    part = dict(_part(header, name))
    kind = part.pop("kind", None)
    if not isinstance(kind, str):
        raise _unfit(name, f"kind {str(kind)[:100]!r}")
    return kind, part


def _sizes(kind: type[Sizes], name: str, part: dict[str, Any]) -> Sizes:
    """Layer widths from their fields in a header; InputError if they are not its fields."""
    sizes = _convert(kind, name, part)
    for field in dataclasses.fields(kind):
        widths = getattr(sizes, field.name)
        if not isinstance(widths, tuple):
            continue
        if not 1 <= len(widths) <= MOST_LAYERS:
            raise _unfit(name, f"{field.name} of {len(widths)} layers")
        if not all(1 <= width <= WIDEST for width in widths):
            raise _unfit(name, f"a layer of width {min(widths)} to {max(widths)}")
    return sizes


def _convert(kind: type[Fields], name: str, part: dict[str, Any]) -> Fields:
    """A dataclass from its fields in a header; InputError names one that is unknown or bad."""
    unknown = sorted(set(part) - {field.name for field in dataclasses.fields(kind)})
    if unknown:
        raise _unfit(name, f"unknown field {unknown[0]!r}")
    try:
        return msgspec.convert(part, kind)
    except msgspec.ValidationError as error:
        raise _unfit(name, str(error)) from None


def _ship(part: dict[str, Any]) -> ShipParams:
    try:
        return check_ship(ShipParams(**msgspec.convert(part, dict[str, float])))
    except (msgspec.ValidationError, TypeError) as error:
        raise _unfit("ship", str(error)) from None


def _unfit(name: str, why: str) -> InputError:
    return InputError(f"the header's {name!r} does not fit this version ({why})")
