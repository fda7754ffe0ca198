"""The glassbox pilot: it steers the manoeuvre that its sub-task critics value most.

    m* = argmax_m  Q_wp(s_wp, m) + Q_helm(m) + Σ_i Q_ca(s_i, m)

Its explanation is not about the decision, it is the decision. It remembers nothing: every
decision is chosen anew, which makes of manoeuvres that are fixed for their duration a feedback
law (open-loop feedback control, Bertsekas).
"""

import dataclasses
from typing import Protocol, runtime_checkable

import equinox as eqx
from jaxtyping import Array, Float

from glasshelm.core.errors import InputError
from glasshelm.env.observe import Observation
from glasshelm.env.training_envelope import TrainingEnvelope
from glasshelm.explanation.manoeuvre_explanation import choose, explain_manoeuvre
from glasshelm.networks.critics import QValues
from glasshelm.pilots.protocols import Decision, Memory
from glasshelm.planning.manoeuvres import Manoeuvres
from glasshelm.planning.simulated_critic import ManoeuvreCosts, SimulatedCritic
from glasshelm.planning.situation import rudder_towards
from glasshelm.ship.nomoto import ShipParams


@runtime_checkable
class ManoeuvreCritic(Protocol):
    """What values manoeuvres: :class:`~glasshelm.planning.simulated_critic.SimulatedCritic`,
    :class:`~glasshelm.planning.learned_critic.LearnedCritic` or
    :class:`~glasshelm.planning.course_critic.CourseCritic`.
    """

    @property
    def costs(self) -> ManoeuvreCosts:
        """What counts."""
        ...

    def __call__(self, observation: Observation, ship: ShipParams) -> tuple[Manoeuvres, QValues]:
        """The manoeuvres that there are in one observation; their values by sub-task."""
        ...

    def along(
        self, course_rad: Float[Array, ""], observation: Observation, ship: ShipParams
    ) -> tuple[Manoeuvres, QValues]:
        """Those along a course relative to own heading, or along the nearest that it knows."""
        ...


def best_course(
    critic: ManoeuvreCritic, observation: Observation, ship: ShipParams
) -> Float[Array, ""]:
    """The course that the manoeuvre valued most begins with, off the waypoint's bearing [rad]."""
    manoeuvres, values = critic(observation, ship)
    return manoeuvres.offset_rad[choose(values)]


class GlassboxPilot(eqx.Module):
    """Steers by the argmax of a critic of manoeuvres: one ship, or the ship that it is given.

    Attributes:
        ship: The ship that it was made for; None: any, and :meth:`for_ship` gives it one.
        name: What people call it.
        critic: What values the manoeuvres.
        trained: What the critic was trained on; None if it was not.
        weights_sha256: The file that it came from, if it came from one.
    """

    ship: ShipParams | None = None
    name: str = eqx.field(static=True, default="glassbox")
    critic: ManoeuvreCritic = SimulatedCritic()
    trained: TrainingEnvelope | None = eqx.field(static=True, default=None)
    weights_sha256: str | None = eqx.field(static=True, default=None)

    def for_ship(self, ship: ShipParams) -> "GlassboxPilot":
        return self if self.ship is not None else dataclasses.replace(self, ship=ship)

    def start(self) -> Memory:
        return ()

    def decide(self, observation: Observation, memory: Memory) -> tuple[Decision, Memory]:
        """The rudder towards the best manoeuvre's course, and the whole comparison."""
        ship = self.ship
        if ship is None:
            raise InputError(f"pilot {self.name!r} is for any ship: for_ship(ship) gives it one")
        manoeuvres, values = self.critic(observation, ship)
        offset = manoeuvres.offset_rad[choose(values)]
        why = explain_manoeuvre(manoeuvres, values, observation, ship, self.critic.costs)
        return Decision(rudder_towards(offset, observation, ship), why), memory
