"""Pilots with random weights, for tests of what must hold whatever the weights are."""

import dataclasses
import functools
from pathlib import Path

import jax

from glasshelm.encounters.random_encounters import RandomEncounters, random_encounter
from glasshelm.env.observe import Observation
from glasshelm.env.step import reset, step
from glasshelm.env.training_envelope import TrainingEnvelope
from glasshelm.networks.actors import ActorSizes, make_actor
from glasshelm.networks.checkpoint import save_tree
from glasshelm.networks.critics import CriticSizes, SubTaskCritic
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.ship.nomoto import SHIPS

ACTOR = ActorSizes(encoder=(16, 16), head=(16,), attention=(8,))
CRITIC = CriticSizes(hidden=(16, 16))
SHIP = SHIPS["paper"]


@functools.cache
def untrained(kind: str = "attention", critic: bool = True, seed: int = 0) -> LearnedPilot:
    actor_key, critic_key = jax.random.split(jax.random.key(seed))
    return LearnedPilot(
        make_actor(kind, ACTOR, actor_key),
        SubTaskCritic(CRITIC, critic_key) if critic else None,
        TrainingEnvelope(SHIP),
        f"untrained-{kind}",
    )


@jax.jit
def _after_three_steps(key: jax.Array) -> Observation:
    settings = RandomEncounters(targets=(40, 40))
    encounter = random_encounter(key, SHIP, settings)
    state = reset(encounter, SHIP)
    for rudder in (0.05, 0.02, -0.04):
        state = step(encounter, state, jax.numpy.asarray(rudder), SHIP).state
    return state.observation


@functools.cache
def observation(ships: int, seed: int = 0) -> Observation:
    """What own ship sees of so many ships (at most 40) three steps into a random encounter."""
    seen = _after_three_steps(jax.random.key(seed))
    return Observation(seen.waypoint, seen.targets[:ships], seen.present[:ships])


def write_weights(path: Path, kind: str = "attention", critic: bool = True, **other) -> str:
    """Write an untrained pilot as training does; ``other_x`` is put for x in the header."""
    pilot = untrained(kind, critic)
    described = {
        "actor": {"kind": kind, **dataclasses.asdict(ACTOR)},
        "critic": dataclasses.asdict(CRITIC) if critic else None,
        "ship": "paper",
    }
    tree = {"actor": pilot.actor, "critic": pilot.critic}
    replaced = {name.removeprefix("other_"): part for name, part in other.items()}
    return save_tree(path, tree, described | replaced)
