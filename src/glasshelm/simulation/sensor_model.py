"""What own ship's instruments show, between the true world and what the pilot sees.

The world goes on as it is; the pilot sees a picture of it: own ship by satellite
position and gyro, each target by its last report, dead-reckoned to now. An
AIS report has the errors of the target's own receiver and comes every 2 s to
3 min; a radar plot errs in range and bearing from own ship and comes every step.
Errors wander: each is a Gauss-Markov process with a spread and a correlation time.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from glasshelm.core.geometry import Vector, direction, norm, to_body, velocity
from glasshelm.encounters.types import Encounter, Motion
from glasshelm.env.observe import Observation, empty_observation, observe, push_frame
from glasshelm.env.step import targets_at, waypoint_of
from glasshelm.ship.nomoto import ShipState

Number = Float[Array, "..."] | Float[np.ndarray, "..."]

#: Own ship's receiver and gyro: their errors wander within five minutes.
OWN_CORRELATION_S = 300.0


class Disturbance(eqx.Module):
    """How the world and its picture differ, for one case; zeros: not at all.

    ``current_m_s`` (east, north) carries own ship along; the targets' courses and
    speeds are over ground. The errors are standard deviations: of a satellite
    position on each axis (``position_m``), of a radar plot in range and
    bearing, of course and speed, and of own ship's position and heading.
    ``radar`` says which targets are plotted by radar, the others report by AIS;
    ``every_s`` is the interval of reports, the first at t = 0. ``seed`` draws the errors.
    """

    seed: Int[Array, "*b"] | Int[np.ndarray, "*b"]
    current_m_s: Vector
    own_position_m: Number
    own_heading_rad: Number
    radar: Bool[Array, "*b n"] | Bool[np.ndarray, "*b n"]
    position_m: Number
    range_m: Number
    bearing_rad: Number
    course_rad: Number
    speed_m_s: Number
    correlation_s: Number
    report_interval_s: Number


class PerceivedTraffic(eqx.Module):
    """The instruments at one instant.

    ``own_noise`` and ``noise`` are the errors in units of their spread;
    ``report`` is the last one of each target, ``heard_s`` its time, ``observation`` what
    the pilot is shown.
    """

    own_noise: Float[Array, "3"]
    noise: Float[Array, "n 4"]
    report: Motion
    reported_s: Float[Array, " n"]
    observation: Observation


def first_perception(by: Disturbance, encounter: Encounter, own: ShipState) -> PerceivedTraffic:
    """The picture at t = 0: every target there has just been heard."""
    slots = encounter.present.shape[-1]
    own_key, key = jax.random.split(_key(by, jnp.zeros((), jnp.int32)))
    nobody = eqx.tree_at(
        lambda m: m.present, targets_at(encounter, jnp.zeros(())), jnp.zeros(slots, bool)
    )
    before = PerceivedTraffic(
        jax.random.normal(own_key, (3,)),
        jax.random.normal(key, (slots, 4)),
        nobody,
        jnp.zeros(slots),
        empty_observation(slots),
    )
    return _look(by, before, encounter, own, jnp.zeros((), jnp.int32), jnp.zeros(()), True)


def next_perception(
    by: Disturbance,
    before: PerceivedTraffic,
    encounter: Encounter,
    own: ShipState,
    leg: Int[Array, ""],
    step: Int[Array, ""],
    step_s: float,
) -> PerceivedTraffic:
    """The picture after a step: errors have wandered, reports that are due have come."""
    own_key, key = jax.random.split(_key(by, step))
    wandered = eqx.tree_at(
        lambda p: (p.own_noise, p.noise),
        before,
        (
            _wander(before.own_noise, step_s / OWN_CORRELATION_S, own_key),
            _wander(before.noise, (step_s / by.correlation_s)[:, None], key),
        ),
    )
    return _look(by, wandered, encounter, own, leg, step * step_s, False)


def _key(by: Disturbance, step: Int[Array, ""]) -> PRNGKeyArray:
    return jax.random.fold_in(jax.random.key(by.seed), step)


def _wander(
    noise: Float[Array, "..."], share: float | Number, key: PRNGKeyArray
) -> Float[Array, "..."]:
    """A step of a Gauss-Markov process of unit spread; ``share`` of its correlation time."""
    kept = jnp.exp(-share * jnp.ones_like(noise))
    return kept * noise + jnp.sqrt(1.0 - kept**2) * jax.random.normal(key, noise.shape)


def _look(
    by: Disturbance,
    picture: PerceivedTraffic,
    encounter: Encounter,
    own: ShipState,
    leg: Int[Array, ""],
    time_s: Float[Array, ""],
    first: bool,
) -> PerceivedTraffic:
    """The picture with the reports of now in it, and the observation made from it."""
    motion = targets_at(encounter, time_s)
    shown = _own_shown(by, picture.own_noise, own)
    unheard = motion.present & ~picture.report.present
    due = unheard | (time_s - picture.reported_s >= by.report_interval_s - 1e-3)
    fresh = _report(by, picture.noise, own, shown, motion)
    report = jax.tree.map(lambda new, old: jnp.where(due, new, old), fresh, picture.report)
    report = eqx.tree_at(lambda m: m.present, report, motion.present)
    heard_s = jnp.where(due, time_s, picture.reported_s)
    reckoned = _reckoned(by, report, time_s - heard_s)
    sight = observe(shown, waypoint_of(encounter, leg), reckoned, report.present)
    return PerceivedTraffic(
        picture.own_noise,
        picture.noise,
        report,
        heard_s,
        push_frame(picture.observation, sight, first),
    )


def _own_shown(by: Disturbance, noise: Float[Array, "3"], own: ShipState) -> ShipState:
    """Own ship as its sensors show it."""
    return eqx.tree_at(
        lambda s: (s.east_m, s.north_m, s.heading_rad),
        own,
        (
            own.east_m + by.own_position_m * noise[0],
            own.north_m + by.own_position_m * noise[1],
            own.heading_rad + by.own_heading_rad * noise[2],
        ),
    )


def _report(
    by: Disturbance, noise: Float[Array, "n 4"], own: ShipState, shown: ShipState, true: Motion
) -> Motion:
    """What a report of each target would say now.

    A radar measures from where own ship is, against its heading line: own ship's
    errors move and turn the plots as they move and turn own ship.
    """
    away = Vector(true.east_m - own.east_m, true.north_m - own.north_m)
    stretched = 1.0 + by.range_m * noise[:, 0] / jnp.maximum(norm(away), 1.0)
    turned = shown.heading_rad - own.heading_rad + by.bearing_rad * noise[:, 1]
    plot = to_body(Vector(away.x * stretched, away.y * stretched), -turned)
    return Motion(
        jnp.where(by.radar, shown.east_m + plot.x, true.east_m + by.position_m * noise[:, 0]),
        jnp.where(by.radar, shown.north_m + plot.y, true.north_m + by.position_m * noise[:, 1]),
        true.course_rad + by.course_rad * noise[:, 2],
        jnp.maximum(true.speed_m_s + by.speed_m_s * noise[:, 3], 0.0),
        true.age_s,
        true.present,
    )


def _reckoned(by: Disturbance, report: Motion, age_s: Float[Array, " n"]) -> Motion:
    """Reports dead-reckoned to now, with velocities through the water.

    Own ship's velocity in Eq. 11 is its heading and speed, through the water; of
    the targets the same must be shown, or the current would spoil every CPA.
    """
    ground = velocity(report.course_rad, report.speed_m_s)
    water = Vector(ground.x - by.current_m_s.x, ground.y - by.current_m_s.y)
    still = (by.current_m_s.x == 0) & (by.current_m_s.y == 0)
    return Motion(
        report.east_m + age_s * ground.x,
        report.north_m + age_s * ground.y,
        jnp.where(still, report.course_rad, direction(water)),
        jnp.where(still, report.speed_m_s, norm(water)),
        age_s,
        report.present,
    )
