"""Scenes: what a pilot observes on its own voyages where ships matter to it."""

import dataclasses
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from glasshelm.encounters.random_encounters import validation_encounters
from glasshelm.encounters.types import Encounter
from glasshelm.env.observe import Observation
from glasshelm.env.step import EnvState, reset, step
from glasshelm.explanation.shapley import exact_shapley
from glasshelm.faithfulness.subjects import Subject

#: Voyages of 2400 s, looked at every 100 s from 100 s on.
STEPS, SAMPLE_EVERY = 480, 20
#: Numbers of ships: with one there is nothing to compare.
SHIP_COUNTS = (2, 3, 4, 5, 6)


#: Scenes that a compiled program takes at once.
CHUNK = 64

Result = TypeVar("Result")


@dataclasses.dataclass(frozen=True)
class Scenes:
    """Scenes with the same number of ships, all of them in the first slots.

    ``state`` and ``encounter`` [scene, ...] let the world go on from each;
    ``voyage`` tells which encounter of the set it is of: scenes of one voyage
    are not independent.
    """

    ships: int
    encounter: Encounter
    state: EnvState
    voyage: Int[np.ndarray, " s"]

    @property
    def observation(self) -> Observation:
        return self.state.observation

    @property
    def size(self) -> int:
        return len(self.voyage)


def collect_scenes(
    subject: Subject, encounters: int, max_scenes: int, counts: Sequence[int] = SHIP_COUNTS
) -> list[Scenes]:
    """Scenes of a pilot's voyages through the fixed random encounters, by number of ships.

    At most ``max_scenes`` of each number, evenly over the voyages. Scenes in which no
    ship moves what is decided by ``subject.least`` (its Shapley value) are left out.
    """
    drawn = validation_encounters(subject.ship, encounters)
    states = voyages(subject, drawn, SAMPLE_EVERY)
    instants = states.step.shape[0]
    count = np.asarray(drawn.present.sum(-1))
    groups = []
    for ships in counts:
        voyage = np.flatnonzero(count == ships)
        if len(voyage) == 0:
            continue
        place = np.argsort(~np.asarray(drawn.present)[voyage], axis=1, kind="stable")[:, :ships]
        encounter = _only(jax.tree.map(lambda x, v=voyage: x[v], drawn), place)
        state = jax.tree.map(lambda x, v=voyage: x[:, v], states)
        state = jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), _only_seen(state, place))
        voyage_of = np.tile(np.arange(len(voyage)), instants)
        telling = np.flatnonzero(map_in_chunks(partial(_matters, subject), state.observation))
        chosen = telling[
            np.linspace(0, len(telling) - 1, min(max_scenes, len(telling))).astype(int)
        ]
        if len(chosen) == 0:
            continue
        groups.append(
            Scenes(
                ships,
                jax.tree.map(lambda x, w=voyage_of[chosen]: x[w], encounter),
                jax.tree.map(lambda x, c=chosen: x[c], state),
                voyage[voyage_of[chosen]],
            )
        )
    return groups


def map_in_chunks(work: Callable[[Any], Result], scenes: Any) -> Result:
    """Apply ``work`` to every scene [s, ...] of a pytree, :data:`CHUNK` at a time.

    The last chunk is padded with its first scene, so that ``work`` is compiled for one shape.
    """
    count = jax.tree.leaves(scenes)[0].shape[0]
    parts = []
    for first in range(0, count, CHUNK):
        wanted = np.arange(first, min(first + CHUNK, count))
        place = np.concatenate([wanted, np.full(CHUNK - len(wanted), first)])
        done = jax.device_get(work(jax.tree.map(lambda x, p=place: x[p], scenes)))
        parts.append(jax.tree.map(lambda x, n=len(wanted): x[:n], done))
    return jax.tree.map(lambda *x: np.concatenate(x), *parts)


@eqx.filter_jit
def voyages(subject: Subject, encounters: Encounter, every: int) -> EnvState:
    """States [instant, voyage] of voyages of 2400 s, one every so many steps."""
    ship = subject.ship

    def one(encounter: Encounter) -> EnvState:
        def tick(state: EnvState, _: None) -> tuple[EnvState, None]:
            rudder = subject.rudder(state.observation) * ship.rudder_limit_rad
            return step(encounter, state, rudder, ship).state, None

        def leap(state: EnvState, _: None) -> tuple[EnvState, EnvState]:
            state, _ = jax.lax.scan(tick, state, None, length=every)
            return state, state

        return jax.lax.scan(leap, reset(encounter, ship), None, length=STEPS // every)[1]

    states = jax.lax.map(one, encounters, batch_size=subject.scenes_at_once)
    return jax.tree.map(lambda x: jnp.swapaxes(x, 0, 1), states)


def _only(encounter: Encounter, place: Int[np.ndarray, "v n"]) -> Encounter:
    """The encounters with the slots of ``place`` alone."""

    def pick(x: Array) -> Array:
        return jnp.take_along_axis(x, place.reshape(*place.shape, *[1] * (x.ndim - 2)), axis=1)

    return eqx.tree_at(
        lambda e: (e.targets, e.present),
        encounter,
        (jax.tree.map(pick, encounter.targets), pick(encounter.present)),
    )


def _only_seen(state: EnvState, place: Int[np.ndarray, "v n"]) -> EnvState:
    """The same for what was seen [instant, voyage, ...]."""

    def pick(x: Array) -> Array:
        at = place.reshape(1, *place.shape, *[1] * (x.ndim - 3))
        return jnp.take_along_axis(x, jnp.broadcast_to(at, (x.shape[0], *at.shape[1:])), axis=2)

    observation = state.observation
    return eqx.tree_at(
        lambda s: (s.observation.targets, s.observation.present, s.danger),
        state,
        (pick(observation.targets), pick(observation.present), pick(state.danger)),
    )


@eqx.filter_jit
def _matters(subject: Subject, observation: Observation) -> Array:
    def largest(observation: Observation) -> Array:
        def worth(members: Bool[Array, " n"]) -> Float[Array, ""]:
            return subject.decided(observation, members)

        return jnp.abs(exact_shapley(worth, observation.present.shape[-1]).by_ship).max()

    found = jax.lax.map(largest, observation, batch_size=subject.scenes_at_once)
    return found >= subject.least
