"""A list of frames as arrays over time: what every figure and the report read.

SI units, as in the frames. A quantity that a frame does not have is NaN here,
so that a line breaks there instead of falling to zero.
"""

import dataclasses
import functools
import math
from collections.abc import Sequence
from datetime import datetime

import numpy as np
from jaxtyping import Float

from glasshelm.core.errors import InputError
from glasshelm.frames.schema import BySubTask, Frame, Target

TimeSeries = Float[np.ndarray, " t"]


@dataclasses.dataclass(frozen=True, eq=False)
class ShipSeries:
    """One target over time; NaN where she is absent or lost.

    ``starboard_m`` and ``ahead_m`` are her position in own ship's body frame;
    the others carry the names and units of :class:`glasshelm.frames.schema.Target`.
    """

    id: str
    name: str
    east_m: TimeSeries
    north_m: TimeSeries
    course_rad: TimeSeries
    speed_m_s: TimeSeries
    range_m: TimeSeries
    bearing_rad: TimeSeries
    dcpa_m: TimeSeries
    tcpa_s: TimeSeries
    danger: TimeSeries
    q: TimeSeries
    q_far: TimeSeries
    priority: TimeSeries
    attention: TimeSeries
    intention: TimeSeries
    intention_level: TimeSeries
    shapley_rad: TimeSeries
    leave_one_out_rad: TimeSeries

    @property
    def starboard_m(self) -> TimeSeries:
        return self.range_m * np.sin(self.bearing_rad)

    @property
    def ahead_m(self) -> TimeSeries:
        return self.range_m * np.cos(self.bearing_rad)

    @property
    def critic_danger(self) -> TimeSeries:
        """How much lower the critic values this ship than one far off: Q_far − Q_ca."""
        return self.q_far - self.q

    @property
    def leave_one_out_deg(self) -> TimeSeries:
        return np.degrees(self.leave_one_out_rad)

    def has(self, field: str) -> bool:
        """Whether any frame gives this quantity for this ship."""
        return bool(np.isfinite(getattr(self, field)).any())

    @property
    def nearest(self) -> int:
        """The frame of the smallest range; the ship must have been there."""
        return int(np.nanargmin(self.range_m))


@dataclasses.dataclass(frozen=True, eq=False)
class Series:
    """A voyage over time: own ship, the decision, the values, and every target.

    ``heading_rad`` runs on through ±π; ``rudder_rad`` is the decided rudder, or
    the ship's own where there is no decision, ``base_rad`` what it would be with no
    other ship; ``waypoint_bearing_rad`` is the bearing of the waypoint relative to the
    heading, in [−π, π).
    """

    frames: tuple[Frame, ...]
    time_s: TimeSeries
    east_m: TimeSeries
    north_m: TimeSeries
    heading_rad: TimeSeries
    speed_m_s: TimeSeries
    rudder_rad: TimeSeries
    base_rad: TimeSeries
    waypoint_bearing_rad: TimeSeries
    priority_waypoint: TimeSeries
    priority_collision: TimeSeries
    value_waypoint: TimeSeries
    value_collision: TimeSeries
    ships: tuple[ShipSeries, ...]

    @property
    def minutes(self) -> TimeSeries:
        return (self.time_s - self.time_s[0]) / 60.0

    @property
    def applied(self) -> bool:
        """False where the pilot only advised: own ship went her own way."""
        return all(f.decision is None or f.decision.applied for f in self.frames)

    @property
    def start_utc(self) -> datetime | None:
        """The clock at the first frame, if the source has one."""
        text = self.frames[0].time_utc
        return None if text is None else datetime.fromisoformat(text)

    def at(self, time_s: float) -> int:
        """The frame nearest to a time."""
        return int(np.argmin(np.abs(self.time_s - time_s)))

    def has(self, field: str) -> bool:
        """Whether any frame gives this quantity for any target (or for own ship)."""
        own = getattr(self, field, None)
        if isinstance(own, np.ndarray):
            return bool(np.isfinite(own).any())
        return any(ship.has(field) for ship in self.ships)


