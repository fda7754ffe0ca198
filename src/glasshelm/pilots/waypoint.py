"""Steer for the waypoint and see nobody: what every avoidance begins from."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.env.observe import Observation
from glasshelm.pilots.course_pilot import CourseMethod
from glasshelm.ship.nomoto import ShipParams


def waypoint_course(
    observation: Observation, offset_rad: Float[Array, ""], ship: ShipParams, settings: None
) -> Float[Array, ""]:
    """The bearing of the waypoint: no offset. The autopilot's PD law does the rest."""
    return jnp.zeros_like(offset_rad)


WAYPOINT = CourseMethod(waypoint_course, None)
