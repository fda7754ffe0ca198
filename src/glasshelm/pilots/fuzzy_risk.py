"""Fuzzy collision risk, the way of Hasegawa and others (from 1987): steer by one number.

DCPA and TCPA, made dimensionless by own ship's length and speed, belong to
overlapping fuzzy sets; a table of rules gives the risk of each pair of sets,
and the risk is their mean by membership (product inference, singletons). Own
ship alters when the risk of the way ahead passes a limit, to starboard where
that helps, and returns when it is below a lower one.
"""

import dataclasses

import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.core.geometry import Cpa
from glasshelm.env.observe import Observation
from glasshelm.pilots.course_pilot import CourseMethod
from glasshelm.pilots.cpa_rule import best_alteration
from glasshelm.planning.situation import situation_of
from glasshelm.planning.trial_manoeuvre import cpa_on
from glasshelm.ship.nomoto import ShipParams


@dataclasses.dataclass(frozen=True)
class FuzzySettings:
    """Sets, rules and limits. Tuned: docs/explanation/classical-pilots.md."""

    #: Peaks of the triangular sets of DCPA/L: dangerous, dangerous medium, medium, safe.
    dcpa_loa: tuple[float, ...] = (0.0, 2.9, 5.8, 8.7)
    #: Peaks of the triangular sets of TCPA·U/L: the same.
    tcpa_loa: tuple[float, ...] = (0.0, 23.0, 46.0, 69.0)
    #: Risk where the sets of TCPA (rows) and DCPA (columns) meet.
    risks: tuple[tuple[float, ...], ...] = (
        (1.0, 0.9, 0.5, 0.0),
        (0.9, 0.8, 0.3, 0.0),
        (0.7, 0.5, 0.1, 0.0),
        (0.0, 0.0, 0.0, 0.0),
    )
    act_above: float = 0.45
    return_below: float = 0.27
    alterations_deg: tuple[float, ...] = (20.0, 30.0, 45.0, 60.0, 75.0, 90.0, 120.0)
    port_deg: float = 10.0


def memberships(value: Float[Array, "*n"], peaks: tuple[float, ...]) -> Float[Array, "*n k"]:
    """Degree in each triangular set; the first and last sets go on for ever. They sum to 1."""
    at = jnp.clip(value, peaks[0], peaks[-1])
    return jnp.stack(
        [jnp.interp(at, jnp.asarray(peaks), row) for row in jnp.eye(len(peaks))], axis=-1
    )


def fuzzy_risk(cpa: Cpa, ship: ShipParams, settings: FuzzySettings) -> Float[Array, "*n"]:
    """The risk in [0, 1] of ships with a CPA; 0 once it is past."""
    near = memberships(cpa.dcpa_m / ship.loa_m, settings.dcpa_loa)
    soon = memberships(cpa.tcpa_s * ship.speed_m_s / ship.loa_m, settings.tcpa_loa)
    risk = jnp.einsum("...t,td,...d->...", soon, jnp.asarray(settings.risks), near)
    return jnp.where(cpa.tcpa_s > 0, risk, 0.0)


def fuzzy_course(
    observation: Observation,
    offset_rad: Float[Array, ""],
    ship: ShipParams,
    settings: FuzzySettings,
) -> Float[Array, ""]:
    """The smallest alteration that brings the risk down, while the way ahead has too much."""
    at = situation_of(observation, ship)

    def worst(course: Float[Array, " c"]) -> Float[Array, " c"]:
        return fuzzy_risk(cpa_on(at, course, ship), ship, settings).max(-1, initial=0.0)

    limit = jnp.where(offset_rad == 0.0, settings.act_above, settings.return_below)
    chosen = best_alteration(
        offset_rad,
        lambda course: jnp.maximum(worst(course) - settings.return_below, 0.0),
        at.bearing_rad,
        settings.alterations_deg,
        settings.port_deg,
    )
    return jnp.where(worst(at.bearing_rad[None])[0] > limit, chosen, 0.0)


FUZZY = CourseMethod(fuzzy_course, FuzzySettings())
