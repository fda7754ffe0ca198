"""Random encounters (Eq. 8-9), by number of ships, and congested waters."""

import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from glasshelm.core.geometry import Vector, closest_approach, velocity
from glasshelm.encounters.random_encounters import PAPER, RandomEncounters, random_encounter
from glasshelm.encounters.types import Encounter, motion_at
from glasshelm.evaluation.types import Suite
from glasshelm.ship.domain import AHEAD_LOA
from glasshelm.ship.nomoto import ShipParams
from glasshelm.simulation.rollout import Case, plain_cases

#: Never a training's or a training's evaluation set's.
SEED = 7_000_000
CONGESTED = (8, 12, 20)
#: A voyage lasts until every planned conflict is so long past, within these limits [s].
AFTER_S = 300.0
LEAST_S, MOST_S = 2400.0, 3600.0
#: Durations are whole multiples of this: few programs are compiled.
_ROUND_S = 240.0
_STEP_S = 5.0


def random_suite(ship: ShipParams, count: int) -> Suite:
    """Random encounters of 0-6 ships, the paper's distribution with the spawn rule."""
    return drawn_suite(
        "random",
        "Random encounters of 0-6 ships (Eq. 8-9, no spawn nearer than 7 LOA or in the domain)",
        ship,
        count,
        PAPER,
    )


def congested_suites(ship: ShipParams, count: int) -> list[Suite]:
    """The same with exactly 8, 12 and 20 ships."""
    return [
        drawn_suite(
            f"congested-{ships}",
            f"Random encounters of {ships} ships (Eq. 8-9)",
            ship,
            count,
            dataclasses.replace(PAPER, targets=(ships, ships)),
        )
        for ships in CONGESTED
    ]


def drawn_suite(
    name: str, note: str, ship: ShipParams, count: int, settings: RandomEncounters
) -> Suite:
    """``count`` random encounters, the same for every pilot and every ship of that speed."""
    encounters = numbered_encounters(ship, count, settings)
    return Suite(name, note, undisturbed_cases(encounters, ship), tuple(map(str, range(count))))


def numbered_encounters(
    ship: ShipParams, count: int, settings: RandomEncounters, seed: int = SEED
) -> Encounter:
    """Encounters 0 to ``count`` - 1: the first ones are the same whatever the count."""
    return _draw(jnp.arange(count), seed, ship, settings)


@partial(jax.jit, static_argnums=(1, 3))
def _draw(numbers: Array, seed: int, ship: ShipParams, settings: RandomEncounters) -> Encounter:
    def one(number: Array) -> Encounter:
        return random_encounter(jax.random.fold_in(jax.random.key(seed), number), ship, settings)

    return jax.vmap(one)(numbers)


def undisturbed_cases(encounters: Encounter, ship: ShipParams) -> Case:
    """Cases of encounters whose ships are all as large as own ship, seen as they are."""
    duration_s = np.asarray(jax.jit(jax.vmap(lambda e: case_duration_s(e, ship)))(encounters))
    steps = np.round(duration_s / _STEP_S).astype(np.int32)
    return jax.tree.map(np.asarray, plain_cases(encounters, ship, steps))


def case_duration_s(encounter: Encounter, ship: ShipParams) -> Float[Array, ""]:
    """When every planned conflict is past [s]: the ships that would pass within 6.4 LOA.

    The CPAs are those of ships that all keep straight on; between 2400 s and an hour.
    """
    motion = motion_at(encounter.targets, jnp.zeros(()))
    own = encounter.own
    mine = velocity(own.heading_rad, own.speed_m_s)
    theirs = velocity(motion.course_rad, motion.speed_m_s)
    cpa = closest_approach(
        Vector(motion.east_m - own.east_m, motion.north_m - own.north_m),
        Vector(theirs.x - mine.x, theirs.y - mine.y),
    )
    planned = encounter.present & (cpa.dcpa_m < AHEAD_LOA * ship.loa_m)
    last_s = jnp.where(planned, cpa.tcpa_s, 0.0).max(initial=0.0) + AFTER_S
    return jnp.clip(jnp.ceil(last_s / _ROUND_S) * _ROUND_S, LEAST_S, MOST_S)
