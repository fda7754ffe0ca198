"""Which Rule of the COLREGs an encounter falls under, and what was done about it.

A *meeting* is one target from the instant at which risk of collision first
exists until she is past and clear. Its kind is taken at that instant, from bearings and
courses (Rules 13-15), and does not change after it (Rule 13(d)). With a ship that is stopped
when there would be risk there is no meeting. What is
recorded are facts: when, how much and to which side own ship altered, how near the
ships came, on which side they passed. The facts are those that Woerner et al.
(2018, Autonomous Robots, doi 10.1007/s10514-018-9765-y) grade; :mod:`.grades` judges them.
"""

import enum

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from glasshelm.core.geometry import (
    Vector,
    closest_approach,
    direction,
    norm,
    to_body,
    velocity,
)
from glasshelm.encounters.types import Motion
from glasshelm.ship.nomoto import KNOT_M_S, NAUTICAL_MILE_M, ShipState

#: Risk of collision: on present courses and speeds the ships would come this near ...
RISK_DCPA_M = NAUTICAL_MILE_M
#: ... within this time ...
RISK_TCPA_S = 1800.0
#: ... while in sight of one another: the range of a masthead light (Rule 22(a)).
SIGHT_M = 6 * NAUTICAL_MILE_M
#: Slower over ground a ship counts as stopped: Rules 13-15 are for vessels under way, and the
#: course of a ship that does not move says nothing.
STOPPED_M_S = 0.5 * KNOT_M_S
#: More than 22.5 degrees abaft the beam is overtaking (Rule 13(b)).
ABAFT_RAD = float(jnp.radians(112.5))
#: Each ahead of the other within this is meeting end on (Rule 14(b) gives no number).
END_ON_RAD = float(jnp.radians(13.0))
#: A smaller change of course is not an alteration.
ALTERED_RAD = float(jnp.radians(10.0))


class Kind(enum.IntEnum):
    """What own ship is to a target, by Rules 13-15."""

    NONE = 0
    HEAD_ON = 1
    CROSSING_GIVE_WAY = 2
    CROSSING_STAND_ON = 3
    OVERTAKING = 4
    OVERTAKEN = 5


def kind_of(
    bearing_rad: Float[Array, "*n"], aspect_rad: Float[Array, "*n"], own_faster: Bool[Array, "*n"]
) -> Int[Array, "*n"]:
    """The encounter type of two ships at risk of collision.

    ``bearing_rad`` is the target's bearing from own ship's bow, ``aspect_rad``
    own ship's from the target's bow, both in [−π, π]. Where each is abaft the
    other's beam the faster one overtakes.
    """
    from_abaft = jnp.abs(aspect_rad) > ABAFT_RAD  # own ship comes up from abaft the target's beam
    behind = jnp.abs(bearing_rad) > ABAFT_RAD
    end_on = (jnp.abs(bearing_rad) <= END_ON_RAD) & (jnp.abs(aspect_rad) <= END_ON_RAD)
    crossing = jnp.where(bearing_rad > 0, Kind.CROSSING_GIVE_WAY, Kind.CROSSING_STAND_ON)
    kind = jnp.where(end_on, Kind.HEAD_ON, crossing)
    kind = jnp.where(behind & ~(from_abaft & own_faster), Kind.OVERTAKEN, kind)
    overtaking = from_abaft & (~behind | own_faster)
    return jnp.where(overtaking, Kind.OVERTAKING, kind).astype(jnp.int32)


class Meetings(eqx.Module):
    """The facts of a voyage's meetings so far, one a target slot.

    ``kind`` is 0 until there is risk; then ``risk_*`` holds the time, range and
    TCPA of that instant. ``starboard_rad`` and ``port_rad`` are the largest
    alterations to either side until the closest approach is past, ``act_*`` the range and
    TCPA at the first alteration of ten degrees, ``act_side`` its side (1 starboard,
    −1 port, 0 none). ``nearest_m`` is the least range since, ``nearest_bearing_rad`` the
    target's bearing then. ``ahead_m`` is how far ahead of the target's
    middle own ship crossed her course line (negative: astern), 0 if she did not.
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
    def none(cls, slots: int) -> "Meetings":
        """Before the first instant."""
        zero, nothing = jnp.zeros(slots), jnp.zeros(slots, jnp.int32)
        return cls(
            nothing, zero, zero, zero, zero, zero, zero, zero, zero, nothing,
            jnp.zeros(slots, bool), jnp.full(slots, jnp.inf), zero, zero, zero,
        )  # fmt: skip

    def after(
        self,
        own: ShipState,
        own_velocity: Vector,
        turn_rad: Float[Array, ""],
        targets: Motion,
        time_s: Float[Array, ""],
    ) -> "Meetings":
        """With one more instant; ``turn_rad`` is the change of heading since the last one.

        ``own_velocity`` (east, north) is own ship's over ground.
        """
        away = Vector(targets.east_m - own.east_m, targets.north_m - own.north_m)
        range_m = norm(away)
        theirs = velocity(targets.course_rad, targets.speed_m_s)
        cpa = closest_approach(away, Vector(theirs.x - own_velocity.x, theirs.y - own_velocity.y))
        bearing = direction(to_body(away, own.heading_rad))
        from_them = to_body(Vector(-away.x, -away.y), targets.course_rad)
        risk = targets.present & (cpa.dcpa_m < RISK_DCPA_M) & (range_m <= SIGHT_M)
        risk &= (cpa.tcpa_s > 0) & (cpa.tcpa_s <= RISK_TCPA_S)
        risk &= (targets.speed_m_s >= STOPPED_M_S) & (norm(own_velocity) >= STOPPED_M_S)
        kind = kind_of(bearing, direction(from_them), own.speed_m_s > targets.speed_m_s)
        first = (self.kind == Kind.NONE) & risk
        met = targets.present & ((self.kind != Kind.NONE) | first)
        turned = jnp.where(first, 0.0, self.turned_rad + turn_rad)
        open_ = met & ~self.past
        acts = open_ & (self.act_side == 0) & (jnp.abs(turned) >= ALTERED_RAD)
        nearer = met & (range_m < self.nearest_m)
        # Her course line is crossed where own ship changes sides of it, once risk exists.
        crosses = met & ~first & (self.across_m * from_them.x < 0) & (self.ahead_m == 0)
        crosses &= range_m <= SIGHT_M
        return Meetings(
            jnp.where(first, kind, self.kind),
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
