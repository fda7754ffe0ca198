"""An evaluation from beginning to end: every contender through every suite."""

import dataclasses
import os
import platform
from collections.abc import Callable, Sequence
from pathlib import Path

import jax
import numpy as np

from glasshelm import __version__
from glasshelm.evaluation.contenders import Contender
from glasshelm.evaluation.measure_columns import SuiteResult, assemble
from glasshelm.evaluation.result_cache import (
    Columns,
    Executor,
    Job,
    ResultCache,
    run_jobs,
    run_locally,
    split_into_jobs,
)
from glasshelm.evaluation.suites.suite_registry import build_suites
from glasshelm.evaluation.timing import DecisionTime, measure_decision_time
from glasshelm.evaluation.types import Suite
from glasshelm.pilots.clairvoyant import OraclePilot

#: Called with what is being simulated, voyages done and all voyages.
Progress = Callable[[str, int, int], None]


@dataclasses.dataclass(frozen=True)
class RunInfo:
    """Where the numbers of a table come from."""

    command: str
    machine: str
    version: str = __version__


@dataclasses.dataclass(frozen=True)
class EvaluationResult:
    """All results, in the order of suites, contenders, seeds; and the time of a decision."""

    results: tuple[SuiteResult, ...]
    timings: tuple[DecisionTime, ...]
    run_info: RunInfo


def evaluate(
    contenders: Sequence[Contender],
    suites: Sequence[str],
    out: Path,
    command: str,
    encounters: int | None = None,
    executor: Executor = run_locally,
    progress: Progress = lambda what, done, of: None,
) -> EvaluationResult:
    """Evaluate every contender in the named suites.

    Contenders on one ship meet the same encounters. Chunks stored in ``out/chunks`` are not
    simulated again.

    Args:
        contenders: The pilots.
        suites: Names of suites.
        out: The folder of the results.
        command: The command line that the tables cite.
        encounters: The size of drawn suites; None: their own.
        executor: What runs the jobs.
        progress: Called as voyages are done.

    Raises:
        InputError: A suite is unknown, or a pilot gives a rudder that is not a number.
    """
    by_ship = {
        contender.ship_name: build_suites(suites, contender.ship, encounters)
        for contender in contenders
    }
    jobs = [
        (suite, job)
        for number, contender in enumerate(contenders)
        for suite in by_ship[contender.ship_name]
        for job in split_into_jobs(suite, number, contender)
    ]
    total, so_far = sum(len(job.indices) for _, job in jobs), 0
    parts: dict[tuple[str, int, int], list[tuple[Job, Columns]]] = {}
    progress("", 0, total)
    for job, columns in run_jobs([job for _, job in jobs], ResultCache(out / "chunks"), executor):
        so_far += len(job.indices)
        progress(f"{contenders[job.contender].name}, {job.suite}", so_far, total)
        parts.setdefault((job.suite, job.contender, job.seed), []).append((job, columns))
    results = []
    for place, _ in enumerate(next(iter(by_ship.values()))):
        for number, contender in enumerate(contenders):
            suite = by_ship[contender.ship_name][place]
            for seed in range(len(contender.pilots)):
                results.append(assemble(suite, contender, seed, parts[suite.name, number, seed]))
    timings = [
        measure_decision_time(e.name, e.ship_name, e.pilots[0], e.ship)
        for e in contenders
        if not isinstance(e.pilots[0], OraclePilot)
    ]
    return EvaluationResult(tuple(results), tuple(timings), RunInfo(command, describe_machine()))


def describe_machine() -> str:
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


def suites_of(evaluation: EvaluationResult) -> list[Suite]:
    """The suites of an evaluation, one of each name."""
    return list({s.suite.name: s.suite for s in evaluation.results}.values())


def results_by_contender(evaluation: EvaluationResult, name: str) -> list[list[SuiteResult]]:
    """The results of one suite: a list of seeds for each contender."""
    by_entrant: dict[tuple[str, str], list[SuiteResult]] = {}
    for one in evaluation.results:
        if one.suite.name == name:
            key = (one.contender.name, one.contender.ship_name)
            by_entrant.setdefault(key, []).append(one)
    return list(by_entrant.values())


def stack_seeds(seeds: Sequence[SuiteResult], column: str) -> np.ndarray:
    """A column of all seeds of a contender: [seeds, encounters]."""
    return np.stack([one.columns[column] for one in seeds])
