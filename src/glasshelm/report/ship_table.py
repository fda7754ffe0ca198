"""The table of ships: how each began, how near she came, what the pilot made of her."""

import dataclasses
import math

import numpy as np

from glasshelm.core.geometry import CPA_HORIZON_S
from glasshelm.frames.phrases import clock, duration, miles, relative_bearing
from glasshelm.frames.series import Series
from glasshelm.report.passages import Passage, describe
from glasshelm.ship.nomoto import KNOT_M_S


@dataclasses.dataclass(frozen=True)
class Column:
    """A heading, and whether its cells are numbers (set to the right)."""

    heading: str
    number: bool = True


def ship_table(voyage: Series, found: list[Passage]) -> tuple[list[Column], list[list[str]]]:
    """Columns and one row of words a ship; columns that no ship can fill are left out."""
    columns = [
        Column("Ship", number=False),
        Column("Closest", number=False),
        Column("When"),
        Column("In the domain", number=False),
        Column("Largest priority"),
        Column("Mean attention"),
        Column("Course, speed"),
        Column("First seen at", number=False),
        Column("CPA then"),
    ]
    rows = [_row(voyage, p) for p in found]
    kept = [i for i in range(len(columns)) if i == 0 or any(row[i] for row in rows)]
    return [columns[i] for i in kept], [[row[i] for i in kept] for row in rows]


def _row(voyage: Series, passage: Passage) -> list[str]:
    ship, first = passage.ship, passage.first
    heading = round(math.degrees(float(ship.course_rad[first]))) % 360
    speed = float(ship.speed_m_s[first]) / KNOT_M_S
    inside = "no"
    if passage.inside_s > 0:
        inside = f"{duration(passage.inside_s)}, danger {passage.max_danger:.2f}"
    return [
        ship.name,
        describe(passage),
        clock(voyage, passage.closest),
        inside,
        _priority(voyage, passage),
        f"{np.nanmean(ship.attention):.0%}" if ship.has("attention") else "",
        f"{heading:03d}° {speed:.1f} kn",
        f"{miles(float(ship.range_m[first]))} {relative_bearing(float(ship.bearing_rad[first]))}",
        _cpa(float(ship.dcpa_m[first]), float(ship.tcpa_s[first])),
    ]


def _cpa(dcpa_m: float, tcpa_s: float) -> str:
    if tcpa_s >= CPA_HORIZON_S:
        return "not within the hour"
    return "past" if tcpa_s <= 0 else f"{miles(dcpa_m)} in {duration(tcpa_s)}"


def _priority(voyage: Series, passage: Passage) -> str:
    if passage.largest_priority is None:
        return ""
    value = float(passage.ship.priority[passage.largest_priority])
    if value <= 0:
        return "never positive"
    return f"+{value:.3f} ({clock(voyage, passage.largest_priority)})"
