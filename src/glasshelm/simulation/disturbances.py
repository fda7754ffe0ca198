"""What may differ from what a pilot expects: sensors, traffic, the water, own ship itself.

Each disturbance changes one thing in a batch of cases. Evaluation makes a suite of each, training
learns what they cost.
"""

import dataclasses
from collections.abc import Callable
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from glasshelm.core.geometry import Vector
from glasshelm.encounters.types import Track
from glasshelm.ship.nomoto import KNOT_M_S
from glasshelm.simulation.rollout import Case
from glasshelm.simulation.sensor_model import Disturbance

#: AIS: a satellite position to 10 m (standard deviation on each axis), course over ground to a
#: degree, speed to 0.1 kn (the unit of the report); errors wander within five minutes.
AIS_POSITION_M, AIS_COURSE_RAD, AIS_SPEED_M_S = 10.0, float(np.radians(1.0)), 0.1 * KNOT_M_S
AIS_CORRELATION_S = 300.0
#: Radar with target tracking: half of the 95 % limits of IMO's standard (MSC.192(79)): range
#: 30 m, bearing 1°, and after three minutes true course 5°, true speed 0.5 kn.
RADAR_RANGE_M, RADAR_BEARING_RAD = 15.0, float(np.radians(0.5))
RADAR_COURSE_RAD, RADAR_SPEED_M_S = float(np.radians(2.5)), 0.25 * KNOT_M_S
RADAR_CORRELATION_S = 60.0
#: Own ship: a satellite position and a gyro.
OWN_POSITION_M, OWN_HEADING_RAD = 5.0, float(np.radians(0.5))
#: Class A under way reports every 2 s, at anchor and class B at rest every 3 min (ITU-R M.1371).
REPORT_S = (2.0, 180.0)
#: An altering target turns once, at a time and by an angle between these.
ALTERS_S, ALTERS_DEG = (120.0, 1500.0), (15.0, 60.0)
#: The target that ignores the Rules turns to port towards the meeting, late.
IGNORES_S, IGNORES_DEG = (300.0, 900.0), (30.0, 75.0)
CURRENT_M_S = 2.0 * KNOT_M_S
SHIP_SHARE = 0.2
#: Later than any voyage ends.
_NEVER_S = 1e6

#: A batch of cases with one thing changed, as drawn.
Change = Callable[[Case, np.random.Generator], Case]


def with_random_disturbances(cases: Case, share: float, rng: np.random.Generator) -> Case:
    """A batch in which some cases are disturbed, each in its own way.

    Args:
        cases: Undisturbed cases whose targets keep straight on.
        share: Probability that a case is disturbed; then each disturbance has probability 1/2.
        rng: Draws which cases, and how.
    """
    count = np.shape(cases.steps)[0]
    seeds = rng.integers(2**31, size=count, dtype=np.int32)
    cases = jax.tree.map(jnp.asarray, with_instruments(cases, seeds))
    shape = np.shape(cases.encounter.present)
    cases = _turned(cases, np.full(shape, _NEVER_S), np.zeros(shape))
    disturbed = rng.random(count) < share
    for name, (_, change) in DISTURBANCES.items():
        if name != "all":
            picked = disturbed & (rng.random(count) < 0.5)
            cases = jax.tree.map(partial(_where, picked), change(cases, rng), cases)
    return cases


def _where(mask: np.ndarray, yes: Array | np.ndarray, no: Array | np.ndarray) -> Array:
    return jnp.asarray(np.where(mask.reshape(-1, *[1] * (np.ndim(yes) - 1)), yes, no))


def with_instruments(cases: Case, seeds: np.ndarray) -> Case:
    """The cases with instruments that show the world as it is; ``seeds`` will draw their errors."""
    present = np.asarray(cases.encounter.present)
    count, slots = present.shape
    zero, each = np.zeros(count, np.float32), np.zeros((count, slots), np.float32)
    none = Disturbance(
        seed=seeds,
        current_m_s=Vector(jnp.asarray(zero), jnp.asarray(zero)),
        own_position_m=zero,
        own_heading_rad=zero,
        radar=np.zeros((count, slots), bool),
        position_m=each,
        range_m=each,
        bearing_rad=each,
        course_rad=each,
        speed_m_s=each,
        correlation_s=each + np.float32(AIS_CORRELATION_S),
        report_interval_s=each,
    )
    return dataclasses.replace(cases, disturbance=none)


def with_noise(cases: Case, rng: np.random.Generator) -> Case:
    by = cases.disturbance
    assert by is not None
    radar = rng.random(by.report_interval_s.shape) < 0.5

    def spread(ais: float, plotted: float) -> np.ndarray:
        return np.where(radar, plotted, ais).astype(np.float32)

    noisy = dataclasses.replace(
        by,
        own_position_m=np.full_like(by.own_position_m, OWN_POSITION_M),
        own_heading_rad=np.full_like(by.own_heading_rad, OWN_HEADING_RAD),
        radar=radar,
        position_m=spread(AIS_POSITION_M, 0.0),
        range_m=spread(0.0, RADAR_RANGE_M),
        bearing_rad=spread(0.0, RADAR_BEARING_RAD),
        course_rad=spread(AIS_COURSE_RAD, RADAR_COURSE_RAD),
        speed_m_s=spread(AIS_SPEED_M_S, RADAR_SPEED_M_S),
        correlation_s=spread(AIS_CORRELATION_S, RADAR_CORRELATION_S),
    )
    return dataclasses.replace(cases, disturbance=noisy)


