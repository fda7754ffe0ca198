"""The clairvoyant planner as an evaluation asks for it: encounters in, voyages out.

It is warm-started from what pilots do in each encounter and searches from there
(:mod:`glasshelm.planning.clairvoyant`): once from the best of them in every
encounter, and from each of them where somebody is still inside the domain.
"""

from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from glasshelm.encounters.types import Encounter
from glasshelm.learning.evaluate import Voyages, sail_remembering
from glasshelm.pilots.catalogue import METHODS
from glasshelm.pilots.course import CoursePilot, Method
from glasshelm.pilots.together import Together
from glasshelm.pilots.types import Pilot
from glasshelm.planning.clairvoyant import (
    Sailed,
    SearchSettings,
    as_sailed,
    best_of,
    improve_all,
)
from glasshelm.ships import ShipParams
from glasshelm.world.observe import Observation
from glasshelm.world.step import begin, step

#: The name by which an evaluation asks for it.
NAME = "clairvoyant"
#: Encounters searched at once: a fixed number, so that one program serves all.
_CHUNK = 64


class Playback(eqx.Module):
    """Steers rudders [w, t] that were found before, as fractions of the limit."""

    rudders: Float[Array, "w t"]

    def __call__(
        self, seen: Observation, memory: Int[Array, ""]
    ) -> tuple[Float[Array, " w"], Int[Array, ""]]:
        return self.rudders[:, memory], memory + 1


def _steady(
    seen: Observation, offset_rad: Float[Array, ""], ship: ShipParams, settings: float
) -> Float[Array, ""]:
    return jnp.full_like(offset_rad, settings)


def starting_pilots(ship: ShipParams) -> tuple[Pilot, ...]:
    """Whose voyages the search begins from: the planner, rules, and courses kept to either side."""
    methods = [METHODS[name] for name in ("planner", "mpc", "cpa", "waypoint")]
    methods += [Method(_steady, float(np.radians(a))) for a in (-90, -45, 45, 90)]
    return tuple(CoursePilot(ship, NAME, method) for method in methods)


@partial(jax.jit, static_argnames="steps")
def record(
    pilot: Pilot, encounters: Encounter, ship: ShipParams, steps: int
) -> Float[Array, "w t"]:
    """The rudders of a pilot in each encounter, as fractions of the limit."""
    helm, size = Together(pilot), encounters.present.shape[0]

    def go(carry, _):
        state, memory = carry
        action, memory = helm(state.observation, memory)
        out = jax.vmap(lambda e, s, a: step(e, s, a * ship.rudder_limit_rad, ship))(
            encounters, state, action
        )
        return (out.state, memory), action

    states = jax.vmap(lambda e: begin(e, ship))(encounters)
    _, actions = jax.lax.scan(go, (states, helm.start(size)), None, length=steps)
    return actions.T


def clairvoyant_rudders(
    encounters: Encounter,
    ship: ShipParams,
    steps: int = 480,
    settings: SearchSettings = SearchSettings(),
    pilots: tuple[Pilot, ...] | None = None,
    seed: int = 0,
) -> Float[np.ndarray, "w t"]:
    """The best rudders found for each encounter of a batch, as fractions of the limit.

    ``pilots`` are those that the search begins from (default:
    :func:`starting_pilots`); in no encounter is the result worse than the best of
    them. ``seed`` draws the search; the same seed finds the same rudders.
    """
    pilots = starting_pilots(ship) if pilots is None else pilots
    size = encounters.present.shape[0]
    parts = []
    for first in range(0, size, _CHUNK):
        wanted = np.arange(first, min(first + _CHUNK, size))
        chunk = _take(encounters, np.resize(wanted, _CHUNK))
        key = jax.random.fold_in(jax.random.key(seed), first)
        parts.append(_search(chunk, ship, steps, settings, pilots, key)[: len(wanted)])
    return np.concatenate(parts)


def sail_clairvoyant(
    encounters: Encounter,
    ship: ShipParams,
    short: int = 240,
    long: int = 480,
    settings: SearchSettings = SearchSettings(),
    pilots: tuple[Pilot, ...] | None = None,
    seed: int = 0,
) -> Voyages:
    """What :func:`clairvoyant_rudders` bring, sailed in the world like any pilot's."""
    rudders = clairvoyant_rudders(encounters, ship, long, settings, pilots, seed)
    helm = Playback(jnp.asarray(rudders))
    return sail_remembering(helm, jnp.zeros((), jnp.int32), encounters, ship, short, long)


def _search(
    chunk: Encounter,
    ship: ShipParams,
    steps: int,
    settings: SearchSettings,
    pilots: tuple[Pilot, ...],
    key: Array,
) -> Float[np.ndarray, "w t"]:
    """Rudders for ``_CHUNK`` encounters."""
    starts = jnp.stack([record(p, chunk, ship, steps) for p in pilots])
    bases = _sailed(chunk, ship, starts)
    found = improve_all(chunk, ship, _best(bases, ship, settings), key, settings)
    hard = np.flatnonzero(np.asarray(found.margin) > -settings.clear)
    rudders = np.array(found.rudder_rad)
    # All starts of all hard encounters, in batches of the same size as before.
    jobs = [(w, m) for w in hard for m in range(len(pilots))]
    best = {w: _take(found, w) for w in hard}
    for first in range(0, len(jobs), _CHUNK):
        batch = jobs[first : first + _CHUNK]
        w, m = np.resize(np.array(batch), (_CHUNK, 2)).T
        base = jax.tree.map(lambda x, w=w, m=m: x[m, w], bases)
        key = jax.random.fold_in(key, first + 1)
        tried = improve_all(_take(chunk, w), ship, base, key, settings)
        for i, (world, _) in enumerate(batch):
            one = _take(tried, i)
            if one.value(ship, settings) > best[world].value(ship, settings):
                best[world] = one
    for world, one in best.items():
        rudders[world] = one.rudder_rad
    return rudders / np.float32(ship.rudder_limit_rad)


@partial(jax.jit, static_argnames="ship")
def _sailed(chunk: Encounter, ship: ShipParams, starts: Float[Array, "m w t"]) -> Sailed:
    one = jax.vmap(lambda e, r: as_sailed(e, ship, r * ship.rudder_limit_rad))
    return jax.vmap(lambda r: one(chunk, r))(starts)


@partial(jax.jit, static_argnames=("ship", "settings"))
def _best(bases: Sailed, ship: ShipParams, settings: SearchSettings) -> Sailed:
    return jax.vmap(lambda b: best_of(b, ship, settings), in_axes=1)(bases)


def _take(tree, index):
    return jax.tree.map(lambda x: x[index], tree)
