"""What own ship did in each encounter, and whether that complied with the Rules.

A *meeting* is the encounter with one target from the first risk of collision until it is past
and clear. Its type is taken at that first instant and does not change (Rule 13(d)).
:class:`MeetingFacts` records what happened: when, how far and to which side own ship altered,
how near the ships came and on which side they passed. :data:`CRITERIA` judges the facts.

Facts and criteria follow Woerner et al. (2018, Autonomous Robots, doi
10.1007/s10514-018-9765-y). Their continuous scores are not used: a rate of meetings can be
counted, given an interval, and looked up one by one.
"""

import math
from collections.abc import Callable, Mapping

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from glasshelm.colregs.classification import (
    RISK_DCPA_M,
    VISIBILITY_M,
    EncounterType,
    classify,
    risk_of_collision,
)
from glasshelm.core.geometry import Vector, closest_approach, direction, norm, to_body, velocity
from glasshelm.encounters.types import Motion
from glasshelm.ship.nomoto import NAUTICAL_MILE_M, ShipState

#: A smaller change of course is not an alteration.
ALTERATION_RAD = math.radians(10.0)
#: An alteration "large enough to be readily apparent" (Rule 8(b)).
SUBSTANTIAL_RAD = math.radians(30.0)
#: Early (Rules 8(a), 16): altered while at least this much of the way from first risk to the
#: closest approach, in range, was still left.
EARLY_FRACTION = 0.5
#: The stand-on ship must hold on until it may act itself (Rule 17(a)(ii)): taken as 3 NM.
MAY_ACT_M = 3 * NAUTICAL_MILE_M


class MeetingFacts(eqx.Module):
    """The facts of a voyage's meetings so far, one a target slot.

    ``kind`` is 0 until there is risk; then ``risk_*`` holds the time, range and
    TCPA of that instant. ``starboard_rad`` and ``port_rad`` are the largest
    alterations to either side until the closest approach is past, ``act_*`` the range and
    TCPA at the first alteration of ten degrees, ``act_side`` its side (1 starboard,
    −1 port, 0 none). ``nearest_m`` is the least range since, ``nearest_bearing_rad`` the
    target's bearing then. ``ahead_m`` is how far ahead of the target's
    middle own ship crossed its course line (negative: astern), 0 if it did not.
    """

    kind: Int[Array, "*n"]
    risk_time_s: Float[Array, "*n"]
    risk_range_m: Float[Array, "*n"]
    risk_tcpa_s: Float[Array, "*n"]
    turned_rad: Float[Array, "*n"]
    starboard_rad: Float[Array, "*n"]
    port_rad: Float[Array, "*n"]
    act_range_m: Float[Array, "*n"]
    act_tcpa_s: Float[Array, "*n"]
    act_side: Int[Array, "*n"]
    past: Bool[Array, "*n"]
    nearest_m: Float[Array, "*n"]
    nearest_bearing_rad: Float[Array, "*n"]
    across_m: Float[Array, "*n"]
    ahead_m: Float[Array, "*n"]

    @classmethod
    def initial(cls, slots: int) -> "MeetingFacts":
        """Before the first instant."""
        zero, nothing = jnp.zeros(slots), jnp.zeros(slots, jnp.int32)
        return cls(
            nothing, zero, zero, zero, zero, zero, zero, zero, zero, nothing,
            jnp.zeros(slots, bool), jnp.full(slots, jnp.inf), zero, zero, zero,
        )  # fmt: skip

    def updated(
        self,
        own: ShipState,
        own_velocity: Vector,
        turn_rad: Float[Array, ""],
        targets: Motion,
        time_s: Float[Array, ""],
    ) -> "MeetingFacts":
        """With one more instant; ``turn_rad`` is the change of heading since the last one.

        ``own_velocity`` (east, north) is own ship's over ground.
        """
        away = Vector(targets.east_m - own.east_m, targets.north_m - own.north_m)
        range_m = norm(away)
        theirs = velocity(targets.course_rad, targets.speed_m_s)
        cpa = closest_approach(away, Vector(theirs.x - own_velocity.x, theirs.y - own_velocity.y))
        bearing = direction(to_body(away, own.heading_rad))
        from_them = to_body(Vector(-away.x, -away.y), targets.course_rad)
        risk = targets.present & risk_of_collision(
            cpa.dcpa_m, cpa.tcpa_s, range_m, norm(own_velocity), targets.speed_m_s
        )
        types = classify(bearing, direction(from_them), own.speed_m_s > targets.speed_m_s)
        first = (self.kind == EncounterType.NONE) & risk
        met = targets.present & ((self.kind != EncounterType.NONE) | first)
        turned = jnp.where(first, 0.0, self.turned_rad + turn_rad)
        open_ = met & ~self.past
        acts = open_ & (self.act_side == 0) & (jnp.abs(turned) >= ALTERATION_RAD)
        nearer = met & (range_m < self.nearest_m)
        # Its course line is crossed where own ship changes sides of it, once risk exists.
        crosses = met & ~first & (self.across_m * from_them.x < 0) & (self.ahead_m == 0)
        crosses &= range_m <= VISIBILITY_M
        return MeetingFacts(
            jnp.where(first, types, self.kind),
            jnp.where(first, time_s, self.risk_time_s),
            jnp.where(first, range_m, self.risk_range_m),
            jnp.where(first, cpa.tcpa_s, self.risk_tcpa_s),
            turned,
            jnp.where(open_, jnp.maximum(self.starboard_rad, turned), self.starboard_rad),
            jnp.where(open_, jnp.maximum(self.port_rad, -turned), self.port_rad),
            jnp.where(acts, range_m, self.act_range_m),
            jnp.where(acts, cpa.tcpa_s, self.act_tcpa_s),
            jnp.where(acts, jnp.sign(turned), self.act_side).astype(jnp.int32),
            self.past | (met & (cpa.tcpa_s <= 0)),
            jnp.where(nearer, range_m, self.nearest_m),
            jnp.where(nearer, bearing, self.nearest_bearing_rad),
            from_them.x,
            jnp.where(crosses, from_them.y, self.ahead_m),
        )


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
    """Kept its course to 10 degrees, at least until 3 NM off."""
    return (facts["act_side"] == 0) | (facts["act_range_m"] <= MAY_ACT_M)


def stood_on(facts: Facts) -> Judged:
    """Kept its course to 10 degrees until the closest approach was past."""
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
