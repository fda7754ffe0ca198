"""The interface of every pilot: it decides on an observation, and says why as far as it can."""

from typing import Any, Protocol, runtime_checkable

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from glasshelm.core.errors import InputError
from glasshelm.env.observe import Observation
from glasshelm.env.training_envelope import TrainingEnvelope
from glasshelm.explanation.step_explanation import Explanation
from glasshelm.planning.lookahead import Lookahead
from glasshelm.ship.nomoto import ShipParams

#: What a pilot carries from one decision to the next: any pytree, () for none.
Memory = Any


class Overruled(eqx.Module):
    """Whether something else (a guard, an order) steers in the pilot's place.

    Attributes:
        active: It does so now.
        pilot_rudder: What the pilot itself decides, a fraction of the limit.
    """

    active: Bool[Array, "*b"]
    pilot_rudder: Float[Array, "*b"]


class GuardStatus(eqx.Module):
    """Of a guarded pilot: whether its guard steers, and where the pilot's own way leads.

    Attributes:
        steers: The guard has the helm.
        lookahead: What lies on the pilot's own way.
        explanation: Why the guard's rudder; all 0 while it does not steer.
    """

    steers: Bool[Array, "*b"]
    lookahead: Lookahead
    explanation: Explanation


class Decision(eqx.Module):
    """The rudder of one step, and what the pilot can say of it.

    Under ``jax.jit`` only what is used is computed: the explanation costs nothing where
    nobody reads it.

    Attributes:
        rudder: A fraction of the limit in [−1, 1], starboard positive: what is steered.
        explanation: Why the pilot's rudder; None for a pilot that cannot say. While a guard
            steers, :attr:`why` holds.
        overruled: Whether the rudder is another than the pilot's own; None if it never is.
        guard: What the guard sees; None without a guard.
    """

    rudder: Float[Array, "*b"]
    explanation: Explanation | None = None
    overruled: Overruled | None = None
    guard: GuardStatus | None = None

    @property
    def why(self) -> Explanation | None:
        """The explanation of what is steered, by the pilot or its guard.

        None where an order has replaced a manoeuvre. Of one decision, on the host.
        """
        if self.guard is not None and self.guard.steers:
            return self.guard.explanation
        of_manoeuvre = self.explanation is not None and self.explanation.manoeuvre is not None
        return None if of_manoeuvre and self.is_ordered else self.explanation

    @property
    def is_ordered(self) -> bool:
        """Whether neither pilot nor guard decides the rudder. Of one decision, on the host."""
        if self.overruled is None or not self.overruled.active:
            return False
        return self.guard is None or not self.guard.steers


@runtime_checkable
class Pilot(Protocol):
    """A pytree that decides on observations.

    ``decide`` is written for one observation, pure and traceable: ``jax.vmap`` makes batches,
    and the same pilot sails one ship on a page and ten thousand encounters in a table.
    A pilot made for one ship says so in an attribute ``ship`` (ShipParams); one for any ship is
    an :class:`AnyShipPilot`, or need not know which.
    """

    @property
    def name(self) -> str:
        """What people call it."""
        ...

    def start(self) -> Memory:
        """The memory before the first decision."""
        ...

    def decide(self, observation: Observation, memory: Memory) -> tuple[Decision, Memory]:
        """The decision on an observation of at most 20 targets, and the new memory.

        Args:
            observation: Eq. 10-12. From more targets than
                :data:`~glasshelm.env.target_selection.MAX_TARGETS`, choose with
                :func:`~glasshelm.env.target_selection.select_targets` first.
            memory: Of the decision before, or :meth:`start`.
        """
        ...


@runtime_checkable
class AnyShipPilot(Pilot, Protocol):
    """A pilot that is given the ship it steers before it decides."""

    def for_ship(self, ship: ShipParams) -> Pilot:
        """The pilot of this ship; itself if it was made for another."""
        ...


def for_ship(pilot: Pilot, ship: ShipParams) -> Pilot:
    """The pilot, given the ship if it is for any."""
    return pilot.for_ship(ship) if isinstance(pilot, AnyShipPilot) else pilot


def check_pilot(pilot: object) -> None:
    """InputError if it is no pilot, with what would be one."""
    if isinstance(pilot, str):
        raise InputError(f"{pilot!r} is a name: glasshelm.pilot({pilot!r}) gives the pilot")
    if not isinstance(pilot, Pilot):
        raise InputError(f"{type(pilot).__name__} is no pilot: it needs name, start and decide")


@runtime_checkable
class TrainedPilot(Pilot, Protocol):
    """A pilot with networks: it can explain any rudder, and knows what it was trained on."""

    @property
    def weights_sha256(self) -> str | None:
        """SHA-256 of the weights file; None if it was made in memory."""
        ...

    @property
    def trained(self) -> TrainingEnvelope:
        """What it was trained on."""
        ...

    def explain(self, observation: Observation, rudder: Float[Array, ""]) -> Explanation:
        """What its networks say of a rudder, be it its own or another."""
        ...


@runtime_checkable
class BatchPolicy(Protocol):
    """What steers a batch of encounters that are in step with each other."""

    def start(self, size: int) -> Memory:
        """The memory of all before the first decision."""
        ...

    def __call__(
        self, observation: Observation, memory: Memory
    ) -> tuple[Float[Array, " w"], Memory]:
        """The rudders of all as fractions of the limit; the new memory."""
        ...


def override(
    pilot: Pilot,
    observation: Observation,
    decision: Decision,
    rudder: Float[Array, ""],
    active: Bool[Array, ""],
) -> Decision:
    """The decision with another rudder in its place while ``active``, and explained as such."""
    own = decision.overruled or Overruled(jnp.zeros_like(active), decision.rudder)
    steered = jnp.where(active, rudder, decision.rudder)
    guard, explanation = decision.guard, decision.explanation
    if isinstance(pilot, TrainedPilot):
        explanation = pilot.explain(observation, steered)
    if guard is not None:
        guard = GuardStatus(guard.steers & ~active, guard.lookahead, guard.explanation)
    return Decision(steered, explanation, Overruled(own.active | active, own.pilot_rudder), guard)
