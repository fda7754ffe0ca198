"""Do nothing: rudder amidships. The floor of every comparison and Eq. 22's reference action."""

import equinox as eqx
import jax.numpy as jnp

from glasshelm.env.observe import Observation
from glasshelm.pilots.protocols import Decision, Memory


class StraightPilot(eqx.Module):
    """Keeps the rudder amidships whatever happens."""

    @property
    def name(self) -> str:
        return "straight"

    def start(self) -> Memory:
        return ()

    def decide(self, observation: Observation, memory: Memory) -> tuple[Decision, Memory]:
        return Decision(jnp.zeros(())), memory
