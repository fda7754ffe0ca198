"""One step of a voyage, from one compiled program: what is there, what is decided, and why."""

import dataclasses
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from glasshelm.core.geometry import Cpa, Vector, closest_approach, direction, norm
from glasshelm.encounters.types import Encounter, Motion
from glasshelm.env.observe import Observation, relative_motion
from glasshelm.env.step import EnvSettings, EnvState, targets_at, waypoint_of
from glasshelm.pilots.decide import decide_on
from glasshelm.pilots.protocols import Decision, Memory, Pilot, override
from glasshelm.ship.domain import danger
from glasshelm.ship.nomoto import ShipParams, ShipState


class LastKnownTargets(eqx.Module):
    """Each target as it was when last there, and when; ``motion.present`` false: never yet."""

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


class ExplainedStep(eqx.Module):
    """All of one instant.

    Slot k of ``observation`` and of the decision's explanation shows target ``slots[k]``.
    """

    own: ShipState
    waypoint: Vector
    traffic: Traffic
    observation: Observation
    slots: Int[Array, " k"]
    decision: Decision


class RudderOverride(eqx.Module):
    """A rudder (a fraction of the limit) put in the pilot's place while ``active``."""

    rudder: Float[Array, ""]
    active: Bool[Array, ""]


def no_known_targets(encounter: Encounter) -> LastKnownTargets:
    """Before the first step no target was ever there."""
    motion = targets_at(encounter, jnp.zeros(()))
    nobody = jnp.zeros_like(motion.present)
    return LastKnownTargets(
        eqx.tree_at(lambda m: m.present, motion, nobody), jnp.zeros_like(motion.age_s)
    )


def explain_step(
    pilot: Pilot,
    encounter: Encounter,
    state: EnvState,
    known: LastKnownTargets,
    memory: Memory,
    ship: ShipParams,
    settings: EnvSettings,
    lost_shown_s: float,
    ordered: RudderOverride | None = None,
) -> tuple[ExplainedStep, LastKnownTargets, Any]:
    """The step of a state, with what to carry to the next one. Pure and traceable.

    While an order is active, its rudder is the one that is steered and explained;
    the pilot is asked all the same, for what it remembers.
    """
    time = state.step * settings.step_s
    traffic, known = _traffic(encounter, state.own, known, time, ship, lost_shown_s)
    decision, memory, selection = decide_on(pilot, state.observation, memory, ship)
    if ordered is not None:
        decision = override(pilot, selection.observation, decision, ordered.rudder, ordered.active)
    step = ExplainedStep(
        state.own,
        waypoint_of(encounter, state.leg),
        traffic,
        selection.observation,
        selection.slots,
        decision,
    )
    return step, known, memory


def _traffic(
    encounter: Encounter,
    own: ShipState,
    known: LastKnownTargets,
    time_s: Float[Array, ""],
    ship: ShipParams,
    lost_shown_s: float,
) -> tuple[Traffic, LastKnownTargets]:
    now, last = targets_at(encounter, time_s), known.motion
    here, gone_s = now.present, time_s - known.time_s
    lost = last.present & ~here & (gone_s <= lost_shown_s)
    latest = jax.tree.map(lambda new, old: jnp.where(here, new, old), now, last)
    # Known targets keep the age that they had when last there: time goes on in gone_s.
    age_s = jnp.where(here, now.age_s, last.age_s + gone_s)
    shown = dataclasses.replace(latest, age_s=age_s, present=here | lost)
    kept = dataclasses.replace(latest, present=here | last.present)
    position, velocity = relative_motion(own, shown)
    traffic = Traffic(
        shown,
        lost,
        norm(position),
        direction(position),
        closest_approach(position, velocity),
        danger(position, ship.loa_m),
    )
    return traffic, LastKnownTargets(kept, jnp.where(here, time_s, known.time_s))
