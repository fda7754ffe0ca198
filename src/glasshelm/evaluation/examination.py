"""An examination from beginning to end: every entrant through every suite."""

import dataclasses
import os
import platform
from collections.abc import Callable, Sequence
from pathlib import Path

import jax
import numpy as np

from glasshelm import __version__
from glasshelm.evaluation.contenders import Contender
from glasshelm.evaluation.measure_columns import Sailed, gather
from glasshelm.evaluation.result_cache import (
    Found,
    Job,
    ResultCache,
    Workers,
    all_done,
    here,
    jobs_of,
)
from glasshelm.evaluation.suites.suite_registry import suites_named
from glasshelm.evaluation.timing import Timing, decision_time
from glasshelm.evaluation.types import Suite
from glasshelm.pilots.clairvoyant import OraclePilot

#: Told of progress: what is being sailed, voyages done, voyages of all.
Progress = Callable[[str, int, int], None]


@dataclasses.dataclass(frozen=True)
class Provenance:
    """What every table says of where its numbers come from."""

    command: str
    machine: str
    version: str = __version__


@dataclasses.dataclass(frozen=True)
class Examined:
    """All results, in the order of suites, entrants, seeds; and the time of a decision."""

    sailed: tuple[Sailed, ...]
    timings: tuple[Timing, ...]
    provenance: Provenance


def examine(
    entrants: Sequence[Contender],
    suites: Sequence[str],
    out: Path,
    command: str,
    encounters: int | None = None,
    workers: Workers = here,
    progress: Progress = lambda what, done, of: None,
) -> Examined:
    """Sail every entrant through the named suites; chunks kept in ``out/chunks`` are not sailed
    again.

    All entrants on one ship meet the same encounters. InputError for an
    unknown suite, or a pilot that gives no number.
    """
    by_ship = {
        entrant.ship_name: suites_named(suites, entrant.ship, encounters) for entrant in entrants
    }
    jobs = [
        (suite, job)
        for number, entrant in enumerate(entrants)
        for suite in by_ship[entrant.ship_name]
        for job in jobs_of(suite, number, entrant)
    ]
    total, so_far = sum(len(job.which) for _, job in jobs), 0
    parts: dict[tuple[str, int, int], list[tuple[Job, Found]]] = {}
    progress("", 0, total)
    for job, found in all_done([job for _, job in jobs], ResultCache(out / "chunks"), workers):
        so_far += len(job.which)
        progress(f"{entrants[job.entrant].name}, {job.suite}", so_far, total)
        parts.setdefault((job.suite, job.entrant, job.seed), []).append((job, found))
    sailed = []
    for place, _ in enumerate(next(iter(by_ship.values()))):
        for number, entrant in enumerate(entrants):
            suite = by_ship[entrant.ship_name][place]
            for seed in range(len(entrant.pilots)):
                sailed.append(gather(suite, entrant, seed, parts[suite.name, number, seed]))
    timings = [
        decision_time(e.name, e.ship_name, e.pilots[0], e.ship)
        for e in entrants
        if not isinstance(e.pilots[0], OraclePilot)
    ]
    return Examined(tuple(sailed), tuple(timings), Provenance(command, machine()))


def machine() -> str:
    """This machine in a few words."""
    name = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        name = next(x.split(":", 1)[1].strip() for x in lines if x.startswith("model name"))
    except (OSError, StopIteration):
        pass
    device = jax.devices()[0]
    on = "" if device.platform == "cpu" else f", {device.device_kind}"
    return f"{os.cpu_count()} cores of {name}{on}, JAX {jax.__version__}"


def suites_of(examined: Examined) -> list[Suite]:
    """The suites that were sailed, one of each name."""
    return list({s.suite.name: s.suite for s in examined.sailed}.values())


def of_suite(examined: Examined, name: str) -> list[list[Sailed]]:
    """The results of one suite: a list of seeds for every entrant."""
    by_entrant: dict[tuple[str, str], list[Sailed]] = {}
    for one in examined.sailed:
        if one.suite.name == name:
            key = (one.entrant.name, one.entrant.ship_name)
            by_entrant.setdefault(key, []).append(one)
    return list(by_entrant.values())


def stacked(seeds: Sequence[Sailed], column: str) -> np.ndarray:
    """A column of all seeds of an entrant: [seeds, encounters]."""
    return np.stack([one.columns[column] for one in seeds])
