"""From legs on the host to the fixed slots of a :class:`Track`."""

import dataclasses
from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float64

from glasshelm.encounters.types import Track


@dataclasses.dataclass(frozen=True)
class TrackColumns:
    """The legs of one target in order of time, on the host in double precision (SI units)."""

    start_s: Float64[np.ndarray, " legs"]
    end_s: Float64[np.ndarray, " legs"]
    east_m: Float64[np.ndarray, " legs"]
    north_m: Float64[np.ndarray, " legs"]
    course_rad: Float64[np.ndarray, " legs"]
    speed_m_s: Float64[np.ndarray, " legs"]

    @staticmethod
    def of(
        start_s: Sequence[float | int] | np.ndarray,
        east_m: Sequence[float | int] | np.ndarray,
        north_m: Sequence[float | int] | np.ndarray,
        course_rad: Sequence[float | int] | np.ndarray,
        speed_m_s: Sequence[float | int] | np.ndarray,
        leg_duration_s: float = np.inf,
    ) -> "TrackColumns":
        """A row whose legs each end ``leg_duration_s`` after they begin."""
        start, east, north, course, speed = (
            np.asarray(x, np.float64) for x in (start_s, east_m, north_m, course_rad, speed_m_s)
        )
        return TrackColumns(start, start + leg_duration_s, east, north, course, speed)


def stack_tracks(rows: Sequence[TrackColumns]) -> Track:
    """One track a row, padded with legs that never start; no rows give a track of no slots."""
    legs = max((len(row.start_s) for row in rows), default=1)
    stacked = {}
    for field in dataclasses.fields(TrackColumns):
        empty = np.inf if field.name.endswith("_s") and field.name != "speed_m_s" else 0.0
        block = np.full((len(rows), legs), empty)
        for i, row in enumerate(rows):
            values = getattr(row, field.name)
            block[i, : len(values)] = values
        stacked[field.name] = jnp.asarray(block, jnp.float32)
    return Track(**stacked)


def single_track(row: TrackColumns) -> Track:
    """The track of one ship, without the axis of slots."""
    stacked = stack_tracks([row])
    return Track(**{f.name: getattr(stacked, f.name)[0] for f in dataclasses.fields(Track)})
