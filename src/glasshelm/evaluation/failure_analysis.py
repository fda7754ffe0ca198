"""Why did a pilot fail? Every failed voyage is sailed again with one thing changed.

Without the other ships: does the pilot avoid the one that was met, when she is alone?
Without one of the others: was there one that blocked the way? With another pilot taking
over later and later: until when was there still a way out? And told everything
beforehand: was there any way at all?
"""

import dataclasses
import enum
import functools
from collections.abc import Callable, Iterator, Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from glasshelm.core.geometry import Vector, to_body
from glasshelm.env.observe import Observation
from glasshelm.evaluation.rollout import SETTINGS, Live, Measures, helm_for, place_of, sail, watched
from glasshelm.evaluation.types import Case
from glasshelm.pilots.batched import BatchedPilot
from glasshelm.pilots.clairvoyant import OraclePilot
from glasshelm.pilots.protocols import BatchPolicy, Memory, Pilot
from glasshelm.ship.domain import danger_unclipped

#: Voyages sailed at once.
CHUNK = 128
#: When the other pilot takes over [s]; 0: from the start.
TAKE_OVER_S = (0.0, 60.0, 120.0, 180.0, 240.0, 360.0, 480.0, 720.0, 960.0)


class Event(enum.StrEnum):
    """What counts as a failure."""

    COLLISION = "collision"
    INTRUSION = "intrusion"


class Verdict(enum.StrEnum):
    """What a failure comes from. ``NO_WAY``: the seer finds no way to avoid it from the start on.

    ``AT_ONCE``: only who steers otherwise in the first minute avoids it; ``LATER``: there was
    still a way out after that. ``OPEN``: the other pilot does not avoid it, no seer was asked.
    """

    NO_WAY = "no way out, even known beforehand"
    OPEN = "no way out for the planner, not searched"
    AT_ONCE = "lost in the first minute"
    LATER = "way out missed later"


@dataclasses.dataclass(frozen=True)
class Failure:
    """One failed voyage. ``case`` is its place in the batch, ``with_slot`` the ship that was met.

    ``time_s`` is when it began, ``depth`` the worst Eq. 13 and ``nearest_m`` the least range of
    the voyage. ``alone``: it happens also if she is the only other ship; ``company``: how many
    of the others would each have to be away for the pilot to keep clear. ``way_out_until_s``: the
    last take-over that kept clear, None if none did. ``searched``: whether the seer was
    asked, ``seer_clear``: whether it found a way.
    """

    case: int
    ships: int
    with_slot: int
    time_s: float
    depth: float
    nearest_m: float
    alone: bool
    company: int
    way_out_until_s: float | None
    searched: bool
    seer_clear: bool

    @property
    def verdict(self) -> Verdict:
        if self.way_out_until_s is None:
            if not self.searched:
                return Verdict.OPEN
            return Verdict.AT_ONCE if self.seer_clear else Verdict.NO_WAY
        return Verdict.LATER if self.way_out_until_s > 0 else Verdict.AT_ONCE


