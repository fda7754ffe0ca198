"""Does more search improve the clairvoyant planner? The same encounters, searched harder.

    python benchmarks/clairvoyant.py [--ship large_ship] [--encounters 192]

Encounters of 2400 s, those of ``benchmarks/safety.py --seed 6500000``, are sailed as they are
examined. Then 64 of them, all in which somebody intruded and the first others, are searched
again: with other draws, and with twice the samples, the iterations, the knots.
"""

import argparse
import dataclasses
import time

import jax
import numpy as np

from glasshelm.encounters.random_encounters import PAPER
from glasshelm.evaluation.suites.random_suite import numbered_encounters
from glasshelm.pilots.clairvoyant import Clairvoyant, starting_pilots
from glasshelm.planning.cross_entropy_search import KnownEncounter, SearchSettings
from glasshelm.ship.nomoto import SHIPS, ShipParams
from glasshelm.simulation.rollout import Measures, plain_cases, rollout

SEED, STEPS = 6_500_000, 480
BASE = SearchSettings()
HARDER = {
    "as examined": (BASE, 0),
    "other draws": (BASE, 1),
    "2 × iterations": (dataclasses.replace(BASE, iterations=2 * BASE.iterations), 0),
    "2 × knots": (dataclasses.replace(BASE, knots=2 * BASE.knots), 0),
    "2 × samples": (dataclasses.replace(BASE, samples=2 * BASE.samples), 0),
}
AGAIN = 64


def sailed(
    known: KnownEncounter, ship: ShipParams, settings: SearchSettings, seed: int
) -> Measures:
    """What an examination measures of a search's voyages."""
    cases = plain_cases(known.encounter, ship, known.steps)
    seer = Clairvoyant(ship, "clairvoyant", starting_pilots(ship), settings, seed)
    return jax.device_get(rollout(seer.policy_for(known), cases, STEPS))


def row(name: str, found: Measures, which: np.ndarray, ship: ShipParams, took_s: float) -> str:
    depth, nearest = found.margin[:, 1], found.range_m[:, 1]
    who = [f"{which[i]} ({depth[i]:.3f})" for i in np.flatnonzero(depth > 0)]
    cells = [
        name,
        f"{(depth > 0).sum()} of {len(which)}",
        f"{(nearest < ship.loa_m).sum()}",
        f"{found.return_by_task.sum(-1).mean():.2f}",
        ", ".join(who) or "–",
        f"{took_s:.0f}",
    ]
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ship", choices=tuple(SHIPS), default="large_ship")
    parser.add_argument("--encounters", type=int, default=192)
    given = parser.parse_args()
    ship, which = SHIPS[given.ship], np.arange(given.encounters)
    encounters = numbered_encounters(ship, given.encounters, PAPER, SEED)
    known = KnownEncounter.still(encounters, ship, STEPS)
    print("| search | intrusions | collisions | return (1200 s) | intruded (depth) | time [s] |")
    print("|---|---|---|---|---|---|")
    for name, (settings, seed) in HARDER.items():
        began = time.monotonic()
        found = sailed(known, ship, settings, seed)
        print(row(name, found, which, ship, time.monotonic() - began), flush=True)
        if name == "as examined":
            order = np.argsort(found.margin[:, 1] <= 0, kind="stable")[:AGAIN]
            known, found = jax.tree.map(lambda x, order=order: x[order], (known, found))
            which = which[order]
            print(row("the same, of those searched again", found, which, ship, 0.0), flush=True)


if __name__ == "__main__":
    main()
