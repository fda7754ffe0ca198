"""The learned pilot: an actor that steers and a critic that says why."""

from pathlib import Path

import equinox as eqx
import jax
from jaxtyping import Array, Float

from glasshelm.env.observe import Observation
from glasshelm.env.padding import bucket_size, pad_observation
from glasshelm.env.training_envelope import TrainingEnvelope, check_observation
from glasshelm.explain.step_explanation import Explanation, cut, explain
from glasshelm.networks.actors import Actor
from glasshelm.networks.checkpoint import file_sha256
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.pilots.load_networks import read_networks
from glasshelm.pilots.protocols import Memory


class Decided(eqx.Module):
    """A decision and its reasons. ``action`` is the rudder as a fraction of the limit."""

    action: Float[Array, ""]
    rudder_rad: Float[Array, ""]
    explanation: Explanation


class LearnedPilot(eqx.Module):
    """Steers with a trained actor; ``critic`` may be absent, and then so are values.

    ``trained`` is what the pilot was trained on; the rudder limit of its ship
    turns the actor's fraction into an angle. ``weights_sha256`` names the file
    that the weights came from, if they came from one.
    """

    actor: Actor
    critic: SubTaskCritic | None
    trained: TrainingEnvelope = eqx.field(static=True)
    name: str = eqx.field(static=True)
    weights_sha256: str | None = eqx.field(static=True, default=None)

    def start(self) -> Memory:
        return ()

    def steer(self, observation: Observation, memory: Memory) -> tuple[Float[Array, ""], Memory]:
        return self.actor(observation), memory

    def decide(self, observation: Observation) -> Decided:
        """The rudder for one observation, and why (Eq. 19, 22-24).

        Any number of ships: programs are compiled for 0, 1, 2, 4, 8, … slots.
        InputError names the waypoint or the ship of which something is seen that
        is no possible number.
        """
        check_observation(observation)
        slots = observation.present.shape[-1]
        decided = _decide(self, pad_observation(observation, bucket_size(slots)))
        return Decided(decided.action, decided.rudder_rad, _cut(decided.explanation, slots))


def decide(pilot: LearnedPilot, observation: Observation) -> Decided:
    """:meth:`LearnedPilot.decide` without its checks and its padding: pure and traceable."""
    action = pilot.actor(observation)
    rudder = action * pilot.trained.ship.rudder_limit_rad
    return Decided(action, rudder, explain(pilot.actor, pilot.critic, observation, action))


_decide = eqx.filter_jit(decide)
_cut = jax.jit(cut, static_argnums=1)


def read_pilot(path: Path, name: str) -> LearnedPilot:
    """The pilot of a weights file, called ``name``.

    CheckpointError, in one line, if the file cannot be used.
    """
    networks, trained = read_networks(path)
    return LearnedPilot(networks.actor, networks.critic, trained, name, file_sha256(path))
