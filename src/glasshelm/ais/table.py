"""The one table that every AIS source is read into: reports, and what ships say of themselves."""

import dataclasses

import numpy as np
from jaxtyping import Float64, Int64

#: The number under which a file's own ship without an MMSI is kept (CSV rows ``kind=own``).
OWN_SENSORS = 0


@dataclasses.dataclass(frozen=True)
class Particulars:
    """Who a ship is, from static reports."""

    name: str | None = None
    length_m: float | None = None
    beam_m: float | None = None
    kind: str | None = None


@dataclasses.dataclass(frozen=True)
class Reports:
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

    def take(self, which: np.ndarray) -> "Reports":
        """The rows of a mask or of indices."""
        return Reports(*(getattr(self, f.name)[which] for f in dataclasses.fields(self)))


@dataclasses.dataclass(frozen=True)
class Recording:
    """What a file holds: its reports, the ships' particulars, what was passed over in reading."""

    reports: Reports
    ships: dict[int, Particulars]
    notes: tuple[str, ...] = ()


def counted(count: int, what: str) -> tuple[str, ...]:
    """``("3 reports dropped: ...",)``; nothing for a count of zero."""
    return () if count == 0 else (f"{count} {'report' if count == 1 else 'reports'} {what}",)
