"""Why did a pilot fail? Each failure of the suite ``random`` is simulated again, changed.

    python benchmarks/failures.py PILOT [--event collision] [--encounters 10000]
                                  [--searches 64] [--out failures.csv]

Every failed voyage is repeated with one thing changed. With only the target that was met: does
the pilot avoid it when it is alone? Without one of the other targets: did that one contribute?
With the glassbox pilot taking over later and later: until when was there still a way out? With
the clairvoyant search, which knows everything beforehand: was there any way out at all?
Prints a Markdown table; ``--out`` writes a row a failure, with the number of its encounter.
"""

import argparse
import csv
import dataclasses
import enum
import functools
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int
from rich.console import Console
from rich.progress import Progress

from glasshelm.core.geometry import Vector, to_body
from glasshelm.env.observe import Observation
from glasshelm.evaluation.suites.random_suite import random_suite
from glasshelm.evaluation.tables import markdown_table
from glasshelm.pilots.batched import BatchedPilot
from glasshelm.pilots.clairvoyant import ORACLE_PILOTS, OraclePilot
from glasshelm.pilots.pilot_resolution import ship_of
from glasshelm.pilots.protocols import BatchPolicy, Memory, Pilot
from glasshelm.pilots.registry import pilot_named
from glasshelm.ship.domain import danger_unclipped
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.rollout import (
    SETTINGS,
    Case,
    CaseState,
    Measures,
    policy_for,
    positions,
    rollout,
    rollout_fold,
)

#: Voyages sailed at once.
CHUNK = 128
#: When the other pilot takes over [s]; 0: from the start.
TAKE_OVER_S = (0.0, 60.0, 120.0, 180.0, 240.0, 360.0, 480.0, 720.0, 960.0)


class Event(enum.StrEnum):
    """What counts as a failure."""

    COLLISION = "collision"
    INTRUSION = "intrusion"


class FailureCause(enum.StrEnum):
    """What a failure comes from.

    ``UNAVOIDABLE``: the oracle finds no way to avoid it from the start. ``FIRST_MINUTE``: it can
    be avoided only by steering otherwise in the first minute. ``MISSED_LATER``: there was still
    a way out after that. ``UNKNOWN``: the fallback does not avoid it and no oracle was asked.
    """

    UNAVOIDABLE = "no way out, even known beforehand"
    UNKNOWN = "no way out for the glassbox pilot, not searched"
    FIRST_MINUTE = "lost in the first minute"
    MISSED_LATER = "way out missed later"


@dataclasses.dataclass(frozen=True)
class Failure:
    """One failed voyage.

    Attributes:
        case: Its place in the batch.
        ships: The number of targets.
        met_slot: The slot of the target that was met.
        time_s: When the failure began.
        depth: The worst Eq. 13 of the voyage.
        nearest_m: The least range of the voyage.
        alone: Whether it also happens with that target alone.
        n_contributing: How many of the others would each have to be away to keep clear.
        last_way_out_s: The last take-over that kept clear, None if none did.
        searched: Whether the oracle was asked.
        oracle_clear: Whether the oracle found a way.
    """

    case: int
    ships: int
    met_slot: int
    time_s: float
    depth: float
    nearest_m: float
    alone: bool
    n_contributing: int
    last_way_out_s: float | None
    searched: bool
    oracle_clear: bool

    @property
    def cause(self) -> FailureCause:
        if self.last_way_out_s is None:
            if not self.searched:
                return FailureCause.UNKNOWN
            return FailureCause.FIRST_MINUTE if self.oracle_clear else FailureCause.UNAVOIDABLE
        return FailureCause.MISSED_LATER if self.last_way_out_s > 0 else FailureCause.FIRST_MINUTE


class TakeOver(eqx.Module):
    """One pilot until a step of each world, then another that observed from the start."""

    first: BatchedPilot
    second: BatchedPilot
    step: Int[Array, " w"]

    def start(self, worlds: int) -> Memory:
        return self.first.start(worlds), self.second.start(worlds), jnp.zeros((), jnp.int32)

    def __call__(
        self, observation: Observation, memory: Memory
    ) -> tuple[Float[Array, " w"], Memory]:
        one, two, number = memory
        before, one = self.first(observation, one)
        after, two = self.second(observation, two)
        return jnp.where(number < self.step, before, after), (one, two, number + 1)


