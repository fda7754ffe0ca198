"""What an encounter is: own ship's start and route, and the tracks of the targets.

Simulated, designed and recorded traffic share one form. A target's track is a
row of *legs*, each a constant course and speed from a known place and time:
one leg for a straight runner, one a waypoint for a DNV situation, one a report
for AIS (dead reckoning from the latest report until it is too old).
"""

import dataclasses
from datetime import datetime

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from glasshelm.core.geometry import Vector, velocity
from glasshelm.core.text import printable, safe_name
from glasshelm.ship.nomoto import ShipParams, ShipState


class Track(eqx.Module):
    """Piecewise straight motion. Legs are in order of time on the last axis.

    A leg holds from ``start_s`` until the next leg's start, but not beyond its
    own ``end_s``: outside every leg the target is not present (not yet received, or
    lost). Unused legs start at +inf.
    """

    start_s: Float[Array, "*n legs"]
    end_s: Float[Array, "*n legs"]
    east_m: Float[Array, "*n legs"]
    north_m: Float[Array, "*n legs"]
    course_rad: Float[Array, "*n legs"]
    speed_m_s: Float[Array, "*n legs"]


class Motion(eqx.Module):
    """Targets at one instant. ``age_s`` is the time since the leg began (AIS: since the report)."""

    east_m: Float[Array, "*n"]
    north_m: Float[Array, "*n"]
    course_rad: Float[Array, "*n"]
    speed_m_s: Float[Array, "*n"]
    age_s: Float[Array, "*n"]
    present: Bool[Array, "*n"]


class Encounter(eqx.Module):
    """All that the environment needs for a reset: a pytree of fixed slots.

    Attributes:
        own: Own ship's initial state.
        route: Its waypoints in order (east, north; [m]).
        targets: One track a slot.
        present: Which slots hold a ship.
    """

    own: ShipState
    route: Vector
    targets: Track
    present: Bool[Array, " n"]


@dataclasses.dataclass(frozen=True)
class TargetInfo:
    """The identity of a target: for people, never for the pilot.

    Whatever a ship is called, ``name`` is safe to show (:mod:`glasshelm.core.text`).
    """

    id: str
    name: str
    length_m: float | None = None
    ship_type: str | None = None

    def __post_init__(self) -> None:
        _set(self, id=printable(self.id), name=safe_name(self.name))
        if self.ship_type is not None:
            _set(self, ship_type=safe_name(self.ship_type))


@dataclasses.dataclass(frozen=True)
class Scenario:
    """An encounter with what people want to know of it.

    Every text is safe to show, whatever the source holds (:mod:`glasshelm.core.text`).

    Attributes:
        ship: Own ship.
        duration_s: How long the encounter lasts, by its source.
        own_track: Own ship's recorded motion, if there is one.
        own_rudder: Whether own ship's initial rudder angle is from a sensor.
        origin: Latitude and longitude [deg] of (0, 0).
        start: The time of t = 0 (UTC).
        notes: What was repaired, dropped or assumed while reading.
    """

    source: str
    title: str
    encounter: Encounter
    targets: tuple[TargetInfo, ...]
    ship: ShipParams
    duration_s: float
    own_name: str = "own ship"
    own_track: Track | None = None
    own_rudder: bool = False
    origin: tuple[float, float] | None = None
    start: datetime | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _set(
            self,
            source=printable(self.source),
            title=safe_name(self.title),
            own_name=safe_name(self.own_name),
            notes=tuple(map(printable, self.notes)),
        )


def _set(info: TargetInfo | Scenario, **fields: object) -> None:
    for name, value in fields.items():
        object.__setattr__(info, name, value)


def with_dimensions(
    ship: ShipParams,
    length_m: float | None,
    beam_m: float | None,
    speed_m_s: float | Float[Array, ""],
) -> ShipParams:
    """A ship with another speed and, where known, length and beam; the beam scales with length."""
    loa = length_m or float(ship.loa_m)
    beam = beam_m or float(ship.beam_m) * loa / float(ship.loa_m)
    return dataclasses.replace(ship, loa_m=loa, beam_m=beam, speed_m_s=speed_m_s)


def straight_track(
    east_m: Float[Array, "*n"],
    north_m: Float[Array, "*n"],
    course_rad: Float[Array, "*n"],
    speed_m_s: Float[Array, "*n"],
) -> Track:
    """The track of ships that keep course and speed for ever."""
    one = jnp.zeros((*jnp.shape(east_m), 1), jnp.float32)
    east, north, course, speed = (
        jnp.asarray(x, jnp.float32)[..., None] for x in (east_m, north_m, course_rad, speed_m_s)
    )
    return Track(one, one + jnp.inf, east, north, course, speed)


def motion_at(track: Track, time_s: Float[Array, ""]) -> Motion:
    """Where the targets are at an instant: each dead-reckoned along its latest leg."""
    legs = track.start_s.shape[-1]
    if legs == 1:
        leg = jnp.zeros(track.start_s.shape[:-1], jnp.int32)
    else:
        leg = jnp.maximum(jnp.sum(track.start_s <= time_s, axis=-1) - 1, 0)

    def now(values: Float[Array, "*n legs"]) -> Float[Array, "*n"]:
        if legs == 1:
            return values[..., 0]
        return jnp.take_along_axis(values, leg[..., None], axis=-1)[..., 0]

    start, end = now(track.start_s), now(track.end_s)
    present = (start <= time_s) & (time_s < end)
    age = jnp.where(present, time_s - jnp.where(jnp.isfinite(start), start, 0.0), 0.0)
    course, speed = now(track.course_rad), now(track.speed_m_s)
    velocity_now = velocity(course, speed)
    return Motion(
        now(track.east_m) + age * velocity_now.x,
        now(track.north_m) + age * velocity_now.y,
        course,
        speed,
        age,
        present,
    )
