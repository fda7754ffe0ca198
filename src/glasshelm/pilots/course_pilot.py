"""Pilots that think in courses: a rule chooses one now and then, the autopilot steers it."""

import dataclasses
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from glasshelm.env.observe import Observation
from glasshelm.pilots.batched import in_step
from glasshelm.pilots.protocols import Decision
from glasshelm.planning.situation import rudder_towards
from glasshelm.ship.nomoto import ShipParams

#: From an observation, the course being steered (both courses off the waypoint's bearing, [rad]),
#: own ship's model and the rule's settings to the course to steer.
Rule = Callable[[Observation, Float[Array, ""], ShipParams, Any], Float[Array, ""]]


@dataclasses.dataclass(frozen=True)
class CourseMethod:
    """A way of choosing courses: a rule, its settings, and how often it is asked."""

    rule: Rule
    settings: Any
    period: int = 6


class CourseMemory(eqx.Module):
    """The course being steered, off the waypoint's bearing, and the decisions since the start."""

    offset_rad: Float[Array, "*b"]
    age: Int[Array, "*b"]


class CoursePilot(eqx.Module):
    """Asks its method for a course period ``method.period`` decisions and steers it in between."""

    ship: ShipParams = eqx.field(static=True)
    name: str = eqx.field(static=True)
    method: CourseMethod = eqx.field(static=True)

    def start(self) -> CourseMemory:
        """The way to the waypoint, and no decision yet."""
        return CourseMemory(jnp.zeros(()), jnp.zeros((), jnp.int32))

    def decide(
        self, observation: Observation, memory: CourseMemory
    ) -> tuple[Decision, CourseMemory]:
        """The rudder to the course being steered, chosen anew when it is time."""
        rudder, memory = self._steer(observation, memory)
        return Decision(rudder), memory

    @in_step
    def _steer(
        self, observation: Observation, memory: CourseMemory
    ) -> tuple[Float[Array, " w"], CourseMemory]:
        method = self.method

        def choose(observation: Observation, offset: Float[Array, ""]) -> Float[Array, ""]:
            return method.rule(observation, offset, self.ship, method.settings)

        offset = jax.lax.cond(
            memory.age[0] % method.period == 0,
            lambda: jax.vmap(choose)(observation, memory.offset_rad),
            lambda: memory.offset_rad,
        )
        rudder = jax.vmap(lambda o, s: rudder_towards(o, s, self.ship))(offset, observation)
        return rudder, CourseMemory(offset, memory.age + 1)
