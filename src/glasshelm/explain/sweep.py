"""Q over the whole rudder range by sub-task and ship: what else the pilot could have done."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.networks.critics import QValues

RUDDERS = 21  # from hard port to hard starboard, rudder 0 among them


class Sweep(eqx.Module):
    """Actions [k], fractions of the rudder limit, and the value of each: [k] and [k, n]."""

    action: Float[Array, " k"]
    value: QValues


def rudder_range(rudders: int = RUDDERS) -> Float[Array, " k"]:
    """Evenly spaced actions from hard port (−1) to hard starboard (+1)."""
    return jnp.linspace(-1.0, 1.0, rudders)
