"""Frames made by hand for the bridge: one target, whose motion the test chooses."""

import dataclasses
import math

from glasshelm.frames import schema as f
from glasshelm.frames.schema import Frame
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.frame_builder import ship_part

SPEED_M_S = 5.0


@dataclasses.dataclass(frozen=True)
class Other:
    """A target that is at (east, north) at time 0 and keeps course and speed."""

    id: str = "1"
    east_m: float = 0.0
    north_m: float = 6000.0
    course_deg: float = 180.0
    speed_m_s: float = SPEED_M_S
    lost: bool = False
    selected: bool = True


def frame(time_s: float, *others: Other, heading_deg: float = 0.0, **fields) -> Frame:
    """Own ship northward from the origin at 5 m/s, whatever her heading is said to be."""
    time_s, heading = float(time_s), math.radians(heading_deg)
    own = f.Own(0.0, SPEED_M_S * time_s, heading, SPEED_M_S, 0.0, 0.0)
    targets = [_target(time_s, own, other) for other in others]
    ship = ship_part(SHIPS["paper"])
    given = {"decision": f.Decision(0.0)} | fields
    return Frame(time_s, "made", "made", ship, own, f.Waypoint(0.0, 40_000.0), targets, **given)


def _target(time_s: float, own: f.Own, other: Other) -> f.Target:
    course = math.radians(other.course_deg)
    ve, vn = other.speed_m_s * math.sin(course), other.speed_m_s * math.cos(course)
    east, north = other.east_m + ve * time_s, other.north_m + vn * time_s
    de, dn = east - own.east_m, north - own.north_m
    re, rn = ve, vn - SPEED_M_S
    square = re**2 + rn**2
    tcpa = -(de * re + dn * rn) / square if square else 0.0
    bearing = math.atan2(de, dn) - own.heading_rad
    return f.Target(
        id=other.id,
        name=f"ship {other.id}",
        east_m=east,
        north_m=north,
        course_rad=course,
        speed_m_s=other.speed_m_s,
        range_m=math.hypot(de, dn),
        bearing_rad=(bearing + math.pi) % (2 * math.pi) - math.pi,
        dcpa_m=math.hypot(de + tcpa * re, dn + tcpa * rn),
        tcpa_s=tcpa,
        danger=0.0,
        lost=other.lost,
        selected=other.selected,
    )
