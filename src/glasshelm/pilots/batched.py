"""Any pilot in many encounters at once, all in step with each other."""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.custom_batching import custom_vmap
from jaxtyping import Array, Float

from glasshelm.env.observe import Observation
from glasshelm.pilots.protocols import Memory, Pilot


class BatchedPilot(eqx.Module):
    """A pilot as a policy for batches: ``jax.vmap`` of its decisions."""

    pilot: Pilot

    def start(self, size: int) -> Memory:
        """The memories before the first decision."""
        return jax.tree.map(
            lambda x: jnp.broadcast_to(x, (size, *jnp.shape(x))), self.pilot.start()
        )

    def __call__(
        self, observation: Observation, memory: Memory
    ) -> tuple[Float[Array, " w"], Memory]:
        decision, memory = jax.vmap(self.pilot.decide)(observation, memory)
        return decision.rudder, memory


def in_step(
    batch_method: Callable[[Any, Observation, Memory], tuple[Any, Memory]],
) -> Callable[[Any, Observation, Memory], tuple[Any, Memory]]:
    """A method for one encounter from a method for a batch of encounters in step.

    Under ``jax.vmap`` it is the method for the batch. What a batch decides only now and then, in
    ``jax.lax.cond``, stays a branch then; of a method for one encounter, both branches would be
    computed at every step.
    """

    @custom_vmap
    def one(pilot: Any, *given: Any) -> Any:
        out = batch_method(pilot, *jax.tree.map(lambda x: x[None], given))
        return jax.tree.map(lambda x: x[0], out)

    @one.def_vmap
    def _(size: int, batched: Any, pilot: Any, *given: Any) -> tuple[Any, Any]:
        def whole(x: Array, is_batched: bool) -> Array:
            return x if is_batched else jnp.broadcast_to(x, (size, *jnp.shape(x)))

        out = batch_method(pilot, *jax.tree.map(whole, given, tuple(batched[1:])))
        return out, jax.tree.map(lambda _: True, out)

    def method(pilot: Any, observation: Observation, memory: Memory) -> tuple[Any, Memory]:
        return one(pilot, observation, memory)

    return method