Frames = Sequence[Frame] | Series

_SHIP_FIELDS = tuple(f.name for f in dataclasses.fields(ShipSeries) if f.name not in ("id", "name"))


def to_series(frames: Frames) -> Series:
    """Frames as arrays; a Series is returned as it is. InputError if there is no frame."""
    if isinstance(frames, Series):
        return frames
    if not frames:
        raise InputError("no frames: the voyage is empty, there is nothing to draw or to tell")
    own = [f.own for f in frames]
    east, north = _row(o.east_m for o in own), _row(o.north_m for o in own)
    heading = _row(o.heading_rad for o in own)
    to_waypoint = np.arctan2(
        _row(f.waypoint.east_m for f in frames) - east,
        _row(f.waypoint.north_m for f in frames) - north,
    )
    return Series(
        frames=tuple(frames),
        time_s=_row(f.time_s for f in frames),
        east_m=east,
        north_m=north,
        heading_rad=np.unwrap(heading),
        speed_m_s=_row(o.speed_m_s for o in own),
        rudder_rad=_row(
            f.own.rudder_rad if f.decision is None else f.decision.rudder_rad for f in frames
        ),
        base_rad=_row(
            math.nan if f.decision is None or f.decision.base_rad is None else f.decision.base_rad
            for f in frames
        ),
        waypoint_bearing_rad=np.mod(to_waypoint - heading + math.pi, 2 * math.pi) - math.pi,
        priority_waypoint=_task(frames, "priority", "waypoint"),
        priority_collision=_task(frames, "priority", "collision"),
        value_waypoint=_task(frames, "value", "waypoint"),
        value_collision=_task(frames, "value", "collision"),
        ships=_ships(frames),
    )


def _ships(frames: Sequence[Frame]) -> tuple[ShipSeries, ...]:
    """Every target that was seen at least once, in order of first sight."""
    names: dict[str, str] = {}
    columns: dict[str, dict[str, TimeSeries]] = {}
    for k, frame in enumerate(frames):
        for target in frame.targets:
            if target.lost:
                continue
            names[target.id] = target.name
            rows = columns.setdefault(target.id, _empty(len(frames)))
            for field in _SHIP_FIELDS:
                rows[field][k] = _number(target, field)
    return tuple(ShipSeries(id=i, name=names[i], **rows) for i, rows in columns.items())


def _empty(length: int) -> dict[str, TimeSeries]:
    return {field: np.full(length, np.nan) for field in _SHIP_FIELDS}


def _number(target: Target, field: str) -> float:
    value = getattr(target, field)
    return math.nan if value is None else value


def _row(values) -> TimeSeries:
    return np.array([math.nan if v is None else v for v in values], dtype=float)


def _task(frames: Sequence[Frame], part: str, task: str) -> TimeSeries:
    parts: list[BySubTask | None] = [getattr(f, part) for f in frames]
    return _row(None if p is None else getattr(p, task) for p in parts)


@functools.lru_cache(maxsize=8)
def ships_of_note(voyage: Series, most: int = 6) -> tuple[ShipSeries, ...]:
    """The ships that a figure names, at most ``most`` of them, in order of first sight.

    Where there are more, those stay that ever had the largest priority, up or
    down, beside those that came nearest: rank by each, the better rank counts.
    """
    if len(voyage.ships) <= most:
        return voyage.ships
    near = sorted(voyage.ships, key=lambda s: float(np.nanmin(s.range_m)))
    swayed = [s for s in voyage.ships if s.has("priority")]
    swayed.sort(key=lambda s: -float(np.nanmax(np.abs(s.priority))))
    rank = {s.id: near.index(s) for s in near}
    for place, ship in enumerate(swayed):
        rank[ship.id] = min(rank[ship.id], place)
    kept = sorted(near, key=lambda s: rank[s.id])[:most]
    return tuple(s for s in voyage.ships if s in kept)
