"""What the COLREGs would have had own ship do for one target, where she did otherwise.

The pilot was never taught them. The kind of a meeting is that of the examination
(:mod:`glasshelm.evaluation.colregs`), judged in the frame that is spoken of.
"""

import math

import jax.numpy as jnp

from glasshelm.evaluation.colregs import RISK_DCPA_M, RISK_TCPA_S, SIGHT_M, Kind, kind_of
from glasshelm.figures.series import Series, ShipSeries


def rule_against(voyage: Series, ship: ShipSeries, k: int, way: float) -> str:
    """What a Rule asks for instead of rudder to this side (1 starboard, −1 port); else empty.

    Only while there is risk of collision and the ships are in sight of one another.
    """
    risk = ship.dcpa_m[k] < RISK_DCPA_M and 0 < ship.tcpa_s[k] < RISK_TCPA_S
    if not (risk and ship.range_m[k] < SIGHT_M):
        return ""
    kind = _kind(voyage, ship, k)
    if kind is Kind.HEAD_ON and way < 0:
        return f"Rule 14 asks for starboard: {ship.name} is head-on"
    if kind is Kind.CROSSING_GIVE_WAY and way < 0:
        return f"Rule 15 gives way to {ship.name}, by custom to starboard and round her stern"
    if kind in (Kind.CROSSING_STAND_ON, Kind.OVERTAKEN):
        return f"Rule 17 has own ship stand on: {ship.name} is to give way"
    return ""


def _kind(voyage: Series, ship: ShipSeries, k: int) -> Kind:
    bearing = float(ship.bearing_rad[k])
    back = bearing + float(voyage.heading_rad[k]) + math.pi - float(ship.course_rad[k])
    aspect = (back + math.pi) % (2 * math.pi) - math.pi
    faster = bool(voyage.speed_m_s[k] > ship.speed_m_s[k])
    told = kind_of(jnp.float32(bearing), jnp.float32(aspect), jnp.asarray(faster))
    return Kind(int(told))
