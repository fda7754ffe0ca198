"""How often a ship turns back on her own alteration: the measure of weaving.

A voyage around one ship has one or two: away, back to the way, perhaps up to it
again. A pilot that changes its mind has many.
"""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

#: Heading must come back by this much before it counts.
HYSTERESIS_RAD = float(np.radians(5.0))
#: A voyage of 40 minutes with so many reversals is called weaving.
WEAVING = 5


class Reversals(eqx.Module):
    """Counted so far. ``turned_rad``: since the start, starboard positive, not wrapped.

    ``high_rad`` and ``low_rad`` are its extremes since the last reversal, ``way``
    the side she turns to: 1 starboard, −1 port, 0 not known yet.
    """

    turned_rad: Float[Array, "*b"]
    high_rad: Float[Array, "*b"]
    low_rad: Float[Array, "*b"]
    way: Int[Array, "*b"]
    count: Int[Array, "*b"]

    @classmethod
    def none(cls, *shape: int) -> "Reversals":
        """Before the first step."""
        zero, nothing = jnp.zeros(shape), jnp.zeros(shape, jnp.int32)
        return cls(zero, zero, zero, nothing, nothing)

    def after(self, change_rad: Float[Array, "*b"]) -> "Reversals":
        """With one more change of heading."""
        turned = self.turned_rad + change_rad
        high = jnp.maximum(self.high_rad, turned)
        low = jnp.minimum(self.low_rad, turned)
        up = (turned - low > HYSTERESIS_RAD) & (self.way != 1)
        down = (high - turned > HYSTERESIS_RAD) & (self.way != -1)
        return Reversals(
            turned,
            jnp.where(up, turned, high),
            jnp.where(down, turned, low),
            jnp.where(up, 1, jnp.where(down, -1, self.way)).astype(jnp.int32),
            self.count + (up & (self.way == -1)) + (down & (self.way == 1)),
        )
