"""How safe are the pilots? Random encounters of the paper and the Imazu cases.

    python benchmarks/safety.py [--pilots NAME ...] [--encounters 10000] [--seed 7000000]
                                [--random-only]

Prints Markdown tables: intrusions (Eq. 13 > 0 at any step) and collisions
(centre distance below own ship's length) over 1200 s and 2400 s with 95 %
Clopper-Pearson intervals, reversals of the heading a voyage and the share of voyages with
five or more ("weaving"), by number of ships, and the Imazu cases. A pilot is
sailed on the ship that it was trained for; ``straight`` on both.
"""

import argparse
import time

import jax
import jax.numpy as jnp
import numpy as np
from rich.progress import track

from glasshelm.encounters.imazu import imazu_cases, imazu_scenario
from glasshelm.encounters.random_encounters import PAPER, random_encounter
from glasshelm.evaluation.markdown import percent
from glasshelm.evaluation.statistics import clopper_pearson
from glasshelm.pilots.batched import BatchedPilot
from glasshelm.pilots.course_pilot import CoursePilot
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.registry import pilot_named, pilot_names
from glasshelm.pilots.straight import StraightPilot
from glasshelm.ship.course_reversals import WEAVING
from glasshelm.ship.nomoto import SHIPS, ShipParams
from glasshelm.training.validation import rollout

SEED = 7_000_000  # never a training's or an evaluation set's
CHUNK = 500
SHORT, LONG = 240, 480


def rate(events: np.ndarray) -> str:
    return percent(clopper_pearson(int(events.sum()), events.size))


def sail_random(
    pilot: Pilot, ship: ShipParams, number: int, seed: int, name: str
) -> dict[str, np.ndarray]:
    """Margins and ranges [2, number] (short, long), mean rudder, returns, number of ships."""
    draw = jax.jit(jax.vmap(lambda key: random_encounter(key, ship, PAPER)))
    parts, helm = [], BatchedPilot(pilot)
    for chunk in track(range(0, number, CHUNK), description=name):
        keys = jax.vmap(lambda i: jax.random.fold_in(jax.random.key(seed), i))(
            chunk + jnp.arange(CHUNK)
        )
        found = rollout(helm, draw(keys), ship, SHORT, LONG)
        parts.append({key: np.asarray(value) for key, value in vars(found).items()})
    return {key: np.concatenate([p[key] for p in parts], axis=_axis(key)) for key in parts[0]}


def _axis(key: str) -> int:
    return 1 if key in ("margin", "range_m") else 0


def sail_imazu(pilot: Pilot, ship: ShipParams) -> dict[str, tuple[float, float]]:
    """Worst margin and nearest range [m] of every case, 3600 s at TCPA 1800 s."""
    found = {}
    for case in imazu_cases():
        one = imazu_scenario(case, ship).encounter
        batch = jax.tree.map(lambda x: jnp.asarray(x)[None], one)
        helm = BatchedPilot(pilot)
        voyage = rollout(helm, batch, ship, 480, 720)
        found[case] = (float(voyage.margin[1, 0]), float(voyage.range_m[1, 0]))
    return found


def _ships(pilot: Pilot) -> dict[str, ShipParams]:
    """The ships that a pilot is sailed on, by the name to print."""
    if isinstance(pilot, StraightPilot):
        return SHIPS
    return {"": pilot.ship if isinstance(pilot, CoursePilot) else pilot.trained.ship}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pilots", nargs="*", default=None)
    parser.add_argument("--encounters", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--random-only", action="store_true", help="leave out the Imazu cases")
    arguments = parser.parse_args()
    rows, by_ships, imazu = [], [], []
    for name in arguments.pilots or pilot_names():
        pilot = pilot_named(name)
        ships = _ships(pilot)
        digest = (getattr(pilot, "weights_sha256", None) or "")[:8]
        for ship_name, ship in ships.items():
            label = (
                f"{name} ({ship_name})" if ship_name else f"{name} `{digest}`".removesuffix(" ``")
            )
            began = time.monotonic()
            found = sail_random(pilot, ship, arguments.encounters, arguments.seed, label)
            intruded, collided = found["margin"] > 0, found["range_m"] < ship.loa_m
            returns = found["return_by_task"].sum(-1).mean()
            turns, rudder = found["reversals"], found["rudder"].mean()
            near = np.percentile(found["range_m"][1][found["ships"] > 0], 5)
            rows.append(
                f"| {label} | {rate(intruded[0])} | {rate(collided[0])} | {rate(intruded[1])} | "
                f"{rate(collided[1])} | {near:.0f} | {returns:.1f} | {rudder:.2f} | "
                f"{turns.mean():.1f} | {100 * (turns >= WEAVING).mean():.1f} % |"
            )
            cells = [rate(intruded[1][found["ships"] == n]) for n in range(1, 7)]
            by_ships.append(f"| {label} | " + " | ".join(cells) + " |")
            print(f"{label}: {time.monotonic() - began:.0f} s", flush=True)
            if arguments.random_only:
                continue
            cases = sail_imazu(pilot, ship)
            plain = [c for c in cases if not c.endswith("b")]
            bad = [f"{c} ({cases[c][0]:.2f})" for c in cases if cases[c][0] > 0]
            hit = sum(cases[c][1] < ship.loa_m for c in plain)
            into = sum(cases[c][0] > 0 for c in plain)
            imazu.append(f"| {label} | {hit} of 22 | {into} of 22 | {', '.join(bad) or '–'} |")
    print(
        "\n| pilot | intrusions 1200 s | collisions 1200 s | intrusions 2400 s | "
        "collisions 2400 s | nearest, 5th percentile [m] | return (1200 s) | mean rudder | "
        "reversals | weaving |\n|---|---|---|---|---|---|---|---|---|---|"
    )
    print("\n".join(rows))
    print("\nIntrusions over 2400 s by number of ships:\n")
    print("| pilot | 1 | 2 | 3 | 4 | 5 | 6 |\n|---|---|---|---|---|---|---|")
    print("\n".join(by_ships))
    print(
        "\nImazu at 10 kn, TCPA 1800 s, 3600 s:\n\n| pilot | collide | intrude | "
        "cases intruded (depth of Eq. 13) |\n|---|---|---|---|"
    )
    print("\n".join(imazu))


if __name__ == "__main__":
    main()
