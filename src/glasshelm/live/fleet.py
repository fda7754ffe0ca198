"""The ships that are known: who is who, at most so many, the nearest."""

import math
from collections.abc import Iterator

import numpy as np

from glasshelm.ais.reports import Report
from glasshelm.ais.vessel import Fix, Vessel, way_m
from glasshelm.encounters.recorded_traffic import LOST_AFTER_S
from glasshelm.ship.nomoto import NAUTICAL_MILE_M
from glasshelm.simulation.voyage import LOST_SHOWN_S

#: A ship not heard for so long [s] is forgotten: lost, shown as lost for a while, and a minute.
FORGOTTEN_S = LOST_AFTER_S + LOST_SHOWN_S + 60.0
#: Ships kept at most. A tenth more may be known for a moment; then the farthest are forgotten.
MOST_SHIPS = 10_000


class Fleet:
    """Ships by number. When there are too many, a far one never takes the place of a near one."""

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

    def of(self, r: Report) -> Vessel | None:
        """The ship of a report. Of two ships with one number: the one on whose track it lies."""
        first, second = self.ships.get(r.id), self.ships.get(_second(r.id))
        if second is None:
            return first
        if first is None:
            return second
        if r.latitude_deg is None or r.longitude_deg is None:
            return max(first, second, key=lambda v: v.heard_s)
        if first.fix is None or second.fix is None:
            return first
        here = Fix(0.0, r.latitude_deg, r.longitude_deg)
        to_first, to_second = (math.hypot(*way_m(fix, here)) for fix in (first.fix, second.fix))
        return first if to_first <= to_second else second

    def away_m(self, r: Report, own: Fix | None) -> float:
        """Roughly how far from own ship a report is, or else the ship it is about [m]."""
        if r.latitude_deg is not None or r.id not in self.ships:
            return _away_m(own, r.latitude_deg, r.longitude_deg)
        fix = self.ships[r.id].fix
        return math.inf if fix is None else _away_m(own, fix.latitude_deg, fix.longitude_deg)

    def add(self, r: Report, own: Fix | None) -> Vessel | None:
        """A ship not known before; None if there are too many nearer ones."""
        if len(self.ships) >= MOST_SHIPS + MOST_SHIPS // 10:
            self._keep_nearest(own)
        far = _away_m(own, r.latitude_deg, r.longitude_deg) >= self._reach_m
        if far and self._reach_m < math.inf:
            return None
        vessel = self.ships[r.id] = Vessel(r.id)
        return vessel

    def split(self, vessel: Vessel) -> None:
        """Make a ship of her own of whoever uses a ship's number elsewhere."""
        fix, vessel.other = vessel.other, None
        number = _second(vessel.id)
        if fix is None or vessel.second_of or number in self.ships:
            return
        second = self.ships[number] = Vessel(number, second_of=vessel.id)
        second.fix, second.heard_s = fix, fix.time_s

    def shared(self) -> list[str]:
        """The numbers that two ships use."""
        return [v.second_of for v in self.ships.values() if v.second_of in self.ships]

    def rename(self, old: str, number: str) -> bool:
        """Let a ship go on under another number; False if she is not known, or is there already."""
        vessel = self.ships.pop(old, None)
        if vessel is None:
            return False
        there = self.ships.get(number)
        if there is not None:
            there.join(vessel)
            return False
        vessel.id = number
        self.ships[number] = vessel
        return True

    def forget(self, now_s: float) -> None:
        """Drop the ships not heard for ``FORGOTTEN_S``."""
        old = []
        for vessel in self.ships.values():
            vessel.heard_s = min(vessel.heard_s, now_s)  # dated by another clock: as of now
            if now_s - vessel.heard_s > FORGOTTEN_S:
                old.append(vessel.id)
        for number in old:
            del self.ships[number]
        if len(self.ships) < MOST_SHIPS:
            self._reach_m = math.inf

    def nearest(
        self, own: Fix, within_m: float, now_s: float, lost_after_s: float
    ) -> Iterator[Vessel]:
        """The ships within a distance, the nearest first, those lost after all others."""
        ships = [v for v in self.ships.values() if v.fix is not None]
        away, time_s = _distances(ships, own)
        lost = now_s - time_s > lost_after_s
        for k in np.lexsort((away, lost)):
            if away[k] <= within_m:
                yield ships[k]

    def _keep_nearest(self, own: Fix | None) -> None:
        """Forget all but the nearest; where that tells no difference, those heard longest ago."""
        ships = list(self.ships.values())
        away, _ = _distances(ships, own)
        order = np.lexsort((-np.array([v.heard_s for v in ships]), away))
        for k in order[MOST_SHIPS:]:
            del self.ships[ships[k].id]
        self._reach_m = float(away[order[MOST_SHIPS - 1]])


def _second(number: str) -> str:
    return f"{number}-2"


def _away_m(own: Fix | None, latitude_deg: float | None, longitude_deg: float | None) -> float:
    """Roughly how far a place is from own ship [m]; infinitely, if that is not known."""
    if own is None or latitude_deg is None or longitude_deg is None:
        return math.inf
    turn = (longitude_deg - own.longitude_deg + 180.0) % 360.0 - 180.0
    east = turn * math.cos(math.radians(own.latitude_deg))
    return 60 * NAUTICAL_MILE_M * math.hypot(east, latitude_deg - own.latitude_deg)


def _distances(ships: list[Vessel], own: Fix | None) -> tuple[np.ndarray, np.ndarray]:
    """Of each ship: ``_away_m`` and when she was there [s since 1970]."""
    rows = [
        (math.inf, math.inf, -math.inf)
        if v.fix is None
        else (v.fix.latitude_deg, v.fix.longitude_deg, v.fix.time_s)
        for v in ships
    ]
    latitude, longitude, time_s = np.array(rows, float).reshape(-1, 3).T
    if own is None:
        return np.full(len(ships), np.inf), time_s
    with np.errstate(invalid="ignore"):
        turn = (longitude - own.longitude_deg + 180.0) % 360.0 - 180.0
        east = turn * math.cos(math.radians(own.latitude_deg))
        away = 60 * NAUTICAL_MILE_M * np.hypot(east, latitude - own.latitude_deg)
    return np.where(np.isnan(away), np.inf, away), time_s