class TakeOver(eqx.Module):
    """One pilot until a step of each world, from then on another, who was watching all the time."""

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
    rescuer: Pilot,
    seer: OraclePilot | None,
    cases: Case,
    event: Event,
    searches: int | None = None,
    progress: Callable[[str, int, int], None] = lambda what, done, of: None,
) -> list[Failure]:
    """The failures of a pilot among cases, explained; voyages that do not fail are left out.

    ``rescuer`` takes over in simulation; ``seer`` is asked where that does not help, at most
    ``searches`` times (the first such cases; None: always). ``progress`` receives the voyages done.
    """

    def fails(name: str, part: Case, steersman: Callable[[Case, slice], BatchPolicy]) -> np.ndarray:
        return _fails(name, part, steersman, event, progress)

    def helm(part: Case, where: slice) -> BatchPolicy:
        return BatchedPilot(pilot)

    met = _met(pilot, cases, event, progress)
    failed = met.case
    if len(failed) == 0:
        return []
    cases = _take(cases, failed)
    present = np.asarray(cases.encounter.present)
    slots = np.arange(present.shape[1])
    alone = fails("alone with her", _among(cases, slots == met.slot[:, None]), helm)
    who, other = np.nonzero(present & (slots != met.slot[:, None]))
    without = _among(_take(cases, who), slots != other[:, None])
    clear = ~fails("without one of the others", without, helm) if len(who) else np.zeros(0, bool)
    company = np.bincount(who, weights=clear, minlength=len(failed)).astype(int)

    count = len(TAKE_OVER_S)
    steps = np.repeat(np.round(np.array(TAKE_OVER_S) / SETTINGS.step_s).astype(int), len(failed))
    begun = np.tile(met.time_s, count) <= steps * SETTINGS.step_s

    def rescued(part: Case, where: slice) -> BatchPolicy:
        at = np.resize(steps[where], CHUNK)
        return TakeOver(BatchedPilot(pilot), BatchedPilot(rescuer), jnp.asarray(at))

    again = _take(cases, np.tile(np.arange(len(failed)), count))
    saved = ~fails("with another taking over", again, rescued) & ~begun
    saved = saved.reshape(count, len(failed))
    last = np.where(saved.any(0), np.max(np.where(saved, np.arange(count)[:, None], -1), 0), -1)

    hopeless = np.flatnonzero(last < 0)[:searches]
    observation = np.zeros(len(failed), bool)
    if seer is not None and len(hopeless):

        def told(part: Case, where: slice) -> BatchPolicy:
            return helm_for(seer, jax.tree.map(jnp.asarray, part))

        observation[hopeless] = ~fails("known beforehand", _take(cases, hopeless), told)
    asked = np.isin(np.arange(len(failed)), hopeless) & (seer is not None)
    return [
        Failure(
            case=int(failed[k]),
            ships=int(present[k].sum()),
            with_slot=int(met.slot[k]),
            time_s=float(met.time_s[k]),
            depth=float(met.depth[k]),
            nearest_m=float(met.nearest_m[k]),
            alone=bool(alone[k]),
            company=int(company[k]),
            way_out_until_s=TAKE_OVER_S[last[k]] if last[k] >= 0 else None,
            searched=bool(asked[k]),
            seer_clear=bool(observation[k]),
        )
        for k in range(len(failed))
    ]


def _fails(
    name: str,
    cases: Case,
    steersman: Callable[[Case, slice], BatchPolicy],
    event: Event,
    progress: Callable[[str, int, int], None],
) -> Bool[np.ndarray, " n"]:
    """In which cases the event happens."""
    found = []
    for where, part in _batches(name, cases, progress):
        steps = int(np.asarray(part.steps).max())
        measures = sail(steersman(part, where), jax.tree.map(jnp.asarray, part), steps)
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
        _, observation = watched(BatchedPilot(pilot), part, steps, _LOOKS[event], start)
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


def _look(event: Event, so_far: _Ships, cases: Case, live: Live) -> _Ships:
    """One instant more, if it is measured: not after the voyage's end."""
    step, own = live.state.step, jax.tree.map(lambda x: x[:, None], live.state.own)
    place = jax.vmap(place_of)(cases, live, jnp.zeros(step.shape))
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


def counted(failures: Sequence[Failure]) -> str:
    """A Markdown table: how many failures of each verdict, and what else is known of them."""
    rows = [
        "| what happened | voyages | also with that ship alone | one other ship less would do | "
        "way out until, median before the event [s] |",
        "|---|---|---|---|---|",
    ]
    for verdict in Verdict:
        those = [f for f in failures if f.verdict is verdict]
        left = [f.time_s - f.way_out_until_s for f in those if f.way_out_until_s is not None]
        cells = [
            verdict.value,
            f"{len(those)} of {len(failures)}",
            str(sum(f.alone for f in those)),
            str(sum(f.company > 0 and not f.alone for f in those)),
            f"{np.median(left):.0f}" if left else "–",
        ]
        rows.append("| " + " | ".join(cells) + " |")
    return "\n".join(rows)
