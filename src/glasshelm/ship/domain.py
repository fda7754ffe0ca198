"""The ship domain and the danger of a ship in it (Eq. 13-15)."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.core.geometry import Vector, norm

# Half axes of the domain in ship lengths (Eq. 14-15).
STARBOARD_LOA = 3.2
PORT_LOA = 1.6
AHEAD_LOA = 6.4
ASTERN_LOA = 1.6


def domain_axes(
    body: Vector, loa_m: float | Float[Array, "..."]
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """Half axes (a_x, a_y) [m] of the domain on the side where the target is (Eq. 14-15)."""
    across = jnp.where(body.x >= 0, STARBOARD_LOA, PORT_LOA) * loa_m
    along = jnp.where(body.y >= 0, AHEAD_LOA, ASTERN_LOA) * loa_m
    return across, along


def danger_unclipped(body: Vector, loa_m: float | Float[Array, "..."]) -> Float[Array, "..."]:
    """Eq. 13 as printed: 1 at own ship, 0 on the edge of the domain, negative outside.

    Multiplied by what the axes divide by, and so twice as fast on a CPU.
    """
    across = jnp.where(body.x >= 0, 1.0 / (STARBOARD_LOA * loa_m), 1.0 / (PORT_LOA * loa_m))
    along = jnp.where(body.y >= 0, 1.0 / (AHEAD_LOA * loa_m), 1.0 / (ASTERN_LOA * loa_m))
    return 1.0 - norm(Vector(body.x * across, body.y * along))


def danger(body: Vector, loa_m: float | Float[Array, "..."]) -> Float[Array, "..."]:
    """Level of danger cr in [0, 1] of a target at a body-frame position [m]; 0 outside (Eq. 13)."""
    return jnp.maximum(danger_unclipped(body, loa_m), 0.0)
