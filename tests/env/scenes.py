"""Small scenes, and the whole scene moved, turned or mirrored."""

import dataclasses
import functools
import math

import jax
import jax.numpy as jnp

from glasshelm.core.geometry import Vector, to_world
from glasshelm.encounters.random_encounters import PAPER, random_encounter
from glasshelm.encounters.types import Encounter, Track, straight_track
from glasshelm.env.step import EnvSettings, StepResult, reset, step
from glasshelm.ship.nomoto import SHIPS, ShipState

SHIP = SHIPS["paper"]


def scene(
    targets: list[tuple[float, float, float, float]],
    route: list[tuple[float, float]] = [(0.0, 40_000.0)],  # noqa: B006
    present: list[bool] | None = None,
    heading_deg: float = 0.0,
) -> Encounter:
    """Own ship at the origin; targets as (east, north, course in degrees, speed)."""
    rows = jnp.asarray(targets, jnp.float32).reshape(-1, 4)
    points = jnp.asarray(route, jnp.float32)
    return Encounter(
        ShipState.steady(0.0, 0.0, math.radians(heading_deg), SHIP.speed_m_s),
        Vector(points[:, 0], points[:, 1]),
        straight_track(rows[:, 0], rows[:, 1], jnp.radians(rows[:, 2]), rows[:, 3]),
        jnp.asarray([True] * len(targets) if present is None else present, bool),
    )


@jax.jit
def _random_scene(seed, count) -> Encounter:
    return random_encounter(jax.random.key(seed), SHIP, PAPER, count)


def random_scene(seed: int, count: int = 4) -> Encounter:
    return _random_scene(seed, count)


def turned(encounter: Encounter, angle_rad: float, east_m: float, north_m: float) -> Encounter:
    """The whole scene turned clockwise about the origin, then moved."""

    def place(east, north) -> Vector:
        v = to_world(Vector(east, north), jnp.float32(angle_rad))
        return Vector(v.x + east_m, v.y + north_m)

    own, track = encounter.own, encounter.targets
    own_at, track_at = place(own.east_m, own.north_m), place(track.east_m, track.north_m)
    return Encounter(
        dataclasses.replace(
            own, east_m=own_at.x, north_m=own_at.y, heading_rad=own.heading_rad + angle_rad
        ),
        place(encounter.route.x, encounter.route.y),
        dataclasses.replace(
            track,
            east_m=track_at.x,
            north_m=track_at.y,
            course_rad=track.course_rad + angle_rad,
        ),
        encounter.present,
    )


def mirrored(encounter: Encounter) -> Encounter:
    """East for west."""
    own, track = encounter.own, encounter.targets
    return Encounter(
        dataclasses.replace(own, east_m=-own.east_m, heading_rad=-own.heading_rad),
        Vector(-encounter.route.x, encounter.route.y),
        dataclasses.replace(track, east_m=-track.east_m, course_rad=-track.course_rad),
        encounter.present,
    )


def legs(*rows: tuple[float, float, float, float, float, float]) -> Track:
    """One target of several legs: (start, end, east, north, course in degrees, speed)."""
    columns = jnp.asarray(rows, jnp.float32).T[:, None, :]
    return Track(*columns[:4], jnp.radians(columns[4]), columns[5])


begin_jitted = jax.jit(lambda encounter: reset(encounter, SHIP))


@functools.partial(jax.jit, static_argnames="settings")
def _sail(encounter: Encounter, rudders, settings: EnvSettings) -> StepResult:
    def go(state, rudder):
        out = step(encounter, state, rudder, SHIP, settings)
        return out.state, out

    return jax.lax.scan(go, reset(encounter, SHIP), rudders)[1]


def sail(encounter: Encounter, rudders, settings: EnvSettings = EnvSettings()) -> StepResult:
    """The outcomes of a row of rudder commands, one a step."""
    return _sail(encounter, jnp.asarray(rudders, jnp.float32), settings)
