"""Steer for the waypoint and see nobody: what every avoidance begins from."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.pilots.course import Method
from glasshelm.ships import ShipParams
from glasshelm.world.observe import Observation


def waypoint_course(
    seen: Observation, offset_rad: Float[Array, ""], ship: ShipParams, settings: None
) -> Float[Array, ""]:
    """The bearing of the waypoint: no offset. The helmsman's PD law does the rest."""
    return jnp.zeros_like(offset_rad)


WAYPOINT = Method(waypoint_course, None)
