"""Which ships of a recording are worth being own ship."""

import dataclasses

import numpy as np

from glasshelm.ais.limits import LOST_AFTER_S, UNDER_WAY_KN
from glasshelm.ais.table import OWN_SENSORS, ReportTable, StaticData
from glasshelm.encounters.snapshots import snapshots
from glasshelm.ship.nomoto import NAUTICAL_MILE_M

#: Ships this near at the same minute have met.
MEETING_M = 2 * NAUTICAL_MILE_M
_GRID_S = 60.0


@dataclasses.dataclass(frozen=True)
class Candidate:
    """A ship under way: how long it is recorded, its mean speed, how many ships it meets."""

    mmsi: int
    name: str | None
    recorded_s: float
    mean_sog_kn: float
    n_meetings: int

    def __str__(self) -> str:
        name = f" {self.name}" if self.name else ""
        ships = "ship" if self.n_meetings == 1 else "ships"
        return (
            f"{self.mmsi}{name} ({self.recorded_s / 60:.0f} min, {self.mean_sog_kn:.0f} kn, "
            f"meets {self.n_meetings} {ships})"
        )


def own_ship_candidates(
    reports: ReportTable, ships: dict[int, StaticData], best: int = 5
) -> tuple[Candidate, ...]:
    """The ``best`` own ships of cleaned reports.

    Of the ships under way for at least half of the longest time that one is,
    those that pass most ships under way within 2 NM; among equals those recorded longest.
    """
    numbers, first, count = np.unique(reports.mmsi, return_index=True, return_counts=True)
    sog = np.add.reduceat(reports.sog_kn, first) / count
    recorded = reports.time_s[first + count - 1] - reports.time_s[first]
    under_way = (sog >= UNDER_WAY_KN) & (count >= 3) & (numbers != OWN_SENSORS)
    if not under_way.any():
        return ()
    numbers, sog, recorded = numbers[under_way], sog[under_way], recorded[under_way]
    n_meetings = _count_meetings(reports.take(np.isin(reports.mmsi, numbers)), numbers)
    candidates = [
        Candidate(mmsi, ships.get(mmsi, StaticData()).name, *values)
        for mmsi, *values in zip(
            numbers.tolist(), recorded.tolist(), sog.tolist(), n_meetings.tolist(), strict=True
        )
        if values[0] >= 0.5 * recorded.max()
    ]
    candidates.sort(key=lambda c: (-c.n_meetings, -c.recorded_s, c.mmsi))
    return tuple(candidates[:best])


def _count_meetings(reports: ReportTable, numbers: np.ndarray) -> np.ndarray:
    """How many of the ships each one has within MEETING_M at the same whole minute."""
    met = np.zeros((0, 2), np.int64)
    for ships in snapshots(reports, _GRID_S, LOST_AFTER_S):
        pairs = np.searchsorted(numbers, ships.mmsi[ships.pairs(MEETING_M)])
        met = np.unique(np.concatenate([met, np.sort(pairs, axis=1)]), axis=0)
    return np.bincount(met.ravel(), minlength=len(numbers))
