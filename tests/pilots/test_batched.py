import equinox as eqx
import jax.numpy as jnp
import numpy as np

from glasshelm.pilots.batched import BatchedPilot
from glasshelm.ship.nomoto import SHIPS
from glasshelm.training.validation import evaluation_set, sail_remembering, sail_set

SHIP = SHIPS["paper"]


class Counting(eqx.Module):
    """Steers by how many decisions it remembers."""

    name = "counting"

    def start(self):
        return jnp.zeros(())

    def steer(self, observation, memory):
        return jnp.tanh(memory - 3.0) * 0.1, memory + 1.0


class CountingTogether(Counting):
    def steer_together(self, observation, memory):
        return jnp.tanh(memory - 3.0) * 0.1, memory + 1.0


class Constant(eqx.Module):
    name = "constant"

    def start(self):
        return ()

    def steer(self, observation, memory):
        return jnp.asarray(0.25), memory


class Quarter(eqx.Module):
    def __call__(self, observation):
        return jnp.full(observation.present.shape[0], 0.25)


def test_a_memory_goes_from_decision_to_decision_and_both_ways_agree():
    encounters = evaluation_set(SHIP, 4)
    found = [
        sail_remembering(BatchedPilot(p), BatchedPilot(p).start(4), encounters, SHIP, 6, 12)
        for p in (Counting(), CountingTogether())
    ]
    expected = np.abs(np.tanh(np.arange(12) - 3.0) * 0.1).mean()
    for voyages in found:
        np.testing.assert_allclose(voyages.rudder, expected, rtol=1e-5)
    np.testing.assert_allclose(found[0].margin, found[1].margin)


def test_a_pilot_without_memory_sails_like_its_actor():
    encounters = evaluation_set(SHIP, 4)
    together = BatchedPilot(Constant())
    one = sail_remembering(together, together.start(4), encounters, SHIP, 6, 12)
    two = sail_set(Quarter(), encounters, SHIP, 6, 12)
    np.testing.assert_allclose(one.range_m, two.range_m)
