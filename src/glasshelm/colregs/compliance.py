"""What the Rules ask of own ship in each kind of meeting, judged from its facts.

After Woerner et al. (2018): every Rule becomes conditions on the track that can be
checked. Their continuous scores are not used: a rate of meetings can be
counted, given an interval, and looked up one by one.
"""

import math
from collections.abc import Callable, Mapping

import numpy as np
from jaxtyping import Bool

from glasshelm.colregs.classification import ALTERATION_RAD, RISK_DCPA_M, EncounterType
from glasshelm.ship.nomoto import NAUTICAL_MILE_M

#: An alteration "large enough to be readily apparent" (Rule 8(b)).
SUBSTANTIAL_RAD = math.radians(30.0)
#: Early (Rules 8(a), 16): altered while at least this much of the way from first risk to the
#: closest approach, in range, was still left.
EARLY_FRACTION = 0.5
#: The stand-on ship must hold on until she may act herself (Rule 17(a)(ii)): taken as 3 NM.
MAY_ACT_M = 3 * NAUTICAL_MILE_M

Facts = Mapping[str, np.ndarray]
Judged = Bool[np.ndarray, " n"]


def early(facts: Facts) -> Judged:
    """Acted in the first half of the approach."""
    way = facts["risk_range_m"] - facts["nearest_m"]
    left = facts["act_range_m"] - facts["nearest_m"]
    return (facts["act_side"] != 0) & (left >= EARLY_FRACTION * way)


def substantial(facts: Facts) -> Judged:
    """Altered course by 30 degrees or more to one side."""
    return np.maximum(facts["starboard_rad"], facts["port_rad"]) >= SUBSTANTIAL_RAD


def to_starboard(facts: Facts) -> Judged:
    """The first alteration was to starboard."""
    return facts["act_side"] > 0


def not_to_port(facts: Facts) -> Judged:
    """The first alteration, if any, was not to port."""
    return facts["act_side"] >= 0


def port_to_port(facts: Facts) -> Judged:
    """At the closest approach the other ship was on the port side."""
    return facts["nearest_bearing_rad"] < 0


def did_not_cross_ahead(facts: Facts) -> Judged:
    """Did not cross ahead of the other ship."""
    return facts["ahead_m"] <= 0


def passed_clear(facts: Facts) -> Judged:
    """The ships passed at a mile or more: the limit that made them a risk."""
    return facts["nearest_m"] >= RISK_DCPA_M


def stood_on_to_3_nm(facts: Facts) -> Judged:
    """Kept her course to 10 degrees, at least until 3 NM off."""
    return (facts["act_side"] == 0) | (facts["act_range_m"] <= MAY_ACT_M)


def stood_on(facts: Facts) -> Judged:
    """Kept her course to 10 degrees until the closest approach was past."""
    return np.maximum(facts["starboard_rad"], facts["port_rad"]) < ALTERATION_RAD


#: What is judged in each kind of meeting: column of the table -> judgement.
CRITERIA: dict[EncounterType, dict[str, Callable[[Facts], Judged]]] = {
    EncounterType.HEAD_ON: {
        "early": early,
        "substantial": substantial,
        "to starboard (14)": to_starboard,
        "port to port (14)": port_to_port,
        "clear": passed_clear,
    },
    EncounterType.CROSSING_GIVE_WAY: {
        "early": early,
        "substantial": substantial,
        "to starboard (15)": to_starboard,
        "not ahead of her (15)": did_not_cross_ahead,
        "clear": passed_clear,
    },
    EncounterType.CROSSING_STAND_ON: {
        "held to 3 NM (17a)": stood_on_to_3_nm,
        "held on": stood_on,
        "not to port (17c)": not_to_port,
        "clear": passed_clear,
    },
    EncounterType.OVERTAKING: {
        "early": early,
        "substantial": substantial,
        "not ahead of her (13)": did_not_cross_ahead,
        "clear": passed_clear,
    },
    EncounterType.OVERTAKEN: {"held on": stood_on, "clear": passed_clear},
}


def of_type(meetings: Facts, kind: EncounterType, alone: bool = False) -> dict[str, np.ndarray]:
    """The meetings of one kind; ``alone``: only those in voyages with no other meeting."""
    chosen = meetings["kind"] == kind
    if alone:
        chosen &= meetings["meetings_of_voyage"] == 1
    return {name: values[chosen] for name, values in meetings.items()}
