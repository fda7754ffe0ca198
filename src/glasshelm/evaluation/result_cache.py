"""An evaluation cut into jobs, each a chunk of cases for one pilot, done once and stored."""

import dataclasses
import hashlib
import zipfile
import zlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from glasshelm.core.output_dir import atomic_write
from glasshelm.evaluation.contenders import Contender, code_digest, pilot_digest
from glasshelm.evaluation.types import Suite
from glasshelm.pilots.clairvoyant import OraclePilot
from glasshelm.pilots.protocols import Pilot
from glasshelm.simulation.rollout import Case, policy_for, rollout

#: Cases simulated at once.
CHUNK = 500
#: Arrays by name, one row a case.
Columns = dict[str, np.ndarray]


@dataclasses.dataclass(frozen=True)
class Job:
    """Some cases of a suite under one pilot.

    Attributes:
        suite: The suite's name.
        contender: The number of the contender.
        seed: Its training seed.
        indices: The cases' places in the suite.
        pilot: The pilot.
        cases: The cases, padded to the size of a chunk.
        steps: Steps of the longest case.
        key: A digest of all that the result depends on: pilot, cases, code. Jobs with one key
            have one result, to the bit.
    """

    suite: str
    contender: int
    seed: int
    indices: np.ndarray
    pilot: Pilot | OraclePilot
    cases: Case
    steps: int
    key: str


#: Runs jobs in any order and yields each one's place in the list with its result.
Executor = Callable[[Sequence[Job]], Iterator[tuple[int, Columns]]]


def split_into_jobs(
    suite: Suite, number: int, contender: Contender, chunk: int = CHUNK
) -> Iterator[Job]:
    """The jobs of one contender (the ``number``-th) in one suite, the longest cases together.

    Every chunk has the same number of cases; the last is padded with its own first one. So one
    program is compiled, and a result does not depend on how many cases there are.
    """
    steps = np.asarray(suite.cases.steps)
    order = np.argsort(steps, kind="stable")
    size = min(chunk, suite.size)
    code = code_digest()
    for seed, pilot in enumerate(contender.pilots):
        prefix = f"{code} {pilot_digest(pilot)}"
        for first in range(0, suite.size, size):
            indices = order[first : first + size]
            padding = np.full(size - len(indices), indices[0])
            cases = suite.take(np.concatenate([indices, padding]))
            longest = int(steps[indices].max())
            key = _key(f"{prefix} {longest}", cases)
            yield Job(suite.name, number, seed, indices, pilot, cases, longest, key)


def _key(prefix: str, cases: Case) -> str:
    digest = hashlib.sha256(prefix.encode())
    for leaf in jax.tree.leaves(cases):
        digest.update(f"{leaf.shape}{leaf.dtype}".encode() + np.ascontiguousarray(leaf).tobytes())
    return digest.hexdigest()[:32]


def run_job(job: Job) -> Columns:
    """Simulate a job's cases: their measures by dotted names, without the padding."""
    cases = jax.tree.map(jnp.asarray, job.cases)
    measures = jax.device_get(rollout(policy_for(job.pilot, cases), cases, job.steps))
    return {name: value[: len(job.indices)] for name, value in _named(measures, "")}


def _named(part: Any, prefix: str) -> Iterator[tuple[str, np.ndarray]]:
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        if dataclasses.is_dataclass(value):
            yield from _named(value, f"{prefix}{field.name}.")
        else:
            yield prefix + field.name, np.asarray(value)


def run_locally(jobs: Sequence[Job]) -> Iterator[tuple[int, Columns]]:
    """The executor that is this process: one job after the other."""
    for place, job in enumerate(jobs):
        yield place, run_job(job)


class ResultCache:
    """Results in a folder by their keys: one file each, whole or not there."""

    def __init__(self, folder: Path):
        self.folder = folder

    def path(self, key: str) -> Path:
        return self.folder / f"{key}.npz"

    def read(self, key: str) -> Columns | None:
        """A stored result; None if there is none, or the file is damaged."""
        try:
            with np.load(self.path(key), allow_pickle=False) as file:
                return {name: file[name] for name in file.files}
        except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error):
            return None

    def write(self, key: str, columns: Columns) -> None:
        """Store a result. InputError if it cannot be written."""
        with atomic_write(self.path(key)) as partial, open(partial, "wb") as file:
            np.savez(file, **columns)  # type: ignore[arg-type]


def run_jobs(
    jobs: Sequence[Job], cache: ResultCache, executor: Executor = run_locally
) -> Iterator[tuple[Job, Columns]]:
    """Every job with its result: those stored at once, the others as they are done."""
    missing: list[Job] = []
    for job in jobs:
        columns = cache.read(job.key)
        if columns is None:
            missing.append(job)
        else:
            yield job, columns
    for place, columns in executor(missing):
        cache.write(missing[place].key, columns)
        yield missing[place], columns
