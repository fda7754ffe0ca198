"""Which ships of a recording are worth being own ship."""

import dataclasses

import numpy as np

from glasshelm.ais.table import OWN_SENSORS, ReportTable, StaticData
from glasshelm.encounters.globe import LOST_AFTER_S, snapshots
from glasshelm.ship.nomoto import NAUTICAL_MILE_M

#: Ships this near at the same minute have met.
MEETING_M = 2 * NAUTICAL_MILE_M
UNDER_WAY_KN = 3.0
_GRID_S = 60.0


@dataclasses.dataclass(frozen=True)
class Candidate:
    """A ship under way: how long she is heard, how fast she goes, how many ships she meets."""

    mmsi: int
    name: str | None
    heard_s: float
    mean_sog_kn: float
    meetings: int

    def __str__(self) -> str:
        name = f" {self.name}" if self.name else ""
        ships = "ship" if self.meetings == 1 else "ships"
        return (
            f"{self.mmsi}{name} ({self.heard_s / 60:.0f} min, {self.mean_sog_kn:.0f} kn, "
            f"meets {self.meetings} {ships})"
        )


def own_ship_candidates(
    reports: ReportTable, ships: dict[int, StaticData], best: int = 5
) -> tuple[Candidate, ...]:
    """The ``best`` own ships of cleaned reports.

    Of the ships under way for at least half of the longest time that one is,
    those that pass most ships under way within 2 NM; the longer heard first
    among equals.
    """
    numbers, first, count = np.unique(reports.mmsi, return_index=True, return_counts=True)
    sog = np.add.reduceat(reports.sog_kn, first) / count
    heard = reports.time_s[first + count - 1] - reports.time_s[first]
    moving = (sog >= UNDER_WAY_KN) & (count >= 3) & (numbers != OWN_SENSORS)
    if not moving.any():
        return ()
    chosen = np.flatnonzero(moving)
    meetings = _meetings(reports.take(np.isin(reports.mmsi, numbers[chosen])), numbers[chosen])
    longest = heard[chosen].max()
    found = [
        Candidate(
            int(numbers[i]),
            ships.get(int(numbers[i]), StaticData()).name,
            float(heard[i]),
            float(sog[i]),
            int(met),
        )
        for i, met in zip(chosen, meetings, strict=True)
        if heard[i] >= 0.5 * longest
    ]
    found.sort(key=lambda c: (-c.meetings, -c.heard_s, c.mmsi))
    return tuple(found[:best])


def _meetings(reports: ReportTable, numbers: np.ndarray) -> np.ndarray:
    """How many of the ships each one has within MEETING_M at the same whole minute."""
    met = np.zeros((0, 2), np.int64)
    for ships in snapshots(reports, _GRID_S, LOST_AFTER_S):
        pairs = np.searchsorted(numbers, ships.mmsi[ships.pairs(MEETING_M)])
        met = np.unique(np.concatenate([met, np.sort(pairs, axis=1)]), axis=0)
    return np.bincount(met.ravel(), minlength=len(numbers))