def explain_failures(
    pilot: Pilot,
    fallback: Pilot,
    oracle: OraclePilot | None,
    cases: Case,
    event: Event,
    searches: int | None = None,
    progress: Callable[[str, int, int], None] = lambda what, done, of: None,
) -> list[Failure]:
    """The failures of a pilot among cases, explained.

    Args:
        pilot: The pilot.
        fallback: Takes over from it, later and later.
        oracle: Asked where the fallback does not help; None: never.
        cases: The batch; cases without a failure are left out.
        event: What counts as a failure.
        searches: Searches of the oracle at most (the first such cases); None: any number.
        progress: Called with the part of the analysis, voyages done and all voyages.
    """

    def fails(name: str, part: Case, policy_of: Callable[[Case, slice], BatchPolicy]) -> np.ndarray:
        return _fails(name, part, policy_of, event, progress)

    def unchanged(part: Case, where: slice) -> BatchPolicy:
        return BatchedPilot(pilot)

    met = _met(pilot, cases, event, progress)
    failed = met.case
    if len(failed) == 0:
        return []
    cases = _take(cases, failed)
    present = np.asarray(cases.encounter.present)
    slots = np.arange(present.shape[1])
    alone = fails("alone with her", _among(cases, slots == met.slot[:, None]), unchanged)
    who, other = np.nonzero(present & (slots != met.slot[:, None]))
    without = _among(_take(cases, who), slots != other[:, None])
    clear = (
        ~fails("without one of the others", without, unchanged) if len(who) else np.zeros(0, bool)
    )
    n_contributing = np.bincount(who, weights=clear, minlength=len(failed)).astype(int)

    count = len(TAKE_OVER_S)
    steps = np.repeat(np.round(np.array(TAKE_OVER_S) / SETTINGS.step_s).astype(int), len(failed))
    begun = np.tile(met.time_s, count) <= steps * SETTINGS.step_s

    def taken_over(part: Case, where: slice) -> BatchPolicy:
        at = np.resize(steps[where], CHUNK)
        return TakeOver(BatchedPilot(pilot), BatchedPilot(fallback), jnp.asarray(at))

    again = _take(cases, np.tile(np.arange(len(failed)), count))
    saved = ~fails("with another taking over", again, taken_over) & ~begun
    saved = saved.reshape(count, len(failed))
    last = np.where(saved.any(0), np.max(np.where(saved, np.arange(count)[:, None], -1), 0), -1)

    stuck = np.flatnonzero(last < 0)[:searches]
    observation = np.zeros(len(failed), bool)
    if oracle is not None and len(stuck):

        def all_known(part: Case, where: slice) -> BatchPolicy:
            return policy_for(oracle, jax.tree.map(jnp.asarray, part))

        observation[stuck] = ~fails("known beforehand", _take(cases, stuck), all_known)
    asked = np.isin(np.arange(len(failed)), stuck) & (oracle is not None)
    return [
        Failure(
            case=int(failed[k]),
            ships=int(present[k].sum()),
            met_slot=int(met.slot[k]),
            time_s=float(met.time_s[k]),
            depth=float(met.depth[k]),
            nearest_m=float(met.nearest_m[k]),
            alone=bool(alone[k]),
            n_contributing=int(n_contributing[k]),
            last_way_out_s=TAKE_OVER_S[last[k]] if last[k] >= 0 else None,
            searched=bool(asked[k]),
            oracle_clear=bool(observation[k]),
        )
        for k in range(len(failed))
    ]


def _fails(
    name: str,
    cases: Case,
    policy_of: Callable[[Case, slice], BatchPolicy],
    event: Event,
    progress: Callable[[str, int, int], None],
) -> Bool[np.ndarray, " n"]:
    """In which cases the event happens."""
    found = []
    for where, part in _batches(name, cases, progress):
        steps = int(np.asarray(part.steps).max())
        measures = rollout(policy_of(part, where), jax.tree.map(jnp.asarray, part), steps)
        found.append(_happened(measures, part, event)[: where.stop - where.start])
    return np.concatenate(found)


def _batches(
    name: str, cases: Case, progress: Callable[[str, int, int], None]
) -> Iterator[tuple[slice, Case]]:
    """Where they lie among the cases, and ``CHUNK`` of them: the last filled up with its own.

    ``progress`` is called after each.
    """
    size = int(np.shape(cases.steps)[0])
    for first in range(0, size, CHUNK):
        where = slice(first, min(first + CHUNK, size))
        yield where, _take(cases, np.resize(np.arange(size)[where], CHUNK))
        progress(name, where.stop, size)


def _happened(measures: Measures, cases: Case, event: Event) -> Bool[np.ndarray, " n"]:
    if event is Event.INTRUSION:
        return np.asarray(measures.margin[:, 1]) > 0
    return np.asarray(measures.range_m[:, 1]) < np.asarray(cases.ship.loa_m)


class _Ships(eqx.Module):
    """Of every ship so far: from which step on it happened with her (-1: not), how bad it was."""

    since: Int[Array, "w n"]
    worst: Float[Array, "w n"]
    nearest_m: Float[Array, "w n"]


@dataclasses.dataclass(frozen=True)
class _Met:
    """Where it happened, with which ship, from when on, and how bad it was; one number a case."""

    case: np.ndarray
    slot: np.ndarray
    time_s: np.ndarray
    depth: np.ndarray
    nearest_m: np.ndarray


