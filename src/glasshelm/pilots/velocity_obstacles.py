"""Velocity obstacles (Fiorini & Shiller 1998), and Kuwata et al.'s form with COLREGs (2014).

The velocity obstacle of a ship is the cone of own velocities that lead, if
both keep on, into a disc around her within the horizon. Own ship takes the
velocity outside all cones nearest to the one that she wants. Speed being fixed
here, velocities are courses.
"""

import dataclasses
import math

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from glasshelm.colregs.classification import classify_targets, gives_way
from glasshelm.core.geometry import Vector, closest_approach, norm, wrap_angle
from glasshelm.env.observe import Observation
from glasshelm.pilots.course_pilot import CourseMethod
from glasshelm.planning.situation import situation_of
from glasshelm.planning.trial_manoeuvre import cpa_on, try_courses
from glasshelm.ship.nomoto import ShipParams


@dataclasses.dataclass(frozen=True)
class VelocitySettings:
    """Discs, horizon, grid of courses. Tuned: docs/explanation/classical-pilots.md."""

    #: Radius of the disc around every ship.
    radius_m: float = 2200.0
    #: A disc reached later is no obstacle yet.
    horizon_s: float = 2450.0
    largest_deg: float = 120.0
    step_deg: float = 5.0
    #: In a cone, what passing through the middle of a disc costs beside the time to reach it.
    depth_weight: float = 1.0
    #: What leaving the course being steered costs, in differences of velocity per own speed.
    change_cost: float = 0.24
    #: Kuwata's form: no passing ahead of ships to which own ship gives way.
    colregs: bool = False
    #: Its weights: in a velocity obstacle; against the rules.
    obstacle_cost: float = 1000.0
    rules_cost: float = 100.0
    #: Rules apply to ships that would come so near on the way to the waypoint.
    rules_dcpa_m: float = 1850.0


def velocity_course(
    observation: Observation,
    offset_rad: Float[Array, ""],
    ship: ShipParams,
    settings: VelocitySettings,
) -> Float[Array, ""]:
    """The course outside all velocity obstacles that costs least.

    If there is none: where the disc is reached latest, as Fiorini & Shiller propose.
    """
    at = situation_of(observation, ship)
    count = round(settings.largest_deg / settings.step_deg)
    steps = jnp.arange(1, count + 1) * math.radians(settings.step_deg)
    present = wrap_angle(-at.bearing_rad)
    offsets = jnp.concatenate([jnp.zeros(1), steps, -steps, present[None]])  # ties: starboard
    position, motion = try_courses(at, at.bearing_rad + offsets, ship)
    entry = entry_s(position, motion, settings.radius_m)
    urgency = jnp.maximum(1.0 - entry / settings.horizon_s, 0.0)
    depth = 1.0 - closest_approach(position, motion).dcpa_m / settings.radius_m
    blocked = (urgency > 0) * (1.0 + urgency + settings.depth_weight * depth)
    cost = settings.obstacle_cost * blocked.max(-1, initial=0.0)
    cost += 2.0 * jnp.abs(jnp.sin(0.5 * offsets))  # |v − v_wanted| / U
    cost += settings.change_cost * 2.0 * jnp.abs(jnp.sin(0.5 * (offsets - offset_rad)))
    if settings.colregs:
        wanted = cpa_on(at, at.bearing_rad[None], ship)
        near = (wanted.dcpa_m < settings.rules_dcpa_m) & (wanted.tcpa_s > 0)
        near &= wanted.tcpa_s < settings.horizon_s
        types = classify_targets(at.position, at.velocity, at.bearing_rad)
        wrong = gives_way(types) & near[0] & passes_to_starboard(position, motion)
        cost += settings.rules_cost * wrong.any(-1)
    return offsets[jnp.argmin(cost)]


def entry_s(position: Vector, motion: Vector, radius_m: float) -> Float[Array, "*n"]:
    """When a ship in relative motion enters the disc [s]; 0 if inside and closing, inf if never."""
    cpa = closest_approach(position, motion, horizon_s=math.inf)
    speed = jnp.maximum(norm(motion), 1e-6)
    half = jnp.sqrt(jnp.maximum(radius_m**2 - cpa.dcpa_m**2, 0.0)) / speed
    meets = (cpa.dcpa_m < radius_m) & (cpa.tcpa_s > 0)
    return jnp.where(meets, jnp.maximum(cpa.tcpa_s - half, 0.0), jnp.inf)


def passes_to_starboard(position: Vector, motion: Vector) -> Bool[Array, "*n"]:
    """Kuwata's V1: own ship closes and leaves the other to starboard (goes ahead of a crosser)."""
    closing = position.x * motion.x + position.y * motion.y < 0
    return closing & (position.x * motion.y - position.y * motion.x < 0)


VELOCITY = CourseMethod(velocity_course, VelocitySettings())
VELOCITY_COLREGS = CourseMethod(velocity_course, VelocitySettings(colregs=True))
