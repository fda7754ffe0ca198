"""What own ship is to each target under the COLREGs, frame by frame.

The kinds, and when a meeting begins, are those of the examination
(:mod:`glasshelm.colregs.classification`): the kind is taken at the first risk of
collision and stays until the closest approach is past. Read from frames alone,
so a replay says the same as the voyage did.
"""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from glasshelm.bridge.server.protocol import EncounterStatus
from glasshelm.colregs.classification import STOPPED_M_S, Kind, Meetings
from glasshelm.core.geometry import velocity, wrap_angle
from glasshelm.encounters.types import Motion
from glasshelm.env.padding import bucket_size
from glasshelm.frames.schema import Frame, Target
from glasshelm.ship.nomoto import ShipState

#: Rules 13-15 name the meeting; who stands on obeys Rule 17.
_TOLD = {
    Kind.NONE: EncounterStatus("none", "none", None),
    Kind.HEAD_ON: EncounterStatus("head-on", "give-way", "14"),
    Kind.CROSSING_GIVE_WAY: EncounterStatus("crossing", "give-way", "15"),
    Kind.CROSSING_STAND_ON: EncounterStatus("crossing", "stand-on", "17"),
    Kind.OVERTAKING: EncounterStatus("overtaking", "give-way", "13"),
    Kind.OVERTAKEN: EncounterStatus("overtaken", "stand-on", "17"),
}


class EncounterTracker:
    """Follows the meetings of a voyage."""

    def __init__(self) -> None:
        self._ids: list[str] = []
        self._meetings = Meetings.none(0)
        self._heading_rad: float | None = None
        #: The kind of each meeting in the frame seen last, by the target's id.
        self.kinds: dict[str, Kind] = {}

    def see(self, frame: Frame) -> dict[str, EncounterStatus]:
        """What own ship is to each target that is shown, by the target's id."""
        targets = frame.targets
        slots = bucket_size(len(targets))
        before = self._moved([t.id for t in targets], slots)
        last = frame.own.heading_rad if self._heading_rad is None else self._heading_rad
        after, told = _after(
            before,
            _own(frame),
            wrap_angle(jnp.float32(frame.own.heading_rad - last)),
            _motion(targets, slots),
            jnp.float32(frame.time_s),
        )
        self._meetings, self._heading_rad = after, frame.own.heading_rad
        self._ids = [t.id for t in targets]
        kinds = np.asarray(told)[: len(targets)].tolist()
        self.kinds = {t.id: Kind(kind) for t, kind in zip(targets, kinds, strict=True)}
        return {id: _TOLD[kind] for id, kind in self.kinds.items()}

    def _moved(self, ids: list[str], slots: int) -> Meetings:
        """The meetings so far in the slots of these ships; new ships have none."""
        place = {id: k for k, id in enumerate(self._ids)}
        found = [(k, place[id]) for k, id in enumerate(ids) if id in place]
        to, of = [k for k, _ in found], [k for _, k in found]

        def move(empty: Array, known: Array) -> Array:
            row = np.array(empty)
            row[to] = np.asarray(known)[of]
            return jnp.asarray(row)

        return jax.tree.map(move, Meetings.none(slots), self._meetings)


@jax.jit
def _after(
    before: Meetings,
    own: ShipState,
    turn_rad: Float[Array, ""],
    targets: Motion,
    time_s: Float[Array, ""],
) -> tuple[Meetings, Array]:
    """The meetings after one more frame, and the kinds of those that are not past.

    A meeting that is past is forgotten: a new risk is a new meeting. So is one with a ship
    that has stopped since, or if own ship has.
    """
    after = before.after(own, velocity(own.heading_rad, own.speed_m_s), turn_rad, targets, time_s)
    none = Meetings.none(after.kind.shape[0])
    stopped = jnp.minimum(targets.speed_m_s, own.speed_m_s) < STOPPED_M_S
    over = after.past | (targets.present & stopped)
    kept = jax.tree.map(lambda x, empty: jnp.where(over, empty, x), after, none)
    return kept, kept.kind


def _own(frame: Frame) -> ShipState:
    own = frame.own
    return ShipState.steady(own.east_m, own.north_m, own.heading_rad, own.speed_m_s)


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
