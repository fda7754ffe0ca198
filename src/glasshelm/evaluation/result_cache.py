"""An examination cut into jobs: a chunk of cases for one pilot, done once and kept."""

import dataclasses
import hashlib
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from glasshelm.core.output_dir import atomic_write
from glasshelm.evaluation.contenders import Contender, code_digest, digest_of
from glasshelm.evaluation.rollout import helm_for, sail
from glasshelm.evaluation.types import Case, Suite
from glasshelm.pilots.clairvoyant import OraclePilot
from glasshelm.pilots.protocols import Pilot

#: Worlds sailed at once.
CHUNK = 500
#: What a job leaves: the measures of its cases by their dotted names.
Found = dict[str, np.ndarray]


@dataclasses.dataclass(frozen=True)
class Job:
    """Some cases of a suite under one pilot. ``which`` are their places in the suite.

    ``key`` is made of everything that the result depends on: pilot, cases,
    code. Two jobs with one key have one result, to the bit.
    """

    suite: str
    entrant: int
    seed: int
    which: np.ndarray
    pilot: Pilot | OraclePilot
    cases: Case
    steps: int
    key: str


#: Does jobs in any order: gives each one's place in the list, and what it left.
Workers = Callable[[Sequence[Job]], Iterator[tuple[int, Found]]]


def jobs_of(suite: Suite, number: int, entrant: Contender, chunk: int = CHUNK) -> Iterator[Job]:
    """The jobs of one entrant (the ``number``-th) in one suite, the longest voyages together.

    Every chunk has the same number of worlds, the last is filled up with its
    own first case; so one program is compiled and a result does not depend on
    how many cases there are.
    """
    duration = np.asarray(suite.cases.steps)
    order = np.argsort(duration, kind="stable")
    worlds = min(chunk, suite.size)
    code = code_digest()
    for seed, pilot in enumerate(entrant.pilots):
        told = f"{code} {digest_of(pilot)}"
        for first in range(0, suite.size, worlds):
            which = order[first : first + worlds]
            filled = np.concatenate([which, np.full(worlds - len(which), which[0])])
            cases = suite.take(filled)
            steps = int(duration[which].max())
            key = _key(told, cases, steps)
            yield Job(suite.name, number, seed, which, pilot, cases, steps, key)


def _key(told: str, cases: Case, steps: int) -> str:
    digest = hashlib.sha256(f"{told} {steps}".encode())
    for leaf in jax.tree.leaves(cases):
        digest.update(f"{leaf.shape}{leaf.dtype}".encode() + np.ascontiguousarray(leaf).tobytes())
    return digest.hexdigest()[:32]


def run_job(job: Job) -> Found:
    """Sail a job's cases: its measures, without the cases that filled it up."""
    cases = jax.tree.map(jnp.asarray, job.cases)
    measures = sail(helm_for(job.pilot, cases), cases, job.steps)
    count = len(job.which)
    return {name: value[:count] for name, value in _named(jax.device_get(measures), "")}


def _named(part: Any, prefix: str) -> Iterator[tuple[str, np.ndarray]]:
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        if dataclasses.is_dataclass(value):
            yield from _named(value, f"{prefix}{field.name}.")
        else:
            yield prefix + field.name, np.asarray(value)


def here(jobs: Sequence[Job]) -> Iterator[tuple[int, Found]]:
    """The workers that are this process: one job after the other."""
    for place, job in enumerate(jobs):
        yield place, run_job(job)


class ResultCache:
    """Finished jobs in a folder, by their keys: one file each, whole or not there."""

    def __init__(self, folder: Path):
        self.folder = folder

    def path(self, key: str) -> Path:
        return self.folder / f"{key}.npz"

    def read(self, key: str) -> Found | None:
        """What a job left, if it was done before; a damaged file counts as none."""
        try:
            with np.load(self.path(key), allow_pickle=False) as file:
                return {name: file[name] for name in file.files}
        except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error):
            return None

    def write(self, key: str, found: Found) -> None:
        """Keep it. InputError if it cannot be written."""
        with atomic_write(self.path(key)) as partial, open(partial, "wb") as file:
            np.savez(file, **found)  # type: ignore[arg-type]


def all_done(
    jobs: Sequence[Job], kept: ResultCache, workers: Workers = here
) -> Iterable[tuple[Job, Found]]:
    """Every job with what it left: those kept at once, the others as they are done."""
    left: list[Job] = []
    for job in jobs:
        found = kept.read(job.key)
        if found is None:
            left.append(job)
        else:
            yield job, found
    for place, found in workers(left):
        kept.write(left[place].key, found)
        yield left[place], found
