"""What an examination is made of: cases, and the suites that hold them."""

import dataclasses

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float, Int

from glasshelm.encounters.types import Encounter, TargetInfo
from glasshelm.evaluation.sensor_model import Disturbance
from glasshelm.ship.nomoto import ShipParams

#: Numbers of a batch live on the host until they are sailed.
Real = Float[Array, "..."] | Float[np.ndarray, "..."]


class Case(eqx.Module):
    """One question of the examination: an encounter and the ship that is truly sailed.

    ``steps`` is how many steps of 5 s count; ``length_m`` and ``beam_m`` are the
    targets' hulls; ``disturbance`` is what own ship's instruments make of the
    world, None where the pilot sees it as it is. A batch has one more axis in front.
    """

    encounter: Encounter
    ship: ShipParams
    steps: Int[Array, "*b"] | Int[np.ndarray, "*b"]
    length_m: Real
    beam_m: Real
    disturbance: Disturbance | None = None


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
