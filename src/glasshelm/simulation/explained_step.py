"""One instant of a voyage, from one compiled program: what is, what is decided, and why."""

from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from glasshelm.core.geometry import (
    Cpa,
    Vector,
    closest_approach,
    direction,
    norm,
    to_body,
    velocity,
)
from glasshelm.encounters.types import Encounter, Motion
from glasshelm.env.observe import Observation
from glasshelm.env.step import EnvSettings, EnvState, targets_at, waypoint_of
from glasshelm.env.target_selection import select_targets
from glasshelm.explain.step_explanation import Explanation, explain
from glasshelm.pilots.guarded import GuardedPilot, learned_in
from glasshelm.pilots.protocols import Memory, Pilot
from glasshelm.planning.lookahead import Lookahead
from glasshelm.ship.domain import danger
from glasshelm.ship.nomoto import ShipParams, ShipState


class LastKnownTargets(eqx.Module):
    """Each target as she was last there, and when; ``motion.present`` false: never yet."""

    motion: Motion
    time_s: Float[Array, " n"]


class Traffic(eqx.Module):
    """The targets as a frame shows them: those present, and lost ones where they last were.

    ``motion.age_s`` is the time since each was last heard. Range, relative
    bearing, CPA and danger (Eq. 13) are of the place shown.
    """

    motion: Motion
    lost: Bool[Array, " n"]
    range_m: Float[Array, " n"]
    bearing_rad: Float[Array, " n"]
    cpa: Cpa
    danger: Float[Array, " n"]


class GuardStatus(eqx.Module):
    """Of a guarded pilot: whether the guard has the helm, and where its own way leads from here."""

    steers: Bool[Array, ""]
    ahead: Lookahead


class ExplainedStep(eqx.Module):
    """All of one instant. Slot k of ``fed`` and ``explanation`` shows target ``order[k]``.

    ``action`` is what is steered, ``own_action`` what the pilot itself decides; ``his_own`` says
    that it has the helm, and not an order or its guard.
    """

    own: ShipState
    waypoint: Vector
    traffic: Traffic
    fed: Observation
    order: Int[Array, " k"]
    action: Float[Array, ""]
    own_action: Float[Array, ""]
    his_own: Bool[Array, ""]
    explanation: Explanation | None
    guarding: GuardStatus | None


class RudderOverride(eqx.Module):
    """A rudder (a fraction of the limit) put in the pilot's place while the order ``holds``."""

    action: Float[Array, ""]
    holds: Bool[Array, ""]


def no_known_targets(encounter: Encounter) -> LastKnownTargets:
    """Before the first moment nobody was ever there."""
    motion = targets_at(encounter, jnp.zeros(()))
    nobody = jnp.zeros_like(motion.present)
    return LastKnownTargets(
        eqx.tree_at(lambda m: m.present, motion, nobody), jnp.zeros_like(motion.age_s)
    )


def explain_step(
    pilot: Pilot,
    encounter: Encounter,
    state: EnvState,
    held: LastKnownTargets,
    memory: Memory,
    ship: ShipParams,
    settings: EnvSettings,
    lost_shown_s: float,
    ordered: RudderOverride | None = None,
    explained: bool = True,
) -> tuple[ExplainedStep, LastKnownTargets, Any]:
    """The moment of a state, with what to carry to the next one. Pure and traceable.

    While an order holds, its rudder is the one that is steered and explained;
    the pilot is asked all the same, for what it remembers.
    """
    time = state.step * settings.step_s
    traffic, held = _traffic(encounter, state.own, held, time, ship, lost_shown_s)
    fed, order = select_targets(state.observation, loa_m=jnp.asarray(ship.loa_m))
    action, memory = pilot.steer(fed, memory)
    ordering = jnp.zeros((), bool) if ordered is None else ordered.holds
    own_action, his_own, guarding = action, ~ordering, None
    if isinstance(pilot, GuardedPilot):
        own_action = jnp.where(memory.engaged, pilot.pilot.actor(fed), action)
        his_own = ~(memory.engaged | ordering)
        if explained:
            guarding = GuardStatus(memory.engaged & ~ordering, pilot.ahead(fed))
    if ordered is not None:
        action = jnp.where(ordered.holds, ordered.action, action)
    why, learned = None, learned_in(pilot)
    if explained and learned is not None:
        why = explain(learned.actor, learned.critic, fed, action)
    waypoint = waypoint_of(encounter, state.leg)
    decided = (action, own_action, his_own, why, guarding)
    return ExplainedStep(state.own, waypoint, traffic, fed, order, *decided), held, memory


def _traffic(
    encounter: Encounter,
    own: ShipState,
    held: LastKnownTargets,
    time_s: Float[Array, ""],
    ship: ShipParams,
    lost_shown_s: float,
) -> tuple[Traffic, LastKnownTargets]:
    now = targets_at(encounter, time_s)
    here = now.present
    last = held.motion
    gone_s = time_s - held.time_s
    lost = last.present & ~here & (gone_s <= lost_shown_s)
    shown = Motion(
        jnp.where(here, now.east_m, last.east_m),
        jnp.where(here, now.north_m, last.north_m),
        jnp.where(here, now.course_rad, last.course_rad),
        jnp.where(here, now.speed_m_s, last.speed_m_s),
        jnp.where(here, now.age_s, last.age_s + gone_s),
        here | lost,
    )
    # Held ships keep the age that they had when last there: time goes on in gone_s.
    kept = Motion(
        shown.east_m,
        shown.north_m,
        shown.course_rad,
        shown.speed_m_s,
        jnp.where(here, now.age_s, last.age_s),
        here | last.present,
    )
    offset = to_body(
        Vector(shown.east_m - own.east_m, shown.north_m - own.north_m), own.heading_rad
    )
    own_v = velocity(own.heading_rad, own.speed_m_s)
    target_v = velocity(shown.course_rad, shown.speed_m_s)
    relative_v = to_body(Vector(target_v.x - own_v.x, target_v.y - own_v.y), own.heading_rad)
    traffic = Traffic(
        shown,
        lost,
        norm(offset),
        direction(offset),
        closest_approach(offset, relative_v),
        danger(offset, ship.loa_m),
    )
    return traffic, LastKnownTargets(kept, jnp.where(here, time_s, held.time_s))
