"""Bands of logged frames: the plots behind a frame stand in it and in the four before it.

A frame holds what was measured (places, heading, courses, speeds), rounded to a micrometre and a
microradian (:data:`glasshelm.simulation.frame_builder.DECIMALS`), so nothing but the log is needed.
The pilot checks that these are the plots it decided on: it has to decide the same again.
"""

import math
from collections import deque
from collections.abc import Iterable, Iterator, Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import msgspec
import numpy as np
from jaxtyping import Array, Float

from glasshelm.certify.manoeuvre_band import (
    ManoeuvreBand,
    ValueBounds,
    certified_choice,
    require_simulated_critic,
)
from glasshelm.certify.measurements import RawPlots, observe_plots
from glasshelm.certify.rudder_band import RudderBand, action_bounds, require_sum_actor
from glasshelm.certify.sensor_error_bounds import SensorErrorBounds
from glasshelm.core.errors import InputError
from glasshelm.env.observe import FRAMES
from glasshelm.env.target_selection import MAX_TARGETS
from glasshelm.explanation.step_explanation import ALTERNATIVES
from glasshelm.frames import schema as f
from glasshelm.frames.frame_log import is_episode_start
from glasshelm.frames.schema import Frame
from glasshelm.networks.actors import SumActor
from glasshelm.pilots.glassbox import GlassboxPilot
from glasshelm.pilots.protocols import Pilot
from glasshelm.simulation.frame_builder import ship_params

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


def require_certifiable(pilot: Pilot) -> None:
    """InputError if there are no bounds for this pilot."""
    if isinstance(pilot, GlassboxPilot):
        require_simulated_critic(pilot)
    else:
        require_sum_actor(pilot)


def band_of_frames(
    frames: Sequence[Frame], pilot: Pilot, errors: SensorErrorBounds, cells: int = MAX_CELLS
) -> f.Band:
    """The certified band of the last of these frames, decided by this pilot.

    Args:
        frames: The four frames before it are needed where there were any.
        pilot: A sum actor, or a pilot that chooses among simulated manoeuvres.
        errors: The largest errors of the sensors.
        cells: Bounds of a rudder at most; manoeuvres have one each.

    Returns:
        The band.

    Raises:
        InputError: There are no bounds for this pilot, or it does not decide the same of these
            plots.
    """
    require_certifiable(pilot)
    frame, scene, sensors = frames[-1], plots_from_frames(frames), errors.as_sensor_errors()
    limit = frame.ship.rudder_limit_rad
    if isinstance(pilot, GlassboxPilot):
        pilot = pilot.for_ship(ship_params(frame.ship))
        band = jax.device_get(certified_choice(pilot, scene, sensors))
        again, low, high = (float(x) for x in (band.rudder, band.rudder_low, band.rudder_high))
        manoeuvre = _choice(frame, band)
    else:
        actor = require_sum_actor(pilot)
        again, manoeuvre = float(_again(actor, scene)), None
        one = RawPlots(scene.waypoint[None], scene.targets[None], scene.present[None])
        low, high = (float(x[0]) for x in action_bounds(actor, one, sensors, cells))
    decided = math.nan if frame.decision is None else frame.decision.rudder_rad / limit
    if not abs(again - decided) <= SAME:
        raise InputError(f"{pilot.name} did not decide this rudder on these five frames")
    low, high = low * limit, high * limit
    side = {1: "starboard", -1: "port", 0: None}[RudderBand(low, high).certain_side]
    return f.Band(
        low, high, errors.position_m, errors.course_rad, errors.speed_m_s, side, manoeuvre
    )


def _choice(frame: Frame, band: ManoeuvreBand) -> f.ManoeuvreBand:
    """The band of the chosen manoeuvre, in the terms of its frame."""
    row, shown = int(band.chosen), [t.id for t in frame.targets if t.selected and not t.lost]
    heading = frame.own.heading_rad
    numbers = zip(
        shown,
        band.low.by_ship[row],
        band.high.by_ship[row],
        band.margin[row],
        band.range_m[row],
        strict=False,  # empty slots follow
    )
    targets = [
        f.TargetBand(id, float(low), float(high), float(depth), float(range_m))
        for id, low, high, depth, range_m in numbers
    ]
    compared = zip(ALTERNATIVES, band.rows, band.compared, strict=True)
    alternatives = [
        f.AlternativeBand(name, float(band.gain_low[k]), float(band.gain_high[k]))
        for name, k, there in compared
        if there
    ]
    return f.ManoeuvreBand(
        _by_sub_task(band.low, row),
        _by_sub_task(band.high, row),
        targets,
        alternatives,
        [_true(course + heading) for course in band.possible_courses_rad],
        all(target.depth <= 0.0 for target in targets),
    )


def _by_sub_task(value: ValueBounds, row: int) -> f.BySubTask:
    parts = value.waypoint[row], value.by_ship[row].sum(), value.total[row], value.helm[row]
    return f.BySubTask(*map(float, parts))


def _true(course_rad: float) -> float:
    """A true course in [−π, π)."""
    return float((course_rad + math.pi) % (2 * math.pi) - math.pi)


@eqx.filter_jit
def _again(actor: SumActor, scene: RawPlots) -> Float[Array, ""]:
    return actor(observe_plots(scene))


def with_bands(
    frames: Iterable[Frame], pilot: Pilot, errors: SensorErrorBounds, cells: int = MAX_CELLS
) -> Iterator[Frame]:
    """The frames of a voyage, each with its band. InputError as :func:`band_of_frames`, at once."""
    require_certifiable(pilot)

    def banded() -> Iterator[Frame]:
        recent: deque[Frame] = deque(maxlen=FRAMES)
        for frame in frames:
            recent.append(frame)
            band = band_of_frames(list(recent), pilot, errors, cells)
            yield msgspec.structs.replace(frame, band=band)

    return banded()
