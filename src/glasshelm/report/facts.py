"""What happened, ship by ship, as numbers: closest approach, domain, largest priority."""

import dataclasses

import numpy as np

from glasshelm.figures.series import Frames, Series, ShipSeries, series
from glasshelm.report.words import clock, lasting, miles, where


@dataclasses.dataclass(frozen=True)
class Passage:
    """One target's passage of own ship. Frames are given by index.

    ``closest_m`` at ``closest``; ``interior`` says that she had been closing
    before and was opening after. ``inside_s`` is the time in own ship's domain,
    ``deepest`` the largest danger (Eq. 13). ``wanted`` is the frame of her
    largest priority (Eq. 22), absent where the pilot has no critic.
    """

    ship: ShipSeries
    first: int
    closest: int
    closest_m: float
    interior: bool
    inside_s: float
    deepest: float
    wanted: int | None

    @property
    def name(self) -> str:
        return self.ship.name


def passages(frames: Frames) -> list[Passage]:
    """Every target's passage, the nearest first."""
    voyage = series(frames)
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
        interior=bool(seen[0] < closest < seen[-1]),
        inside_s=float((_durations(voyage) * inside).sum()),
        deepest=float(np.nanmax(ship.danger)),
        wanted=int(np.nanargmax(ship.priority)) if ship.has("priority") else None,
    )


def _durations(voyage: Series) -> np.ndarray:
    """How long each frame stands [s]: until the next; the last as long as the one before."""
    if len(voyage.time_s) < 2:
        return np.zeros(1)
    steps = np.diff(voyage.time_s)
    return np.append(steps, steps[-1])


def verdict(frames: Frames) -> str:
    """The voyage in one line: how near the nearest came, and whether the domain was entered."""
    voyage = series(frames)
    found = passages(voyage)
    if not found:
        return "No other ship was there."
    near = found[0]
    loa = voyage.frames[0].ship.loa_m
    at = f"{near.name}, {clock(voyage, near.closest)}"
    if near.closest_m < loa:
        return (
            f"Within one ship length: {miles(near.closest_m)} ({at}). This counts as a collision."
        )
    entered = [p for p in found if p.inside_s > 0]
    if not entered:
        return f"No ship came nearer than {miles(near.closest_m)} ({at}); none entered the domain."
    deepest = max(entered, key=lambda p: p.deepest)
    ships = "one ship" if len(entered) == 1 else f"{len(entered)} ships"
    return (
        f"The domain was entered by {ships}: {deepest.name} for {lasting(deepest.inside_s)}, "
        f"danger up to {deepest.deepest:.2f} of 1. Nearest: {miles(near.closest_m)} ({at})."
    )


def describe(passage: Passage) -> str:
    """Range and side of the closest approach: ``0.80 NM on the port beam``."""
    bearing = float(passage.ship.bearing_rad[passage.closest])
    return f"{miles(passage.closest_m)} {where(bearing)}"


def outside(frames: Frames) -> list[tuple[str, int, float]]:
    """What lay outside the training distribution: words, first frame, share of the frames."""
    voyage = series(frames)
    first: dict[str, int] = {}
    count: dict[str, int] = {}
    for k, frame in enumerate(voyage.frames):
        for words in frame.outside or ():
            first.setdefault(words, k)
            count[words] = count.get(words, 0) + 1
    return [(words, k, count[words] / len(voyage.frames)) for words, k in first.items()]
