"""What can steer: the one small interface behind which every pilot stands."""

from typing import Any, Protocol, runtime_checkable

from jaxtyping import Array, Float

from glasshelm.env.observe import Observation
from glasshelm.planning.cross_entropy_search import KnownEncounter

#: What a pilot carries from one decision to the next: any pytree, () for none.
Memory = Any


@runtime_checkable
class Pilot(Protocol):
    """A pytree that turns an observation into a rudder.

    ``steer`` is written for one observation, pure and traceable: batches are
    made by ``vmap``, and the same pilot sails one ship on a page and ten
    thousand encounters in a table.
    """

    @property
    def name(self) -> str:
        """What people call it."""
        ...

    def start(self) -> Memory:
        """The memory before the first decision."""
        ...

    def steer(self, observation: Observation, memory: Memory) -> tuple[Float[Array, ""], Memory]:
        """The rudder as a fraction of the limit in [−1, 1], starboard positive; the new memory."""
        ...


@runtime_checkable
class BatchPolicy(Protocol):
    """Who steers a batch of worlds that are in step with each other."""

    def start(self, worlds: int) -> Memory:
        """The memory of all before the first decision."""
        ...

    def __call__(
        self, observation: Observation, memory: Memory
    ) -> tuple[Float[Array, " w"], Memory]:
        """The rudders of all as fractions of the limit; the new memory."""
        ...


@runtime_checkable
class OraclePilot(Protocol):
    """What cannot steer by what it sees: it must know each encounter beforehand."""

    @property
    def name(self) -> str:
        """What people call it."""
        ...

    def knowing(self, known: KnownEncounter) -> BatchPolicy:
        """Who steers a batch of encounters, knowing all of each."""
        ...