def with_stale_reports(cases: Case, rng: np.random.Generator) -> Case:
    """Reports at intervals drawn evenly in their logarithm; a radar plot is never stale."""
    by = cases.disturbance
    assert by is not None
    every = np.exp(rng.uniform(*np.log(REPORT_S), size=by.report_interval_s.shape)).astype(
        np.float32
    )
    every = np.where(by.radar, np.float32(0), every)
    return dataclasses.replace(cases, disturbance=dataclasses.replace(by, report_interval_s=every))


def with_altering_targets(cases: Case, rng: np.random.Generator) -> Case:
    shape = np.shape(cases.encounter.present)
    side = rng.choice([-1.0, 1.0], shape)
    turn = side * np.radians(rng.uniform(*ALTERS_DEG, shape))
    return _turned(cases, rng.uniform(*ALTERS_S, shape), turn)


def with_ignoring_target(cases: Case, rng: np.random.Generator) -> Case:
    """The first target alone turns to port, the others keep straight on."""
    shape = np.shape(cases.encounter.present)
    turn = np.zeros(shape)
    turn[:, 0] = -np.radians(rng.uniform(*IGNORES_DEG, shape[0]))
    return _turned(cases, rng.uniform(*IGNORES_S, shape), turn)


def with_current(cases: Case, rng: np.random.Generator) -> Case:
    by = cases.disturbance
    assert by is not None
    count = np.shape(by.seed)[0]
    speed, way = rng.uniform(0, CURRENT_M_S, count), rng.uniform(0, 2 * np.pi, count)
    east, north = (jnp.asarray(speed * f(way), jnp.float32) for f in (np.sin, np.cos))
    carried = dataclasses.replace(by, current_m_s=Vector(east, north))
    return dataclasses.replace(cases, disturbance=carried)


def with_other_ship(cases: Case, rng: np.random.Generator) -> Case:
    """The true ship's K, T, rudder rate and speed, each off by up to a fifth."""
    count = np.shape(cases.steps)[0]

    def off(values: np.ndarray) -> Array:
        share = rng.uniform(1 - SHIP_SHARE, 1 + SHIP_SHARE, count)
        return jnp.asarray(values * share, jnp.float32)

    names = ("gain_1_s", "time_constant_s", "rudder_rate_rad_s", "speed_m_s")
    true = {name: off(np.asarray(getattr(cases.ship, name))) for name in names}
    ship = dataclasses.replace(cases.ship, **true)
    encounter = eqx.tree_at(lambda e: e.own.speed_m_s, cases.encounter, true["speed_m_s"])
    return dataclasses.replace(cases, ship=ship, encounter=encounter)


def with_all(cases: Case, rng: np.random.Generator) -> Case:
    for change in (
        with_noise,
        with_stale_reports,
        with_altering_targets,
        with_current,
        with_other_ship,
    ):
        cases = change(cases, rng)
    return cases


def _turned(cases: Case, time_s: np.ndarray, turn_rad: np.ndarray) -> Case:
    """Every target's only leg followed by one that is turned by an angle at a time."""
    track = turned_track(
        cases.encounter.targets,
        jnp.asarray(time_s, jnp.float32),
        jnp.asarray(turn_rad, jnp.float32),
    )
    return eqx.tree_at(lambda c: c.encounter.targets, cases, track)


def turned_track(track: Track, time_s: Array, turn_rad: Array) -> Track:
    """Straight tracks (one leg each) that alter course by ``turn_rad`` at ``time_s``."""
    first = jax.tree.map(lambda x: x[..., 0], track)
    run = first.speed_m_s * time_s
    second = Track(
        time_s,
        jnp.full_like(time_s, jnp.inf),
        first.east_m + run * jnp.sin(first.course_rad),
        first.north_m + run * jnp.cos(first.course_rad),
        first.course_rad + turn_rad,
        first.speed_m_s,
    )
    return jax.tree.map(lambda a, b: jnp.stack([a, b], axis=-1), first, second)


DISTURBANCES: dict[str, tuple[str, Change]] = {
    "noise": (
        "half of the targets are plotted by radar, half report by AIS, with the errors of each; "
        "own position and heading err as well",
        with_noise,
    ),
    "stale": (
        "each target reports every 2 s to 3 min and is dead-reckoned in between",
        with_stale_reports,
    ),
    "altering": (
        "every target alters course once, by 15-60° to either side",
        with_altering_targets,
    ),
    "ignoring": (
        "one target turns 30-75° to port after 5 to 15 min, against Rules 14, 15 and 17(c)",
        with_ignoring_target,
    ),
    "current": ("a current of up to 2 kn carries own ship along", with_current),
    "ship": ("own ship's K, T, rudder rate and speed are each off by up to 20 %", with_other_ship),
    "all": (
        "noise, stale reports, altering targets, current and ship parameters at once",
        with_all,
    ),
}
