"""What happened in each failure of a pilot, in the random suite of the examination.

    python benchmarks/failures.py PILOT [--event collision] [--encounters 10000]
                                  [--searches 64] [--out failures.csv]

Sails the suite, then every failed voyage again with one thing changed
(glasshelm/evaluation/failures.py): only the ship that was met, one of the others away, the
ship's planner taking over, the clairvoyant search. Prints a Markdown table; ``--out`` writes a
row for each failure, with the number of its encounter.
"""

import argparse
import csv
import dataclasses
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from glasshelm.evaluation.failure_analysis import Event, counted, explain_failures
from glasshelm.evaluation.suites.random_suite import random_suite
from glasshelm.pilots.clairvoyant import ORACLE_PILOTS
from glasshelm.pilots.pilot_resolution import ship_of
from glasshelm.pilots.registry import pilot_named
from glasshelm.ship.nomoto import SHIPS


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pilot")
    parser.add_argument("--event", choices=[e.value for e in Event], default="collision")
    parser.add_argument("--encounters", type=int, default=10_000)
    parser.add_argument("--searches", type=int, default=64)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    pilot = pilot_named(given.pilot)
    name = ship_of(pilot)
    if name is None:
        parser.error(f"{given.pilot} has no ship of its own")
    ship = SHIPS[name]
    prefix = name.replace("_", "-")
    with Progress(console=Console(stderr=True)) as bar:
        tasks: dict[str, int] = {}

        def progress(what: str, done: int, of: int) -> None:
            if what not in tasks:
                tasks[what] = bar.add_task(what, total=of)
            bar.update(tasks[what], completed=done)  # pyright: ignore[reportArgumentType]

        failures = explain_failures(
            pilot,
            pilot_named(f"{prefix}-planner"),
            ORACLE_PILOTS[f"{prefix}-clairvoyant"],
            random_suite(ship, given.encounters).cases,
            Event(given.event),
            given.searches,
            progress,
        )
    print(f"{given.pilot}: {len(failures)} voyages with a {given.event}")
    print(counted(failures))
    hopeless = [f for f in failures if f.searched]
    print(f"searched: {len(hopeless)}, a way found in {sum(f.seer_clear for f in hopeless)}")
    if given.out:
        with open(given.out, "w", newline="") as file:
            names = [field.name for field in dataclasses.fields(failures[0])] if failures else []
            writer = csv.writer(file)
            writer.writerow([*names, "verdict"])
            writer.writerows([*dataclasses.astuple(f), f.verdict.value] for f in failures)


if __name__ == "__main__":
    main()
