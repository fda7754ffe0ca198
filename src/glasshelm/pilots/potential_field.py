"""The artificial potential field of Khatib (1986): ships repel, the waypoint attracts.

U = ξ·d_wp + Σ ½·η·(1/ρ − 1/ρ₀)² for ρ < ρ₀, where ρ is the distance to a
ship's disc. Own ship steers where −∇U points. Khatib's attraction ½·ξ·d² would
be a thousand times stronger at the start of a 46 km leg than at its end; the
cone ξ·d of constant force is the usual form for long ways.
"""

import dataclasses

import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.core.geometry import Vector, direction, norm, wrap_angle
from glasshelm.env.observe import Observation
from glasshelm.pilots.course_pilot import CourseMethod
from glasshelm.planning.situation import situation_of
from glasshelm.ship.nomoto import ShipParams


@dataclasses.dataclass(frozen=True)
class PotentialSettings:
    """The field. Tuned: docs/explanation/classical-pilots.md. The attraction ξ is 1."""

    #: Repulsion begins at so much from a disc (ρ₀).
    influence_m: float = 12_600.0
    #: Radius of the disc that repels.
    radius_m: float = 514.0
    #: η in ρ₀³: the repulsion equals the attraction at ρ where (1/ρ − 1/ρ₀)·ρ₀³·η/ρ² = 1.
    strength: float = 0.041
    #: Nearer than this the force grows no more.
    nearest_m: float = 100.0


def repulsion(offset: Vector, settings: PotentialSettings) -> Vector:
    """−∇U of the repulsion for a ship at an offset [m]: points away from her."""
    distance = norm(offset)
    gap = jnp.maximum(distance - settings.radius_m, settings.nearest_m)
    reach = settings.influence_m
    size = settings.strength * reach**3 * (1.0 / gap - 1.0 / reach) / gap**2
    size = jnp.where(gap < reach, size, 0.0) / jnp.maximum(distance, 1.0)
    return Vector(-size * offset.x, -size * offset.y)


def potential_course(
    observation: Observation,
    offset_rad: Float[Array, ""],
    ship: ShipParams,
    settings: PotentialSettings,
) -> Float[Array, ""]:
    """The direction of the force, off the waypoint's bearing."""
    at = situation_of(observation, ship)
    far = jnp.maximum(norm(at.waypoint), 1.0)
    push = repulsion(at.position, settings)
    force = Vector(at.waypoint.x / far + push.x.sum(), at.waypoint.y / far + push.y.sum())
    return wrap_angle(direction(force) - at.bearing_rad)


POTENTIAL = CourseMethod(potential_course, PotentialSettings(), period=1)
