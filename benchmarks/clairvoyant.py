"""Does more search improve the clairvoyant planner? The same encounters, searched harder.

    python benchmarks/clairvoyant.py [--ship large_ship] [--encounters 64] [--first 0]

Each row is one voyage of 2400 s an encounter: as it is examined, with other draws, and with
twice the samples, the iterations, the knots. Encounters are those of
``benchmarks/safety.py --seed 6500000``; ``--first`` goes on from there.
"""

import argparse
import dataclasses
import time

import jax
import jax.numpy as jnp
import numpy as np

from glasshelm.encounters.random import PAPER, random_encounter
from glasshelm.evaluation.sail import sail
from glasshelm.evaluation.suites.random import plain_cases
from glasshelm.pilots.clairvoyant import Clairvoyant, starting_pilots
from glasshelm.planning.clairvoyant import Known, SearchSettings
from glasshelm.ships import SHIPS

SEED, STEPS = 6_500_000, 480
BASE = SearchSettings()
HARDER = {
    "as examined": (BASE, 0),
    "other draws": (BASE, 1),
    "2 × samples": (dataclasses.replace(BASE, samples=2 * BASE.samples), 0),
    "2 × iterations": (dataclasses.replace(BASE, iterations=2 * BASE.iterations), 0),
    "2 × knots": (dataclasses.replace(BASE, knots=2 * BASE.knots), 0),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ship", choices=tuple(SHIPS), default="large_ship")
    parser.add_argument("--encounters", type=int, default=64)
    parser.add_argument("--first", type=int, default=0)
    given = parser.parse_args()
    ship, which = SHIPS[given.ship], given.first + jnp.arange(given.encounters)
    keys = jax.vmap(lambda i: jax.random.fold_in(jax.random.key(SEED), i))(which)
    encounters = jax.jit(jax.vmap(lambda key: random_encounter(key, ship, PAPER)))(keys)
    known = Known.still(encounters, ship, STEPS)
    cases = dataclasses.replace(plain_cases(encounters, ship), steps=known.steps)
    print(
        "| search | intrusions | collisions | return (1200 s) | who intruded (depth) | time [s] |"
    )
    print("|---|---|---|---|---|---|")
    for name, (settings, seed) in HARDER.items():
        began = time.monotonic()
        seer = Clairvoyant(ship, name, starting_pilots(ship), settings, seed)
        found = jax.device_get(sail(seer.knowing(known), cases, STEPS))
        depth, nearest = found.margin[:, 1], found.range_m[:, 1]
        returned = found.return_by_task.sum(-1)
        who = [f"{given.first + i} ({depth[i]:.3f})" for i in np.flatnonzero(depth > 0)]
        print(
            f"| {name} | {(depth > 0).sum()} | {(nearest < ship.loa_m).sum()} | "
            f"{returned.mean():.2f} | {', '.join(who) or '–'} | {time.monotonic() - began:.0f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
