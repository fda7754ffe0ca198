"""The planner: no network, a model of own ship and many manoeuvres tried in thought.

It is the teacher of the learned pilots and the classical pilot to compare them
with (scenario-based MPC, :mod:`glasshelm.planning.course`). It sees only what
they see; it cannot say what it values, so its frames carry no explanation.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from glasshelm.planning.course import CourseSettings, plan_course, rudder_to
from glasshelm.ships import ShipParams
from glasshelm.world.observe import Observation


class Intent(eqx.Module):
    """The course being steered, off the waypoint's bearing, and the decisions since it was set."""

    offset_rad: Float[Array, "*b"]
    age: Int[Array, "*b"]


class PlannerPilot(eqx.Module):
    """Sets a course every ``every`` decisions and steers it in between."""

    ship: ShipParams = eqx.field(static=True)
    name: str = eqx.field(static=True)
    settings: CourseSettings = eqx.field(static=True, default=CourseSettings())
    every: int = eqx.field(static=True, default=12)

    def start(self) -> Intent:
        return Intent(jnp.zeros(()), jnp.zeros((), jnp.int32))

    def steer(self, seen: Observation, memory: Intent) -> tuple[Float[Array, ""], Intent]:
        one = jax.tree.map(lambda x: x[None], (seen, memory))
        rudder, memory = self.steer_together(*one)
        return rudder[0], jax.tree.map(lambda x: x[0], memory)

    def steer_together(
        self, seen: Observation, memory: Intent
    ) -> tuple[Float[Array, " w"], Intent]:
        """The rudders of worlds in step with each other: all set their courses at once."""
        offset = jax.lax.cond(
            memory.age[0] % self.every == 0,
            lambda: jax.vmap(lambda s: plan_course(s, self.ship, self.settings).offset_rad)(seen),
            lambda: memory.offset_rad,
        )
        rudder = jax.vmap(lambda o, s: rudder_to(o, s, self.ship))(offset, seen)
        return rudder, Intent(offset, memory.age + 1)
