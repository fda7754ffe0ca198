"""What an evaluation is made of: suites of cases."""

import dataclasses

import jax
import numpy as np

from glasshelm.encounters.types import TargetInfo
from glasshelm.simulation.rollout import Case


@dataclasses.dataclass(frozen=True)
class Suite:
    """Cases of one kind as a batch, with what people call them.

    ``cases`` has an axis of cases in front of every array; ``labels`` are their
    names, where there is one a source that ``glasshelm run`` understands.
    ``note`` says in a sentence what the suite is. ``targets`` names the ships of each
    case where they have names.
    """

    name: str
    note: str
    cases: Case
    labels: tuple[str, ...]
    targets: tuple[tuple[TargetInfo, ...], ...] | None = None

    @property
    def size(self) -> int:
        return len(self.labels)

    def take(self, indices: np.ndarray) -> Case:
        """Some of the cases, as a batch."""
        return jax.tree.map(lambda x: np.asarray(x)[indices], self.cases)
