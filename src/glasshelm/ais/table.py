"""The one table that every AIS source is read into: position reports and static data."""

import dataclasses
from collections.abc import Callable, Iterable
from typing import TypeAlias

import numpy as np
from jaxtyping import Float64, Int64

from glasshelm.ais.reports import Report

#: Names are cut to so many characters (AIS has 20).
MAX_NAME_LENGTH = 64

#: The number under which a file's own ship without an MMSI is kept (CSV rows ``kind=own``). No file
#: can name it: identities are 1 to 999,999,999.
OWN_SENSORS = -1
#: The number of a base station, an aid to navigation or an aircraft that a file says is one.
NOT_A_SHIP = 0


@dataclasses.dataclass(frozen=True)
class StaticData:
    """Who a ship is, from its static reports."""

    name: str | None = None
    length_m: float | None = None
    beam_m: float | None = None
    ship_type: str | None = None

    @staticmethod
    def of(r: Report) -> "StaticData":
        """The static data of a report."""
        name, ship_type = (text and text[:MAX_NAME_LENGTH] for text in (r.name, r.ship_type))
        return StaticData(name, r.length_m, r.beam_m, ship_type)

    def updated_by(self, later: "StaticData") -> "StaticData":
        """These data, overruled by those of a later report."""
        return StaticData(
            later.name or self.name,
            later.length_m or self.length_m,
            later.beam_m or self.beam_m,
            later.ship_type or self.ship_type,
        )


@dataclasses.dataclass(frozen=True)
class ReportTable:
    """Position reports as columns, on the host. Units of AIS: degrees, knots, seconds of UTC.

    A speed, course or heading that a report does not give is NaN. ``time_s`` counts from 1970.
    """

    time_s: Float64[np.ndarray, " n"]
    mmsi: Int64[np.ndarray, " n"]
    latitude_deg: Float64[np.ndarray, " n"]
    longitude_deg: Float64[np.ndarray, " n"]
    sog_kn: Float64[np.ndarray, " n"]
    cog_deg: Float64[np.ndarray, " n"]
    heading_deg: Float64[np.ndarray, " n"]

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def columns(self) -> tuple[np.ndarray, ...]:
        """The columns in the order of the fields."""
        return tuple(getattr(self, field.name) for field in dataclasses.fields(self))

    def take(self, which: np.ndarray | slice) -> "ReportTable":
        """The rows of a mask, of indices or of a slice."""
        return ReportTable(*(column[which] for column in self.columns))

    @staticmethod
    def concat(parts: "Iterable[ReportTable]") -> "ReportTable":
        """The rows of tables, one after another."""
        empty = ReportTable(np.zeros(0), np.zeros(0, np.int64), *np.zeros((5, 0)))
        columns = zip(*(part.columns for part in (empty, *parts)), strict=True)
        return ReportTable(*map(np.concatenate, columns))


#: Which reports to keep: a mask of the rows of a table.
Wanted: TypeAlias = Callable[[ReportTable], np.ndarray]


@dataclasses.dataclass(frozen=True)
class Recording:
    """What a file holds: its reports, the ships' static data, notes on what was left out."""

    reports: ReportTable
    ships: dict[int, StaticData]
    notes: tuple[str, ...] = ()

    def select(self, wanted: Wanted) -> "Recording":
        """The reports that are wanted."""
        return dataclasses.replace(self, reports=self.reports.take(wanted(self.reports)))

    @staticmethod
    def concat(parts: "Iterable[Recording]", notes: Iterable[str] = ()) -> "Recording":
        """Parts of a file as one recording; later static data overrule earlier ones."""
        tables, ships = [], dict[int, StaticData]()
        for part in parts:
            tables.append(part.reports)
            for mmsi, static in part.ships.items():
                ships[mmsi] = ships.get(mmsi, StaticData()).updated_by(static)
        return Recording(ReportTable.concat(tables), ships, tuple(notes))


def count_note(count: int, what: str) -> tuple[str, ...]:
    """``("3 reports dropped: ...",)``; nothing for a count of zero."""
    return () if count == 0 else (f"{count} {'report' if count == 1 else 'reports'} {what}",)
