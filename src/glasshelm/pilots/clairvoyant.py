"""The clairvoyant planner: told whole encounters, it says how they had best been sailed.

It is warm-started from what pilots do in each encounter and searches from there
(:mod:`glasshelm.planning.cross_entropy_search`): once from the best of them in every
encounter, and from each of them where somebody is still inside the domain.
"""

from functools import partial
from typing import Protocol, runtime_checkable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from glasshelm.env.observe import Observation
from glasshelm.env.step import EnvSettings, observe_step, reset
from glasshelm.pilots.batched import BatchedPilot
from glasshelm.pilots.course_pilot import CourseMethod, CoursePilot
from glasshelm.pilots.glassbox import best_course
from glasshelm.pilots.protocols import BatchPolicy, Pilot
from glasshelm.pilots.registry import METHODS
from glasshelm.planning.cross_entropy_search import (
    KnownEncounter,
    Rollout,
    SearchSettings,
    best_of,
    improve_all,
    rollout_rudders,
)
from glasshelm.planning.simulated_critic import SimulatedCritic
from glasshelm.ship.nomoto import SHIPS, ShipParams, advance, with_drift

#: Encounters searched at once, and steps in which a voyage is reckoned: few programs serve all.
_CHUNK, _STEPS = 64, 240
_WORLD = EnvSettings()


@runtime_checkable
class OraclePilot(Protocol):
    """What cannot steer by what it sees: it must know each encounter beforehand."""

    @property
    def name(self) -> str:
        """What people call it."""
        ...

    def policy_for(self, known: KnownEncounter) -> BatchPolicy:
        """The policy for a batch of encounters, knowing all of each."""
        ...


class Playback(eqx.Module):
    """Steers rudders [w, t] that were found before, as fractions of the limit."""

    rudders: Float[Array, "w t"]

    def start(self, size: int) -> Int[Array, ""]:
        """Nothing steered yet; all encounters are in step."""
        return jnp.zeros((), jnp.int32)

    def __call__(
        self, observation: Observation, memory: Int[Array, ""]
    ) -> tuple[Float[Array, " w"], Int[Array, ""]]:
        return self.rudders[:, memory], memory + 1


