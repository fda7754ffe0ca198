"""Any pilot on many worlds at once, all in step with each other."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.env.observe import Observation
from glasshelm.pilots.protocols import Memory, Pilot


class BatchedPilot(eqx.Module):
    """Turns batches of observations and memories into rudders.

    A pilot that has a ``steer_together`` (the planner, who then plans for all
    at once and only when it is time) is asked for it; any other is vmapped.
    """

    pilot: Pilot

    def start(self, worlds: int) -> Memory:
        """The memories before the first decision."""
        return jax.tree.map(
            lambda x: jnp.broadcast_to(x, (worlds, *jnp.shape(x))), self.pilot.start()
        )

    def __call__(
        self, observation: Observation, memory: Memory
    ) -> tuple[Float[Array, " w"], Memory]:
        steer = getattr(self.pilot, "steer_together", jax.vmap(self.pilot.steer))
        return steer(observation, memory)
