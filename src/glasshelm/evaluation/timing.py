"""How long a pilot takes to decide, one observation at a time."""

import dataclasses
import time

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from glasshelm.encounters.random_encounters import RandomEncounters
from glasshelm.env.observe import Observation
from glasshelm.env.step import reset
from glasshelm.evaluation.suites.random_suite import numbered_encounters
from glasshelm.pilots.protocols import Memory, Pilot
from glasshelm.ship.nomoto import ShipParams

CALLS = 300
_SIX = RandomEncounters(targets=(6, 6))


@dataclasses.dataclass(frozen=True)
class DecisionTime:
    """Milliseconds from an observation of six ships to a rudder: median and 99th percentile."""

    pilot: str
    ship_name: str
    p50_ms: float
    p99_ms: float


def measure_decision_time(
    name: str, ship_name: str, pilot: Pilot, ship: ShipParams
) -> DecisionTime:
    """Measured over ``CALLS`` decisions in a row, after the first (which is compiled)."""
    encounter = jax.tree.map(lambda x: jnp.asarray(x[0]), numbered_encounters(ship, 1, _SIX))
    observation = reset(encounter, ship).observation

    @eqx.filter_jit
    def steer(pilot: Pilot, observation: Observation, memory: Memory) -> tuple[Array, Memory]:
        decision, memory = pilot.decide(observation, memory)
        return decision.rudder, memory

    _, memory = jax.block_until_ready(steer(pilot, observation, pilot.start()))
    took = np.empty(CALLS)
    for i in range(CALLS):
        began = time.perf_counter()
        _, memory = jax.block_until_ready(steer(pilot, observation, memory))
        took[i] = time.perf_counter() - began
    p50, p99 = np.percentile(1000 * took, [50, 99])
    return DecisionTime(name, ship_name, float(p50), float(p99))
