"""How good is an actor: rollouts of the fixed set of random encounters, without exploration."""

import dataclasses
from functools import partial

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
from glasshelm.simulation.rollout import plain_cases, rollout


class Rollout(eqx.Module):
    """What happened in each encounter of a batch, over a short and a long voyage.

    ``margin`` is the worst Eq. 13 (unclipped) of any target, ``range_m`` the
    nearest centre distance; index 0: the first ``short`` steps, 1: all.
    Returns are undiscounted, over the first ``short`` steps. ``reversals`` counts
    the alterations taken back, of all steps (:mod:`glasshelm.ship.course_reversals`).
    """

    margin: Float[Array, "2 w"]
    range_m: Float[Array, "2 w"]
    return_by_task: Float[Array, "w 2"]
    rudder: Float[Array, " w"]
    reversals: Int[Array, " w"]
    targets: Int[Array, " w"]


@dataclasses.dataclass(frozen=True)
class ValidationScore:
    """Rates and means over a validation set.

    An intrusion is a target inside the domain (Eq. 13 > 0) at any step, a
    collision a centre distance below own ship's length. ``reversals`` is their mean
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
        ten voyages of weaving.
        """
        rates = self.intrusions + self.intrusions_long
        rates += 10.0 * (self.collisions + self.collisions_long)
        return rates - self.total_return / 300.0 + 0.1 * self.weaving


class Memoryless(eqx.Module):
    """An actor as a :class:`BatchPolicy` that remembers nothing."""

    actor: Policy

    def start(self, worlds: int) -> Memory:
        return ()

    def __call__(
        self, observation: Observation, memory: Memory
    ) -> tuple[Float[Array, " w"], Memory]:
        return self.actor(observation), memory


@partial(jax.jit, static_argnames=("short", "long"))
def validation_rollout(
    policy: BatchPolicy, encounters: Encounter, ship: ShipParams, short: int = 240, long: int = 480
) -> Rollout:
    """:func:`glasshelm.simulation.rollout.rollout` of a batch of encounters, in brief.

    Args:
        policy: What steers them all.
        encounters: The batch.
        ship: Own ship.
        short: Steps of the short voyage.
        long: Steps of the long voyage.
    """
    cases = plain_cases(encounters, ship, long, short)
    found = rollout(policy, cases, long)
    return Rollout(
        found.margin.T,
        found.range_m.T,
        found.return_by_task,
        found.rudder / long,
        found.reversals.count,
        encounters.present.sum(-1),
    )


def score(episodes: Rollout, loa_m: float) -> ValidationScore:
    """Rates and means of a batch of episodes; ``loa_m`` is own ship's length."""
    episodes = jax.device_get(episodes)
    intruded, collided = episodes.margin > 0, episodes.range_m < loa_m
    intrusions, collisions = intruded.mean(-1), collided.mean(-1)
    returns = episodes.return_by_task.mean(0)
    numbers = range(int(episodes.targets.max(initial=0)) + 1)
    by_number = [intruded[1][episodes.targets == n] for n in numbers]
    return ValidationScore(
        intrusions=float(intrusions[0]),
        intrusions_long=float(intrusions[1]),
        collisions=float(collisions[0]),
        collisions_long=float(collisions[1]),
        return_waypoint=float(returns[0]),
        return_collision=float(returns[1]),
        rudder=float(episodes.rudder.mean()),
        reversals=float(episodes.reversals.mean()),
        weaving=float(np.mean(episodes.reversals >= WEAVING)),
        intrusions_by_targets=tuple(float(x.mean()) if x.size else None for x in by_number),
    )
