"""The CPA rule: what a navigator does with two numbers of the radar and Rules 13 to 17.

A ship that own ship would pass nearer than a limit, and sooner than another, is
a risk. For a risk that own ship has to give way to, she alters to starboard by
the smallest step that clears everybody; one that must give way to her is left
alone until the last moment. The alteration is held until the way to the
waypoint is clear by a wider limit (Cockcroft & Lameijer, *A Guide to the
Collision Avoidance Rules*).
"""

import dataclasses
from collections.abc import Callable

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from glasshelm.colregs.classification import EncounterType, classify_targets, stands_on
from glasshelm.core.geometry import Cpa
from glasshelm.env.observe import Observation
from glasshelm.pilots.course_pilot import CourseMethod
from glasshelm.planning.situation import situation_of
from glasshelm.planning.trial_manoeuvre import cpa_on
from glasshelm.ship.nomoto import ShipParams


@dataclasses.dataclass(frozen=True)
class CpaSettings:
    """Limits and steps. Tuned: docs/explanation/classical-pilots.md."""

    #: Nearer is a risk: 1.2 NM (the domain reaches 1.17 NM ahead; a mile is usual at sea).
    dcpa_m: float = 2230.0
    #: Sooner is a risk.
    tcpa_s: float = 2100.0
    #: A ship that must keep clear is left alone until then (Rule 17 a ii).
    last_moment_s: float = 1000.0
    #: An alteration is held until the way is clear by so many times ``dcpa_m``.
    hysteresis: float = 1.15
    #: "Large enough to be readily apparent" (Rule 8 b).
    alterations_deg: tuple[float, ...] = (30.0, 45.0, 60.0, 75.0, 90.0, 120.0)
    #: Port costs as much as so many degrees more to starboard.
    port_deg: float = 150.0


def cpa_course(
    observation: Observation, offset_rad: Float[Array, ""], ship: ShipParams, settings: CpaSettings
) -> Float[Array, ""]:
    """The course of the rule. Whether the way is clear is judged on the way, not on the detour."""
    at = situation_of(observation, ship)
    altering = offset_rad != 0.0
    way = cpa_on(at, at.bearing_rad[None], ship)
    limit = settings.dcpa_m * jnp.where(altering, settings.hysteresis, 1.0)
    risk = _risk(way, limit, settings.tcpa_s)[0]
    types = classify_targets(at.position, at.velocity, at.bearing_rad)
    now = altering | ~stands_on(types) | (way.tcpa_s[0] < settings.last_moment_s)
    act = risk & now
    either = jnp.all(~act | (types == EncounterType.OVERTAKING))  # Rule 13 leaves the side open
    chosen = best_alteration(
        offset_rad,
        lambda course: _shortfall(cpa_on(at, course, ship), settings),
        at.bearing_rad,
        settings.alterations_deg,
        jnp.where(either, 0.0, settings.port_deg),
    )
    return jnp.where(act.any(), chosen, 0.0)


def _risk(cpa: Cpa, limit_m: Float[Array, ""], soon_s: float) -> Bool[Array, "*n"]:
    return (cpa.dcpa_m < limit_m) & (cpa.tcpa_s > 0) & (cpa.tcpa_s < soon_s)


def _shortfall(cpa: Cpa, settings: CpaSettings) -> Float[Array, " c"]:
    """By what part of the limit each course passes the nearest ship too near; 0 is clear."""
    soon = (cpa.tcpa_s > 0) & (cpa.tcpa_s < 1.5 * settings.tcpa_s)
    near = jnp.where(soon, 1.0 - cpa.dcpa_m / settings.dcpa_m, 0.0)
    return near.max(-1, initial=0.0)


def best_alteration(
    offset_rad: Float[Array, ""],
    shortfall: Callable[[Float[Array, " c"]], Float[Array, " c"]],
    bearing_rad: Float[Array, ""],
    alterations_deg: tuple[float, ...],
    port_deg: float | Float[Array, ""],
) -> Float[Array, ""]:
    """The smallest alteration without a shortfall, else the one with the least.

    The course being steered (``offset_rad``, if not 0) is kept while it is clear. Altering to
    port counts as ``port_deg`` more.
    """
    steps = np.radians((*alterations_deg, *(-a for a in alterations_deg)))
    offsets = jnp.concatenate([jnp.asarray(steps, jnp.float32), offset_rad[None]])
    short = shortfall(bearing_rad + offsets)
    size = jnp.abs(offsets) + jnp.where(offsets < 0, jnp.radians(port_deg), 0.0)
    size = size.at[-1].set(jnp.where(offset_rad == 0.0, jnp.inf, 0.0))
    return offsets[jnp.argmin(100.0 * short + size)]


CPA = CourseMethod(cpa_course, CpaSettings())
