"""Small frames, and alarms as the server of the page has them."""

import dataclasses

from glasshelm.frames.schema import Decision, Frame, Own, Target, Waypoint
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.frame_builder import ship_part


@dataclasses.dataclass(frozen=True)
class Alarm:
    target: str
    name: str
    state: str
    cause: str


def target_of(number, dcpa_m, tcpa_s, lost=False):
    return Target(
        id=number, name=f"MMSI {number}", east_m=0.0, north_m=2000.0, course_rad=3.0,
        speed_m_s=5.0, range_m=2000.0, bearing_rad=0.0, dcpa_m=dcpa_m, tcpa_s=tcpa_s,
        danger=0.0, lost=lost,
    )  # fmt: skip


def frame_of(rudder_rad=None, targets=()):
    return Frame(
        time_s=0.0,
        pilot="straight",
        source="signalk",
        ship=ship_part(SHIPS["paper"]),
        own=Own(0.0, 0.0, 0.0, 5.0, 0.0),
        waypoint=Waypoint(0.0, 1000.0),
        targets=list(targets),
        decision=None if rudder_rad is None else Decision(rudder_rad, applied=False),
    )
