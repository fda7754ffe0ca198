"""The ships that are known: which report is of which ship; only so many, the nearest."""

import math
from collections.abc import Iterator

import numpy as np

from glasshelm.ais.geodesy import offset_m
from glasshelm.ais.limits import FORGOTTEN_S
from glasshelm.ais.reports import Report
from glasshelm.ais.vessel import Fix, Vessel

#: Ships kept at most. A tenth more may be known for a moment; then the farthest are forgotten.
MAX_SHIPS = 10_000


class VesselStore:
    """Ships by number. When there are too many, a far one never displaces a near one."""

    def __init__(self) -> None:
        self.ships: dict[str, Vessel] = {}
        #: While there are too many: how far off a ship is that is still kept [m].
        self._reach_m = math.inf

    def __len__(self) -> int:
        return len(self.ships)

    @property
    def full(self) -> bool:
        """Whether there were more ships than are kept."""
        return self._reach_m < math.inf

    def find(self, r: Report) -> Vessel | None:
        """The ship of a report. Of two ships with one number: the nearer one."""
        first, second = self.ships.get(r.id), self.ships.get(_twin_id(r.id))
        if first is None or second is None:
            return first or second
        if r.latitude_deg is None or r.longitude_deg is None:
            return max(first, second, key=lambda v: v.last_heard_s)
        if first.fix is None or second.fix is None:
            return first
        to_first, to_second = (
            _distance_m(fix, r.latitude_deg, r.longitude_deg) for fix in (first.fix, second.fix)
        )
        return first if to_first <= to_second else second

    def distance_m(self, r: Report, own: Fix | None) -> float:
        """Roughly how far from own ship a report is, or else the ship of the report [m]."""
        if r.latitude_deg is not None or r.id not in self.ships:
            return _distance_m(own, r.latitude_deg, r.longitude_deg)
        fix = self.ships[r.id].fix
        return math.inf if fix is None else _distance_m(own, fix.latitude_deg, fix.longitude_deg)

    def add(self, r: Report, own: Fix | None) -> Vessel | None:
        """A ship not known before; None if there are too many nearer ones."""
        if len(self.ships) >= MAX_SHIPS + MAX_SHIPS // 10:
            self._keep_nearest(own)
        if self.full and _distance_m(own, r.latitude_deg, r.longitude_deg) >= self._reach_m:
            return None
        vessel = self.ships[r.id] = Vessel(r.id)
        return vessel

    def split(self, vessel: Vessel) -> None:
        """Make a ship of its own of the one that uses another ship's number elsewhere."""
        fix, vessel.twin_fix = vessel.twin_fix, None
        number = _twin_id(vessel.id)
        if fix is None or vessel.shares_id_of or number in self.ships:
            return
        twin = self.ships[number] = Vessel(number, shares_id_of=vessel.id)
        twin.fix, twin.last_heard_s = fix, fix.time_s

    def shared_ids(self) -> list[str]:
        """The numbers that two ships use."""
        return [v.shares_id_of for v in self.ships.values() if v.shares_id_of in self.ships]

    def rename(self, old: str, new: str) -> bool:
        """Continue a ship under another number; False if it is not known, or is there already."""
        vessel = self.ships.pop(old, None)
        if vessel is None:
            return False
        if new in self.ships:
            self.ships[new].merge(vessel)
            return False
        vessel.id = new
        self.ships[new] = vessel
        return True

    def forget(self, now_s: float) -> None:
        """Drop the ships not received for ``FORGOTTEN_S``."""
        for vessel in self.ships.values():
            vessel.last_heard_s = min(vessel.last_heard_s, now_s)  # by another clock: as of now
        self.ships = {
            number: vessel
            for number, vessel in self.ships.items()
            if now_s - vessel.last_heard_s <= FORGOTTEN_S
        }
        if len(self.ships) < MAX_SHIPS:
            self._reach_m = math.inf

    def nearest(
        self, own: Fix, within_m: float, now_s: float, lost_after_s: float
    ) -> Iterator[Vessel]:
        """The ships within a distance, the nearest first, lost ones after all others."""
        ships = [v for v in self.ships.values() if v.fix is not None]
        distance, time_s = _distances(ships, own)
        lost = now_s - time_s > lost_after_s
        for k in np.lexsort((distance, lost)):
            if distance[k] <= within_m:
                yield ships[k]

    def _keep_nearest(self, own: Fix | None) -> None:
        """Forget all but the nearest; where distances are equal, those heard longest ago."""
        ships = list(self.ships.values())
        distance, _ = _distances(ships, own)
        order = np.lexsort((-np.array([v.last_heard_s for v in ships]), distance))
        for k in order[MAX_SHIPS:]:
            del self.ships[ships[k].id]
        self._reach_m = float(distance[order[MAX_SHIPS - 1]])


def _twin_id(number: str) -> str:
    return f"{number}-2"


def _distance_m(own: Fix | None, latitude_deg: float | None, longitude_deg: float | None) -> float:
    """Roughly how far a position is from own ship [m]; infinite if that is not known."""
    if own is None or latitude_deg is None or longitude_deg is None:
        return math.inf
    return math.hypot(*offset_m(own.latitude_deg, own.longitude_deg, latitude_deg, longitude_deg))


def _distances(ships: list[Vessel], own: Fix | None) -> tuple[np.ndarray, np.ndarray]:
    """The distance [m] of each ship, and when it was there [s since 1970]."""
    rows = [
        (math.nan, math.nan, -math.inf)
        if v.fix is None
        else (v.fix.latitude_deg, v.fix.longitude_deg, v.fix.time_s)
        for v in ships
    ]
    latitude, longitude, time_s = np.array(rows, float).reshape(-1, 3).T
    if own is None:
        return np.full(len(ships), np.inf), time_s
    distance = np.hypot(*offset_m(own.latitude_deg, own.longitude_deg, latitude, longitude))
    return np.nan_to_num(distance, nan=np.inf), time_s
