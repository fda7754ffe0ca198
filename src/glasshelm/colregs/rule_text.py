"""What the COLREGs would have had own ship do for one target, where she did otherwise.

The pilot was never taught them. The kind of a meeting is that of the examination
(:mod:`glasshelm.colregs.classification`): that of the meeting where it is known (it is taken at the
first risk, and no later alteration changes it), else judged in the frame that is spoken of.
"""

import math
from collections.abc import Mapping

import jax.numpy as jnp

from glasshelm.colregs.classification import (
    RISK_DCPA_M,
    RISK_TCPA_S,
    STOPPED_M_S,
    VISIBILITY_M,
    EncounterType,
    classify,
)
from glasshelm.frames.series import Series, ShipSeries

#: The kind of each meeting that is known, by the ship's id.
EncounterTypes = Mapping[str, EncounterType]


def conflicting_rule(
    voyage: Series, ship: ShipSeries, k: int, way: float, kinds: EncounterTypes | None = None
) -> str:
    """What a Rule asks for instead of rudder to this side (1 starboard, −1 port); else empty.

    Only while there is risk of collision, both are under way and in sight of one another.
    With ``kinds`` a ship that is not among them is in no meeting.
    """
    risk = ship.dcpa_m[k] < RISK_DCPA_M and 0 < ship.tcpa_s[k] < RISK_TCPA_S
    stopped = min(ship.speed_m_s[k], voyage.speed_m_s[k]) < STOPPED_M_S
    if stopped or not (risk and ship.range_m[k] < VISIBILITY_M):
        return ""
    kind = _kind(voyage, ship, k) if kinds is None else kinds.get(ship.id, EncounterType.NONE)
    if kind is EncounterType.HEAD_ON and way < 0:
        return f"Rule 14 asks for starboard: {ship.name} is head-on"
    if kind is EncounterType.CROSSING_GIVE_WAY and way < 0:
        return f"Rule 15 gives way to {ship.name}, by custom to starboard and round her stern"
    if kind in (EncounterType.CROSSING_STAND_ON, EncounterType.OVERTAKEN):
        return f"Rule 17 has own ship stand on: {ship.name} is to give way"
    return ""


def _kind(voyage: Series, ship: ShipSeries, k: int) -> EncounterType:
    bearing = float(ship.bearing_rad[k])
    back = bearing + float(voyage.heading_rad[k]) + math.pi - float(ship.course_rad[k])
    aspect = (back + math.pi) % (2 * math.pi) - math.pi
    faster = bool(voyage.speed_m_s[k] > ship.speed_m_s[k])
    told = classify(jnp.float32(bearing), jnp.float32(aspect), jnp.asarray(faster))
    return EncounterType(int(told))
