"""The glassbox pilot: it steers the manoeuvre that its sub-task critics value most.

    m* = argmax_m  Q_wp(s_wp, m) + Q_helm(m) + Σ_i Q_ca(s_i, m)

Its explanation is not about the decision, it is the decision. It remembers nothing: every
decision is chosen anew, which makes of manoeuvres that are fixed for their duration a feedback
law (open-loop feedback control, Bertsekas).
"""

import equinox as eqx

from glasshelm.env.observe import Observation
from glasshelm.explanation.manoeuvre_explanation import choose, explain_manoeuvre
from glasshelm.pilots.protocols import Decision, Memory
from glasshelm.planning.simulated_critic import SimulatedCritic
from glasshelm.planning.situation import rudder_towards
from glasshelm.ship.nomoto import ShipParams


class GlassboxPilot(eqx.Module):
    """Steers by the argmax of a critic of manoeuvres, for one ship."""

    ship: ShipParams = eqx.field(static=True)
    name: str = eqx.field(static=True)
    critic: SimulatedCritic = SimulatedCritic()

    def start(self) -> Memory:
        return ()

    def decide(self, observation: Observation, memory: Memory) -> tuple[Decision, Memory]:
        """The rudder towards the best manoeuvre's course, and the whole comparison."""
        manoeuvres, values = self.critic(observation, self.ship)
        offset = manoeuvres.offset_rad[choose(values)]
        why = explain_manoeuvre(manoeuvres, values, observation, self.ship, self.critic.costs)
        return Decision(rudder_towards(offset, observation, self.ship), why), memory
