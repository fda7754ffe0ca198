"""How good is a policy: rollouts of the fixed set of random encounters, without exploration."""

import dataclasses

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float, Int

from glasshelm.encounters.types import Encounter
from glasshelm.env.observe import Observation
from glasshelm.networks.actors import Policy
from glasshelm.pilots.protocols import BatchPolicy, Memory
from glasshelm.ship.course_reversals import WEAVING
from glasshelm.ship.nomoto import ShipParams
from glasshelm.simulation.rollout import Measures, plain_cases, rollout

#: What a voyage must earn in its first 1200 s, ships met or not; in open water it earns 48.
LEAST_RETURN = 36.0

#: What can be measured: with a memory or without.
AnyPolicy = Policy | BatchPolicy


@dataclasses.dataclass(frozen=True)
class ValidationScore:
    """Rates and means over a validation set.

    An intrusion is a target inside the domain (Eq. 13 > 0) at any step, a
    collision a centre distance below own ship's length; ``_long``: in the whole
    voyage, else in its first 1200 s, as the undiscounted returns. ``rudder`` is the mean
    deflection as a fraction of the limit. ``reversals`` is their mean
    number per voyage, ``weaving`` the share of voyages with ``WEAVING`` or more,
    ``intrusions_by_targets`` the long intrusion rate by number of targets.
    """

    intrusions: float
    intrusions_long: float
    collisions: float
    collisions_long: float
    return_waypoint: float
    return_collision: float
    rudder: float
    reversals: float
    weaving: float
    intrusions_by_targets: tuple[float | None, ...]

    @property
    def total_return(self) -> float:
        return self.return_waypoint + self.return_collision

    @property
    def selection_loss(self) -> float:
        """What the best actor is chosen by, lower is better: a collision counts as ten intrusions.

        Three points of return (of about 50) count as one intrusion in a hundred, and so do
        ten voyages of weaving. Below :data:`LEAST_RETURN` each point counts as ten in a hundred:
        a policy that sails in circles where no ship comes also intrudes seldom.
        """
        rates = self.intrusions + self.intrusions_long
        rates += 10.0 * (self.collisions + self.collisions_long)
        short = max(0.0, LEAST_RETURN - self.total_return)
        return rates - self.total_return / 300.0 + 0.1 * short + 0.1 * self.weaving


class Memoryless(eqx.Module):
    """An actor as a :class:`~glasshelm.pilots.protocols.BatchPolicy` that remembers nothing."""

    actor: Policy

    def start(self, size: int) -> Memory:
        return ()

    def __call__(
        self, observation: Observation, memory: Memory
    ) -> tuple[Float[Array, " w"], Memory]:
        return self.actor(observation), memory


def validate(
    policy: AnyPolicy, encounters: Encounter, ship: ShipParams, steps: int = 480
) -> ValidationScore:
    """Simulate a batch of encounters for so many steps under a policy, and score it."""
    batch_policy = policy if isinstance(policy, BatchPolicy) else Memoryless(policy)
    measures = rollout(batch_policy, plain_cases(encounters, ship, steps), steps)
    targets = np.asarray(encounters.present).sum(-1)
    return score(jax.device_get(measures), targets, steps, float(ship.loa_m))


def score(
    measures: Measures, targets: Int[np.ndarray, " w"], steps: int, loa_m: float
) -> ValidationScore:
    """Rates and means of a batch of episodes.

    Args:
        measures: What was measured of every episode.
        targets: Number of targets of every episode.
        steps: Steps of an episode.
        loa_m: Own ship's length.
    """
    intruded, collided = measures.margin > 0, measures.range_m < loa_m
    intrusions, collisions = intruded.mean(0), collided.mean(0)
    returns, reversals = measures.return_by_task.mean(0), measures.reversals.count
    by_number = [intruded[targets == n, 1] for n in range(int(targets.max(initial=0)) + 1)]
    return ValidationScore(
        intrusions=float(intrusions[0]),
        intrusions_long=float(intrusions[1]),
        collisions=float(collisions[0]),
        collisions_long=float(collisions[1]),
        return_waypoint=float(returns[0]),
        return_collision=float(returns[1]),
        rudder=float(measures.rudder.mean()) / steps,
        reversals=float(reversals.mean()),
        weaving=float((reversals >= WEAVING).mean()),
        intrusions_by_targets=tuple(float(x.mean()) if x.size else None for x in by_number),
    )
