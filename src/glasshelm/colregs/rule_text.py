"""The Rules in words: the role that an encounter type gives, and what a Rule asks for.

Pilots were never taught the Rules. The text names the Rule where a pilot does otherwise.
"""

import math
from collections.abc import Mapping
from typing import Literal, NamedTuple

import jax.numpy as jnp

from glasshelm.colregs.classification import (
    EncounterType,
    classify,
    risk_of_collision,
    stands_on,
)
from glasshelm.core.geometry import wrap_angle
from glasshelm.frames.series import Series, ShipSeries

#: The encounter type of each target, by its id.
EncounterTypes = Mapping[str, EncounterType]


class Role(NamedTuple):
    """An encounter type in words. Rules 13-15 name the encounter; a stand-on ship obeys Rule 17."""

    type: Literal["head-on", "crossing", "overtaking", "overtaken", "none"]
    role: Literal["give-way", "stand-on", "none"]
    rule: str | None


ROLES = {
    EncounterType.NONE: Role("none", "none", None),
    EncounterType.HEAD_ON: Role("head-on", "give-way", "14"),
    EncounterType.CROSSING_GIVE_WAY: Role("crossing", "give-way", "15"),
    EncounterType.CROSSING_STAND_ON: Role("crossing", "stand-on", "17"),
    EncounterType.OVERTAKING: Role("overtaking", "give-way", "13"),
    EncounterType.OVERTAKEN: Role("overtaken", "stand-on", "17"),
}


def conflicting_rule(
    voyage: Series, ship: ShipSeries, k: int, side: float, types: EncounterTypes | None = None
) -> str:
    """What a Rule asks for instead of rudder to one side.

    Args:
        voyage: The voyage, with own ship's track.
        ship: The target.
        k: The frame.
        side: 1 for rudder to starboard, -1 for port.
        types: The encounter types where they are known, taken at first risk; a target that is
            not among them has none. Without it the type is judged in this frame.

    Returns:
        A clause, empty where no Rule asks for anything else or there is no risk of collision.
    """
    risk = risk_of_collision(
        ship.dcpa_m[k],
        ship.tcpa_s[k],
        ship.range_m[k],
        voyage.speed_m_s[k],
        ship.speed_m_s[k],
    )
    if not risk:
        return ""
    kind = _type(voyage, ship, k) if types is None else types.get(ship.id, EncounterType.NONE)
    if kind is EncounterType.HEAD_ON and side < 0:
        return f"Rule 14 asks for starboard: {ship.name} is head-on"
    if kind is EncounterType.CROSSING_GIVE_WAY and side < 0:
        return f"Rule 15 gives way to {ship.name}, by custom to starboard and round her stern"
    if stands_on(kind):
        return f"Rule 17 has own ship stand on: {ship.name} is to give way"
    return ""


def _type(voyage: Series, ship: ShipSeries, k: int) -> EncounterType:
    bearing = jnp.float32(ship.bearing_rad[k])
    back = jnp.float32(bearing + voyage.heading_rad[k] + math.pi - ship.course_rad[k])
    faster = bool(voyage.speed_m_s[k] > ship.speed_m_s[k])
    return EncounterType(int(classify(bearing, wrap_angle(back), faster)))
