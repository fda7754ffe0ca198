"""How safe are the pilots? Random encounters of the paper and the Imazu cases.

    python benchmarks/safety.py [--pilots NAME ...] [--encounters 10000] [--seed 7000000]
                                [--random-only]

Prints Markdown tables of the measures of ``glasshelm evaluate``: intrusions (Eq. 13 > 0 at any
step) and collisions (centre distance below own ship's length) over 1200 s and 2400 s with 95 %
Clopper-Pearson intervals, reversals of the heading a voyage and the share of voyages with five
or more ("weaving"), by number of ships, and the Imazu cases. A pilot is evaluated on the ship
that it was made for; ``straight`` on both.
"""

import argparse
import time

import numpy as np
from rich.progress import track

from glasshelm.encounters.random_encounters import PAPER
from glasshelm.evaluation.contenders import Contender, parse_contenders
from glasshelm.evaluation.measure_columns import SuiteResult, assemble
from glasshelm.evaluation.result_cache import run_job, split_into_jobs
from glasshelm.evaluation.statistics import rate_interval
from glasshelm.evaluation.suites.imazu_suite import imazu_suites
from glasshelm.evaluation.suites.random_suite import SEED, numbered_encounters
from glasshelm.evaluation.tables import percent
from glasshelm.evaluation.types import Suite
from glasshelm.pilots.registry import pilot_names
from glasshelm.simulation.rollout import plain_cases

STEPS = 480  # 2400 s, whatever the conflicts


def evaluated(contender: Contender, suite: Suite) -> SuiteResult:
    """All measures of a contender in a suite."""
    jobs = list(split_into_jobs(suite, 0, contender))
    parts = [(job, run_job(job)) for job in track(jobs, description=contender.name)]
    return assemble(suite, contender, 0, parts)


def rate(events: np.ndarray) -> str:
    return percent(rate_interval(events[None]))


def random_row(label: str, result: SuiteResult) -> tuple[str, str]:
    """The rows of the two tables of random encounters."""
    c = result.columns
    near = np.percentile(c["nearest_m"][c["ships"] > 0], 5)
    cells = [
        label,
        *(rate(c[name]) for name in ("intruded_1200s", "collided_1200s", "intruded", "collided")),
        f"{near:.0f}",
        f"{c['return_total'].mean():.1f}",
        f"{c['rudder'].mean():.2f}",
        f"{c['reversals'].mean():.1f}",
        f"{100 * c['weaving'].mean():.1f} %",
    ]
    by_ships = [rate(c["intruded"][c["ships"] == n]) for n in range(1, 7)]
    return f"| {' | '.join(cells)} |", f"| {' | '.join([label, *by_ships])} |"


def imazu_row(label: str, result: SuiteResult) -> str:
    c, cases = result.columns, [name.split(":")[-1] for name in result.suite.labels]
    plain = np.array([not case.endswith("b") for case in cases])
    depths = zip(cases, c["margin"], strict=True)
    bad = ", ".join(f"{case} ({depth:.2f})" for case, depth in depths if depth > 0)
    hit, into = (int(c[name][plain].sum()) for name in ("collided", "intruded"))
    return f"| {label} | {hit} of 22 | {into} of 22 | {bad or '–'} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pilots", nargs="*", default=None)
    parser.add_argument("--encounters", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--random-only", action="store_true", help="leave out the Imazu cases")
    given = parser.parse_args()
    rows, by_ships, imazu = [], [], []
    for contender in parse_contenders(given.pilots or pilot_names()):
        name, ship = contender.name, contender.ship
        label = f"{name} ({contender.ship_name})" if name == "straight" else name
        if contender.weights[0]:
            label += f" `{contender.weights[0]}`"
        began = time.monotonic()
        encounters = numbered_encounters(ship, given.encounters, PAPER, given.seed)
        numbers = tuple(map(str, range(given.encounters)))
        suite = Suite("random", "", plain_cases(encounters, ship, STEPS), numbers)
        row, split = random_row(label, evaluated(contender, suite))
        rows.append(row)
        by_ships.append(split)
        if not given.random_only:
            imazu.append(imazu_row(label, evaluated(contender, imazu_suites(ship)[0])))
        print(f"{label}: {time.monotonic() - began:.0f} s", flush=True)
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
