"""Scenes to ask explanations about: what a pilot sees on her own voyages, where ships matter."""

import dataclasses
from collections.abc import Sequence
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Int

from glasshelm.encounters.random_encounters import validation_encounters
from glasshelm.encounters.types import Encounter
from glasshelm.env.observe import Observation
from glasshelm.env.step import EnvState, reset, step
from glasshelm.explanation.shapley import exact_shapley, value_function
from glasshelm.faithfulness.chunking import in_chunks
from glasshelm.networks.actors import Actor
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.ship.nomoto import ShipParams

#: A scene counts if some ship moves the rudder by so much (Shapley value of the rudder) [rad].
MATTERS_RAD = float(np.radians(0.25))
#: Voyages of 2400 s, looked at every 100 s from 100 s on.
STEPS, EVERY = 480, 20
#: Numbers of ships asked about: with one there is nothing to tell apart.
COUNTS = (2, 3, 4, 5, 6)


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


def scenes_of(
    pilot: LearnedPilot, encounters: int, most: int, counts: Sequence[int] = COUNTS
) -> list[Scenes]:
    """Scenes of a pilot's voyages through the fixed random encounters, by number of ships.

    At most ``most`` of each number, evenly over the voyages. Scenes in which no
    ship moves her rudder by :data:`MATTERS_RAD` are left out.
    """
    ship = pilot.trained.ship
    drawn = validation_encounters(ship, encounters)
    states = _voyages(pilot.actor, drawn, ship)
    instants = states.step.shape[0]
    count = np.asarray(drawn.present.sum(-1))
    found = []
    for ships in counts:
        voyage = np.flatnonzero(count == ships)
        if len(voyage) == 0:
            continue
        place = np.argsort(~np.asarray(drawn.present)[voyage], axis=1, kind="stable")[:, :ships]
        encounter = _only(jax.tree.map(lambda x, v=voyage: x[v], drawn), place)
        state = jax.tree.map(lambda x, v=voyage: x[:, v], states)
        state = jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), _only_seen(state, place))
        whose = np.tile(np.arange(len(voyage)), instants)
        telling = np.flatnonzero(in_chunks(partial(_matters, pilot), state.observation))
        chosen = telling[np.linspace(0, len(telling) - 1, min(most, len(telling))).astype(int)]
        if len(chosen) == 0:
            continue
        found.append(
            Scenes(
                ships,
                jax.tree.map(lambda x, w=whose[chosen]: x[w], encounter),
                jax.tree.map(lambda x, c=chosen: x[c], state),
                voyage[whose[chosen]],
            )
        )
    return found


@jax.jit
def _voyages(actor: Actor, encounters: Encounter, ship: ShipParams) -> EnvState:
    """States [instant, voyage] of all voyages."""

    def tick(state: EnvState, _: None):
        action = actor(state.observation)
        moved = jax.vmap(lambda e, s, a: step(e, s, a * ship.rudder_limit_rad, ship).state)
        return moved(encounters, state, action), None

    def leap(state: EnvState, _: None):
        state, _ = jax.lax.scan(tick, state, None, length=EVERY)
        return state, state

    start = jax.vmap(lambda e: reset(e, ship))(encounters)
    return jax.lax.scan(leap, start, None, length=STEPS // EVERY)[1]


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
def _matters(pilot: LearnedPilot, observation: Observation) -> Array:
    limit = pilot.trained.ship.rudder_limit_rad

    def largest(observation: Observation) -> Array:
        worth = value_function("rudder", pilot.actor, None, observation, limit)
        return jnp.abs(exact_shapley(worth, observation.present.shape[-1]).by_ship).max()

    return jax.vmap(largest)(observation) >= MATTERS_RAD
