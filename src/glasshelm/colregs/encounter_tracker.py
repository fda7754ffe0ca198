"""The encounter type of each target, frame by frame.

The type is taken at the first risk of collision and stays until the closest approach is past, as
in the evaluation (:class:`glasshelm.colregs.compliance.MeetingFacts`). Only frames are read, so a
replay tells the same as the voyage did.
"""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from glasshelm.colregs.classification import STOPPED_M_S, EncounterType
from glasshelm.colregs.compliance import MeetingFacts
from glasshelm.core.geometry import velocity, wrap_angle
from glasshelm.encounters.types import Motion
from glasshelm.env.padding import bucket_size
from glasshelm.frames.schema import Frame, Target
from glasshelm.ship.nomoto import ShipState


class EncounterTracker:
    """Follows the encounters of a voyage.

    Attributes:
        types: The encounter type of each target of the last frame, by its id.
    """

    def __init__(self) -> None:
        self.types: dict[str, EncounterType] = {}
        self._facts = MeetingFacts.initial(0)
        self._heading_rad: float | None = None

    def update(self, frame: Frame) -> dict[str, EncounterType]:
        """Take in the next frame; returns :attr:`types`."""
        ids, heading_rad = [t.id for t in frame.targets], frame.own.heading_rad
        slots = bucket_size(len(ids))
        turn_rad = 0.0 if self._heading_rad is None else heading_rad - self._heading_rad
        self._facts = _step(
            self._in_slots_of(ids, slots),
            ShipState.steady(frame.own.east_m, frame.own.north_m, heading_rad, frame.own.speed_m_s),
            wrap_angle(jnp.float32(turn_rad)),
            _motion(frame.targets, slots),
            jnp.float32(frame.time_s),
        )
        self._heading_rad = heading_rad
        types = np.asarray(self._facts.kind)[: len(ids)].tolist()
        self.types = dict(zip(ids, map(EncounterType, types), strict=True))
        return self.types

    def _in_slots_of(self, ids: Sequence[str], slots: int) -> MeetingFacts:
        """The facts so far, in the slots of these targets; new targets have none."""
        slot_of = {id: slot for slot, id in enumerate(self.types)}
        new = [slot for slot, id in enumerate(ids) if id in slot_of]
        old = [slot_of[ids[slot]] for slot in new]

        def move(empty: Array, known: Array) -> Array:
            row = np.array(empty)
            row[new] = np.asarray(known)[old]
            return jnp.asarray(row)

        return jax.tree.map(move, MeetingFacts.initial(slots), self._facts)


@jax.jit
def _step(
    facts: MeetingFacts,
    own: ShipState,
    turn_rad: Float[Array, ""],
    targets: Motion,
    time_s: Float[Array, ""],
) -> MeetingFacts:
    """The facts after one more frame, without those of encounters that are over.

    An encounter is over when the closest approach is past, or when either ship has stopped;
    another risk of collision begins a new one.
    """
    after = facts.updated(own, velocity(own.heading_rad, own.speed_m_s), turn_rad, targets, time_s)
    stopped = jnp.minimum(targets.speed_m_s, own.speed_m_s) < STOPPED_M_S
    over = after.past | (targets.present & stopped)
    none = MeetingFacts.initial(over.shape[0])
    return jax.tree.map(lambda x, empty: jnp.where(over, empty, x), after, none)


def _motion(targets: Sequence[Target], slots: int) -> Motion:
    def row(values: list[float]) -> Array:
        return jnp.asarray(np.pad(np.asarray(values, np.float32), (0, slots - len(targets))))

    return Motion(
        row([t.east_m for t in targets]),
        row([t.north_m for t in targets]),
        row([t.course_rad for t in targets]),
        row([t.speed_m_s for t in targets]),
        jnp.zeros(slots),
        jnp.asarray([not t.lost for t in targets] + [False] * (slots - len(targets)), bool),
    )
