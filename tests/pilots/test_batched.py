import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.encounters.random_encounters import validation_encounters
from glasshelm.pilots.batched import BatchedPilot, in_step
from glasshelm.pilots.protocols import Decision
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.rollout import plain_cases, rollout
from glasshelm.training.validation import Memoryless

SHIP = SHIPS["paper"]


class Counting(eqx.Module):
    """Steers by how many decisions it remembers."""

    name = "counting"

    def start(self):
        return jnp.zeros(())

    def decide(self, observation, memory):
        return Decision(jnp.tanh(memory - 3.0) * 0.1), memory + 1.0


class CountingInStep(Counting):
    """The same, with a branch that all worlds take at once."""

    def decide(self, observation, memory):
        rudder, memory = self._steer(observation, memory)
        return Decision(rudder), memory

    @in_step
    def _steer(self, observation, memory):
        assert observation.present.ndim == 2
        rudder = jax.lax.cond(memory[0] < 0, lambda: memory, lambda: jnp.tanh(memory - 3.0) * 0.1)
        return rudder, memory + 1.0


class Constant(eqx.Module):
    name = "constant"

    def start(self):
        return ()

    def decide(self, observation, memory):
        return Decision(jnp.asarray(0.25)), memory


class Quarter(eqx.Module):
    def __call__(self, observation):
        return jnp.full(observation.present.shape[0], 0.25)


@pytest.mark.slow
def test_a_memory_goes_from_decision_to_decision_and_both_ways_agree():
    cases = plain_cases(validation_encounters(SHIP, 4), SHIP, 12)
    found = [rollout(BatchedPilot(p), cases, 12) for p in (Counting(), CountingInStep())]
    expected = np.abs(np.tanh(np.arange(12) - 3.0) * 0.1).mean()
    for voyages in found:
        np.testing.assert_allclose(voyages.rudder / 12, expected, rtol=1e-3)
    np.testing.assert_allclose(found[0].margin, found[1].margin)


def test_a_pilot_without_memory_sails_like_its_actor():
    cases = plain_cases(validation_encounters(SHIP, 4), SHIP, 12)
    one = rollout(BatchedPilot(Constant()), cases, 12)
    two = rollout(Memoryless(Quarter()), cases, 12)
    np.testing.assert_allclose(one.range_m, two.range_m)