class Clairvoyant(eqx.Module):
    """No pilot but an oracle: the limit of what pilots can do.

    In no encounter is it worse than the best of ``pilots``, from whose voyages the search
    begins. They were made for ``ship``; the true one comes with each encounter.
    """

    ship: ShipParams = eqx.field(static=True)
    name: str = eqx.field(static=True)
    pilots: tuple[Pilot, ...]
    settings: SearchSettings = eqx.field(static=True, default=SearchSettings())
    seed: int = eqx.field(static=True, default=0)

    def policy_for(self, known: KnownEncounter) -> Playback:
        """Who steers a batch of encounters as well as the search could find out.

        What is there twice is searched once, and found alike whatever else is in the batch.
        """
        _, first, back = np.unique(_bytes(known), axis=0, return_index=True, return_inverse=True)
        steps = -(-int(known.steps.max()) // _STEPS) * _STEPS
        key = jax.random.key(self.seed)
        parts = []
        for begins in range(0, len(first), _CHUNK):
            chosen = first[begins : begins + _CHUNK]
            chunk = _take(known, np.resize(chosen, _CHUNK))
            parts.append(_search(chunk, steps, self.settings, self.pilots, key)[: len(chosen)])
        return Playback(jnp.asarray(np.concatenate(parts)[back.reshape(-1)]))


def starting_pilots(ship: ShipParams) -> tuple[Pilot, ...]:
    """Whose voyages the search begins from: glassbox, rules, and courses kept to either side."""
    methods = [CourseMethod(_valued_most, SimulatedCritic(), period=12)]
    methods += [METHODS[name] for name in ("mpc", "cpa", "waypoint")]
    methods += [CourseMethod(_steady, float(np.radians(a))) for a in (-90, -45, 45, 90)]
    return tuple(CoursePilot(ship, "start", method) for method in methods)


def _valued_most(
    observation: Observation,
    offset_rad: Float[Array, ""],
    ship: ShipParams,
    critic: SimulatedCritic,
) -> Float[Array, ""]:
    """The glassbox pilot's course, chosen once a minute: a start need not be better."""
    return best_course(critic, observation, ship)


def _steady(
    observation: Observation, offset_rad: Float[Array, ""], ship: ShipParams, settings: float
) -> Float[Array, ""]:
    return jnp.full_like(offset_rad, settings)


#: By name: ``paper-clairvoyant``, …
ORACLE_PILOTS = {
    name: Clairvoyant(SHIPS[ship], name, starting_pilots(SHIPS[ship]))
    for ship, name in ((ship, f"{ship.replace('_', '-')}-clairvoyant") for ship in SHIPS)
}


@partial(jax.jit, static_argnames="steps")
def record(pilot: Pilot, known: KnownEncounter, steps: int) -> Float[Array, "w t"]:
    """The rudders of a pilot in each encounter, as fractions of the limit."""
    policy, size = BatchedPilot(pilot), known.steps.shape[0]

    def proceed(known: KnownEncounter, state, action: Float[Array, ""]):
        rudder = action * known.ship.rudder_limit_rad
        own = advance(state.own, rudder, known.ship, _WORLD.step_s)
        own = with_drift(own, known.current_m_s, _WORLD.step_s)
        return observe_step(known.encounter, state, own, known.ship).state

    def go(carry, _):
        state, memory = carry
        action, memory = policy(state.observation, memory)
        return (jax.vmap(proceed)(known, state, action), memory), action

    states = jax.vmap(lambda k: reset(k.encounter, k.ship))(known)
    _, actions = jax.lax.scan(go, (states, policy.start(size)), None, length=steps)
    return actions.T


def _search(
    chunk: KnownEncounter,
    steps: int,
    settings: SearchSettings,
    pilots: tuple[Pilot, ...],
    key: Array,
) -> Float[np.ndarray, "w t"]:
    """Rudders for ``_CHUNK`` encounters."""
    starts = jnp.stack([record(p, chunk, steps) for p in pilots])
    bases = _rolled_out(chunk, starts)
    found = improve_all(chunk, _best(chunk, bases, settings), key, settings)
    hard = np.flatnonzero(np.asarray(found.margin) > -settings.clear)
    rudders = np.array(found.rudder_rad)
    # All starts of all hard encounters, in batches of the same size as before.
    jobs = [(w, m) for w in hard for m in range(len(pilots))]
    best = {w: (_value(chunk, found, settings)[w], found.rudder_rad[w]) for w in hard}
    for first in range(0, len(jobs), _CHUNK):
        batch = jobs[first : first + _CHUNK]
        w, m = np.resize(np.array(batch), (_CHUNK, 2)).T
        base = jax.tree.map(lambda x, w=w, m=m: x[m, w], bases)
        tried = improve_all(_take(chunk, w), base, jax.random.fold_in(key, 1), settings)
        values = _value(_take(chunk, w), tried, settings)
        for i, (which, _) in enumerate(batch):
            if values[i] > best[which][0]:
                best[which] = (values[i], tried.rudder_rad[i])
    for which, (_, rudder) in best.items():
        rudders[which] = rudder
    return rudders / np.asarray(chunk.ship.rudder_limit_rad)[:, None]


@jax.jit
def _rolled_out(chunk: KnownEncounter, starts: Float[Array, "m w t"]) -> Rollout:
    one = jax.vmap(lambda k, r: rollout_rudders(k, r * k.ship.rudder_limit_rad))
    return jax.vmap(lambda r: one(chunk, r))(starts)


@partial(jax.jit, static_argnames="settings")
def _best(chunk: KnownEncounter, bases: Rollout, settings: SearchSettings) -> Rollout:
    return jax.vmap(lambda k, b: best_of(b, k.ship, settings), in_axes=(0, 1))(chunk, bases)


@partial(jax.jit, static_argnames="settings")
def _value(chunk: KnownEncounter, sailed: Rollout, settings: SearchSettings) -> Float[Array, " w"]:
    return jax.vmap(lambda k, s: s.value(k.ship, settings))(chunk, sailed)


def _bytes(known: KnownEncounter) -> np.ndarray:
    """Every encounter as a row of bytes."""
    rows = [np.ascontiguousarray(np.asarray(leaf)) for leaf in jax.tree.leaves(known)]
    return np.concatenate([row.reshape(len(row), -1).view(np.uint8) for row in rows], axis=1)


def _take(tree, index):
    return jax.tree.map(lambda x: x[index], tree)
