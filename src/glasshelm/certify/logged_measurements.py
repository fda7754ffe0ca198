"""Bands of logged frames: the plots behind a frame stand in it and in the four before it.

A frame holds what was measured (places, heading, courses, speeds), rounded to a micrometre and a
microradian (:data:`glasshelm.simulation.frame_builder.DECIMALS`), so nothing but the log is needed.
The pilot checks that these are the plots it decided on: it has to decide the same again.
"""

import math
from collections import deque
from collections.abc import Iterable, Iterator, Sequence

import equinox as eqx
import jax.numpy as jnp
import msgspec
import numpy as np
from jaxtyping import Array, Float

from glasshelm.certify.measurements import RawPlots, observe_plots
from glasshelm.certify.rudder_band import RudderBand, action_bounds, require_sum_actor
from glasshelm.certify.sensor_error_bounds import SensorErrorBounds
from glasshelm.core.errors import InputError
from glasshelm.env.observe import FRAMES
from glasshelm.env.target_selection import MAX_TARGETS
from glasshelm.frames import schema as f
from glasshelm.frames.frame_log import is_episode_start
from glasshelm.frames.schema import Frame
from glasshelm.networks.actors import SumActor
from glasshelm.pilots.protocols import Pilot

#: Bounds of a band at most.
MAX_CELLS = 17
#: Programs are compiled for so many ships.
SLOTS = (8, MAX_TARGETS)
#: A rudder decided again is the same within this, a fraction of the limit.
SAME = 2e-3

Plots = Float[np.ndarray, "frames 6"]


def plots_from_frames(frames: Sequence[Frame]) -> RawPlots:
    """The plots behind the last of these frames, as the pilot remembered them (Eq. 12).

    Of the targets that it was shown, each as far back as it was there without a gap.
    """
    last = len(frames) - 1
    observation = [frames[last]]
    while len(observation) <= min(last, FRAMES - 1) and not is_episode_start(
        frames, last - len(observation) + 1
    ):
        observation.append(frames[last - len(observation)])
    shown = [t.id for t in observation[0].targets if t.selected and not t.lost]
    slots = next(slots for slots in SLOTS if slots >= len(shown))
    targets = np.zeros((slots, FRAMES, 6), np.float32)
    for slot, id in enumerate(shown):
        targets[slot] = _remembered([_target_plot(frame, id) for frame in observation])
    waypoint = _remembered([_plot(frame, frame.waypoint) for frame in observation])
    present = np.arange(slots) < len(shown)
    return RawPlots(jnp.asarray(waypoint), jnp.asarray(targets), jnp.asarray(present))


def _remembered(rows: list[list[float] | None]) -> Plots:
    """Plots, newest first, until one is missing; the oldest is repeated."""
    known = rows[: rows.index(None)] if None in rows else rows
    return np.asarray([*known, *[known[-1]] * (FRAMES - len(known))], np.float32)


def _target_plot(frame: Frame, id: str) -> list[float] | None:
    target = next((t for t in frame.targets if t.id == id and not t.lost), None)
    return None if target is None else _plot(frame, target, target.course_rad, target.speed_m_s)


def _plot(
    frame: Frame, place: f.Waypoint | f.Target, course_rad: float = 0.0, speed_m_s: float = 0.0
) -> list[float]:
    own = frame.own
    east_m, north_m = place.east_m - own.east_m, place.north_m - own.north_m
    return [east_m, north_m, own.heading_rad, own.speed_m_s, course_rad, speed_m_s]


def band_of_frames(
    frames: Sequence[Frame], pilot: Pilot, errors: SensorErrorBounds, cells: int = MAX_CELLS
) -> f.Band:
    """The certified band of the last of these frames, decided by this pilot.

    The four frames before it are needed where there were any. InputError if the
    pilot's actor is not a sum, or does not decide the same of these plots.
    """
    actor, frame, scene = require_sum_actor(pilot), frames[-1], plots_from_frames(frames)
    limit = frame.ship.rudder_limit_rad
    decided = math.nan if frame.decision is None else frame.decision.rudder_rad / limit
    if not abs(float(_again(actor, scene)) - decided) <= SAME:
        raise InputError(f"{pilot.name} did not decide this rudder on these five frames")
    one = RawPlots(scene.waypoint[None], scene.targets[None], scene.present[None])
    low, high = (
        float(x[0]) * limit for x in action_bounds(actor, one, errors.as_sensor_errors(), cells)
    )
    side = {1: "starboard", -1: "port", 0: None}[RudderBand(low, high).certain_side]
    return f.Band(low, high, errors.position_m, errors.course_rad, errors.speed_m_s, side)


@eqx.filter_jit
def _again(actor: SumActor, scene: RawPlots) -> Float[Array, ""]:
    return actor(observe_plots(scene))


def with_bands(
    frames: Iterable[Frame], pilot: Pilot, errors: SensorErrorBounds, cells: int = MAX_CELLS
) -> Iterator[Frame]:
    """The frames of a voyage, each with its band. InputError as :func:`band_of_frames`, at once."""
    require_sum_actor(pilot)

    def banded() -> Iterator[Frame]:
        recent: deque[Frame] = deque(maxlen=FRAMES)
        for frame in frames:
            recent.append(frame)
            band = band_of_frames(list(recent), pilot, errors, cells)
            yield msgspec.structs.replace(frame, band=band)

    return banded()
