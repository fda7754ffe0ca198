"""The learned pilot: an actor that steers and a critic that says why."""

from pathlib import Path

import equinox as eqx
from jaxtyping import Array, Float

from glasshelm.env.observe import Observation
from glasshelm.env.training_envelope import TrainingEnvelope
from glasshelm.explanation.actor_explanation import explain_rudder
from glasshelm.explanation.step_explanation import Explanation
from glasshelm.networks.actors import Actor
from glasshelm.networks.checkpoint import file_sha256
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.pilots.glassbox import GlassboxPilot
from glasshelm.pilots.load_networks import read_networks
from glasshelm.pilots.protocols import Decision, Memory
from glasshelm.planning.course_critic import CourseCritic
from glasshelm.planning.learned_critic import LearnedCritic
from glasshelm.ship.nomoto import ShipParams


class LearnedPilot(eqx.Module):
    """Steers with a trained actor; ``critic`` may be absent, and then so are values.

    ``trained`` is what the pilot was trained on. ``weights_sha256`` names the file
    that the weights came from, if they came from one.
    """

    actor: Actor
    critic: SubTaskCritic | None
    trained: TrainingEnvelope = eqx.field(static=True)
    name: str = eqx.field(static=True)
    weights_sha256: str | None = eqx.field(static=True, default=None)

    @property
    def ship(self) -> ShipParams:
        """The ship that it was trained on."""
        return self.trained.ship

    def start(self) -> Memory:
        """No memory."""
        return ()

    def decide(self, observation: Observation, memory: Memory) -> tuple[Decision, Memory]:
        """The actor's rudder, and why."""
        rudder = self.actor(observation)
        return Decision(rudder, self.explain(observation, rudder)), memory

    def explain(self, observation: Observation, rudder: Float[Array, ""]) -> Explanation:
        """What actor and critic say of a rudder (a fraction of the limit)."""
        return explain_rudder(self.actor, self.critic, observation, rudder)


def read_pilot(path: Path, name: str) -> LearnedPilot | GlassboxPilot:
    """The pilot of a weights file, called ``name``: of an actor, or of a critic that steers.

    Raises:
        CheckpointError: The file cannot be used; the message is one line.
    """
    networks, trained = read_networks(path)
    digest = file_sha256(path)
    if isinstance(networks.critic, LearnedCritic | CourseCritic):
        return GlassboxPilot(trained.ship, name, networks.critic, trained, digest)
    assert networks.actor is not None
    return LearnedPilot(networks.actor, networks.critic, trained, name, digest)