def _met(
    pilot: Pilot, cases: Case, event: Event, progress: Callable[[str, int, int], None]
) -> _Met:
    """The failures, each with the ship that it happened with: the deepest (or nearest) of those.

    Which voyages fail and how is found by one program: another one rounds otherwise, and a voyage
    between two ways out may then go the other way.
    """
    parts = []
    shape = CHUNK, np.asarray(cases.encounter.present).shape[1]
    start = _Ships(jnp.full(shape, -1), jnp.full(shape, -jnp.inf), jnp.full(shape, jnp.inf))
    for where, batch in _batches("the voyages", cases, progress):
        part = jax.tree.map(jnp.asarray, batch)
        steps = jnp.asarray(part.steps).max()
        _, observation = rollout_fold(BatchedPilot(pilot), part, steps, _LOOKS[event], start)
        since, worst, nearest_m = map(
            np.asarray, (observation.since, observation.worst, observation.nearest_m)
        )
        worth = worst if event is Event.INTRUSION else -nearest_m
        slot = np.where(since >= 0, worth, -np.inf).argmax(-1)
        began = np.take_along_axis(since, slot[:, None], -1)[:, 0]
        failed = np.flatnonzero(began[: where.stop - where.start] >= 0)
        found = (slot, began * SETTINGS.step_s, worst.max(-1), nearest_m.min(-1))
        parts.append([failed + where.start, *(x[failed] for x in found)])
    return _Met(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _look(event: Event, so_far: _Ships, cases: Case, live: CaseState) -> _Ships:
    """One instant more, if it is measured: not after the voyage's end."""
    step, own = live.state.step, jax.tree.map(lambda x: x[:, None], live.state.own)
    place = jax.vmap(positions)(cases, live, jnp.zeros(step.shape))
    offset = Vector(place.east_m - own.east_m, place.north_m - own.north_m)
    length_m = jnp.asarray(cases.ship.loa_m)[:, None]
    counted = live.measures.time_s == step * SETTINGS.step_s
    there = place.present & cases.encounter.present & counted[:, None]
    margin = danger_unclipped(to_body(offset, own.heading_rad), length_m)
    margin = jnp.where(there, margin, -jnp.inf)
    range_m = jnp.where(there, jnp.hypot(offset.x, offset.y), jnp.inf)
    bad = margin > 0 if event is Event.INTRUSION else range_m < length_m
    since = jnp.where(bad & (so_far.since < 0), step[:, None], so_far.since)
    worst = jnp.maximum(so_far.worst, margin)
    return _Ships(since, worst, jnp.minimum(so_far.nearest_m, range_m))


_LOOKS = {event: functools.partial(_look, event) for event in Event}


def _among(cases: Case, kept: Bool[np.ndarray, "w n"]) -> Case:
    """The cases with only some of their ships."""
    present = np.asarray(cases.encounter.present) & kept
    return eqx.tree_at(lambda c: c.encounter.present, cases, present)


def _take(cases: Case, which: np.ndarray) -> Case:
    return jax.tree.map(lambda x: np.asarray(x)[which], cases)


def summary_table(failures: Sequence[Failure]) -> str:
    """A Markdown table: how many failures have each cause, and what else is known of them."""
    header = (
        "what happened", "voyages", "also with that ship alone", "one other ship less would do",
        "way out until, median before the event [s]",
    )  # fmt: skip
    rows = []
    for cause in FailureCause:
        those = [f for f in failures if f.cause is cause]
        left = [f.time_s - f.last_way_out_s for f in those if f.last_way_out_s is not None]
        rows.append(
            [
                cause.value,
                f"{len(those)} of {len(failures)}",
                str(sum(f.alone for f in those)),
                str(sum(f.n_contributing > 0 and not f.alone for f in those)),
                f"{np.median(left):.0f}" if left else "–",
            ]
        )
    return markdown_table(header, rows)


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
            pilot_named(f"{prefix}-glassbox"),
            ORACLE_PILOTS[f"{prefix}-clairvoyant"],
            random_suite(ship, given.encounters).cases,
            Event(given.event),
            given.searches,
            progress,
        )
    print(f"{given.pilot}: {len(failures)} voyages with a {given.event}")
    print(summary_table(failures))
    stuck = [f for f in failures if f.searched]
    print(f"searched: {len(stuck)}, a way found in {sum(f.oracle_clear for f in stuck)}")
    if given.out:
        with open(given.out, "w", newline="") as file:
            names = [field.name for field in dataclasses.fields(failures[0])] if failures else []
            writer = csv.writer(file)
            writer.writerow([*names, "cause"])
            writer.writerows([*dataclasses.astuple(f), f.cause.value] for f in failures)


if __name__ == "__main__":
    main()
