"""Random encounters in which something is not as the pilot was trained to expect.

Every part of the suite takes the encounters of the suite ``random`` and
disturbs one thing, ``all`` everything at once; so each is compared with the
undisturbed rates of the same encounters.
"""

import jax
import jax.numpy as jnp
import numpy as np

from glasshelm.encounters.random_encounters import PAPER
from glasshelm.evaluation.suites.random_suite import numbered_encounters, undisturbed_cases
from glasshelm.evaluation.types import Suite
from glasshelm.ship.nomoto import ShipParams
from glasshelm.simulation.disturbances import DISTURBANCES, with_instruments

SEED = 7_100_000


def disturbed_suites(ship: ShipParams, count: int) -> list[Suite]:
    """One suite a disturbance, and one with all of them."""
    cases = undisturbed_cases(numbered_encounters(ship, count, PAPER), ship)
    seeds = np.arange(count, dtype=np.int32) + SEED
    plain = jax.tree.map(jnp.asarray, with_instruments(cases, seeds))
    suites = []
    for number, (name, (note, change)) in enumerate(DISTURBANCES.items()):
        rng = np.random.default_rng((SEED, number))
        cases = jax.tree.map(np.asarray, change(plain, rng))
        labels = tuple(map(str, range(count)))
        suites.append(Suite(f"disturbed-{name}", f"As random, but {note}", cases, labels))
    return suites
