"""The one table that every AIS source is read into: reports, and what ships say of themselves."""

import dataclasses
from collections.abc import Iterable, Sequence

import numpy as np
from jaxtyping import Float64, Int64

#: The number under which a file's own ship without an MMSI is kept (CSV rows ``kind=own``). No file
#: can name it: identities are 1 to 999,999,999.
OWN_SENSORS = -1
#: The number of a base station, an aid to navigation or an aircraft that a file says is one.
NOT_A_SHIP = 0


@dataclasses.dataclass(frozen=True)
class StaticData:
    """Who a ship is, from static reports."""

    name: str | None = None
    length_m: float | None = None
    beam_m: float | None = None
    ship_type: str | None = None

    def updated_by(self, later: "StaticData") -> "StaticData":
        """What was said first, overruled by what was said later."""
        return StaticData(
            later.name or self.name,
            later.length_m or self.length_m,
            later.beam_m or self.beam_m,
            later.ship_type or self.ship_type,
        )


@dataclasses.dataclass(frozen=True)
class ReportTable:
    """Position reports as columns, on the host. Units of AIS: degrees, knots, seconds of UTC.

    A speed, course or heading that a report does not give is NaN; tracks made
    from the table (``recorded``) have none. ``time_s`` counts from 1970.
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

    def take(self, which: np.ndarray | slice) -> "ReportTable":
        """The rows of a mask, of indices or of a slice."""
        return ReportTable(*(getattr(self, f.name)[which] for f in dataclasses.fields(self)))

    @staticmethod
    def concat(parts: "Sequence[ReportTable]") -> "ReportTable":
        """The rows of tables, one after another."""
        empty = ReportTable(np.zeros(0), np.zeros(0, np.int64), *(np.zeros(0) for _ in range(5)))
        columns = [f.name for f in dataclasses.fields(ReportTable)]
        return ReportTable(
            *(np.concatenate([getattr(part, c) for part in (empty, *parts)]) for c in columns)
        )


@dataclasses.dataclass(frozen=True)
class Recording:
    """What a file holds: its reports, the ships' particulars, what was passed over in reading."""

    reports: ReportTable
    ships: dict[int, StaticData]
    notes: tuple[str, ...] = ()

    @staticmethod
    def concat(parts: "Sequence[Recording]", notes: Iterable[str] = ()) -> "Recording":
        """Parts of a file as one recording; later particulars overrule earlier ones."""
        ships: dict[int, StaticData] = {}
        for part in parts:
            for mmsi, said in part.ships.items():
                known = ships.get(mmsi)
                ships[mmsi] = said if known is None else known.updated_by(said)
        return Recording(ReportTable.concat([part.reports for part in parts]), ships, tuple(notes))


def count_note(count: int, what: str) -> tuple[str, ...]:
    """``("3 reports dropped: ...",)``; nothing for a count of zero."""
    return () if count == 0 else (f"{count} {'report' if count == 1 else 'reports'} {what}",)
