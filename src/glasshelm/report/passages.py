"""What happened, ship by ship, as numbers: closest approach, domain, largest priority."""

import dataclasses
import re

import numpy as np

from glasshelm.frames.phrases import clock, duration, miles, relative_bearing
from glasshelm.frames.series import Frames, Series, ShipSeries, to_series

#: A ship passes if she was farther off by this much before, and after.
PASSING_M = 100.0


@dataclasses.dataclass(frozen=True)
class Passage:
    """One target's passage of own ship. Frames are given by index.

    ``closest_m`` at ``closest``; ``is_minimum`` says that she had been farther off
    before and was after, by more than noise in a position. ``inside_s`` is the
    time in own ship's domain, ``max_danger`` the largest danger (Eq. 13).
    ``largest_priority`` is the frame of her largest priority (Eq. 22), absent where the
    pilot has no critic.
    """

    ship: ShipSeries
    first: int
    closest: int
    closest_m: float
    is_minimum: bool
    inside_s: float
    max_danger: float
    largest_priority: int | None

    @property
    def name(self) -> str:
        return self.ship.name


def passages(frames: Frames) -> list[Passage]:
    """Every target's passage, the nearest first."""
    voyage = to_series(frames)
    return sorted((_passage(voyage, s) for s in voyage.ships), key=lambda p: p.closest_m)


def _passage(voyage: Series, ship: ShipSeries) -> Passage:
    seen = np.flatnonzero(np.isfinite(ship.range_m))
    closest = ship.nearest
    inside = np.nan_to_num(ship.danger) > 0
    return Passage(
        ship=ship,
        first=int(seen[0]),
        closest=closest,
        closest_m=float(ship.range_m[closest]),
        is_minimum=_rises(ship.range_m[: closest + 1]) and _rises(ship.range_m[closest:]),
        inside_s=float((_durations(voyage) * inside).sum()),
        max_danger=float(np.nanmax(ship.danger)),
        largest_priority=int(np.nanargmax(ship.priority)) if ship.has("priority") else None,
    )


def _rises(range_m: np.ndarray) -> bool:
    """Whether a range is somewhere well above its least."""
    return bool(np.nanmax(range_m) - np.nanmin(range_m) > PASSING_M)


def _durations(voyage: Series) -> np.ndarray:
    """How long each frame stands [s]: until the next; the last as long as the one before."""
    if len(voyage.time_s) < 2:
        return np.zeros(1)
    steps = np.diff(voyage.time_s)
    return np.append(steps, steps[-1])


def verdict(frames: Frames) -> str:
    """The voyage in one line: how near the nearest came, and whether the domain was entered."""
    voyage = to_series(frames)
    found = passages(voyage)
    if not found:
        return "No other ship was there."
    near = found[0]
    loa = voyage.frames[0].ship.loa_m
    at = f"{near.name}, {clock(voyage, near.closest)}"
    if near.closest_m < loa:
        what = "a collision" if voyage.applied else "less than the ship length assumed here"
        return f"Nearest: {near.closest_m:.0f} m, {what} ({at})."
    entered = [p for p in found if p.inside_s > 0]
    if not entered:
        return f"No ship came nearer than {miles(near.closest_m)} ({at}); none entered the domain."
    deepest = max(entered, key=lambda p: p.max_danger)
    ships = "one ship" if len(entered) == 1 else f"{len(entered)} ships"
    return (
        f"The domain was entered by {ships}: {deepest.name} for {duration(deepest.inside_s)}, "
        f"danger up to {deepest.max_danger:.2f} of 1. Nearest: {miles(near.closest_m)} ({at})."
    )


def describe(passage: Passage) -> str:
    """Range and side of the closest approach: ``0.80 NM on the port beam``."""
    bearing = float(passage.ship.bearing_rad[passage.closest])
    return f"{miles(passage.closest_m)} {relative_bearing(bearing)}"


@dataclasses.dataclass(frozen=True)
class OutsideTraining:
    """One kind of thing outside the training distribution: its words when first said, and since.

    Words that differ only in their numbers are of one kind. ``first`` is the
    first frame, ``share`` the share of all frames.
    """

    words: str
    first: int
    share: float


def outside_training(frames: Frames) -> list[OutsideTraining]:
    """What lay outside the training distribution, as the frames say, in order of appearance."""
    voyage = to_series(frames)
    first: dict[str, tuple[str, int]] = {}
    count: dict[str, int] = {}
    for k, frame in enumerate(voyage.frames):
        kinds = {
            re.sub(r"\d+(\.\d+)?", "#", words): words for words in frame.outside_training or ()
        }
        for kind, words in kinds.items():
            first.setdefault(kind, (words, k))
            count[kind] = count.get(kind, 0) + 1
    total = len(voyage.frames)
    return [OutsideTraining(words, k, count[kind] / total) for kind, (words, k) in first.items()]
