"""Positions and motions read back from one observation, and the rudder towards a course."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.core.geometry import Vector, norm, velocity, wrap_angle
from glasshelm.env.observe import LENGTH_M, SPEED_M_S, Observation, waypoint_bearing_rad
from glasshelm.env.step import EnvSettings
from glasshelm.ship.autopilot import autopilot_for
from glasshelm.ship.nomoto import ShipParams


class Situation(eqx.Module):
    """Own ship's surroundings in the frame of its position and heading now [m, m/s, rad]."""

    waypoint: Vector
    bearing_rad: Float[Array, ""]
    rate_of_turn_rad_s: Float[Array, ""]
    position: Vector
    velocity: Vector


def situation_of(observation: Observation, ship: ShipParams) -> Situation:
    """What one observation says of own ship's motion and of the targets'.

    The rate of turn is that of the waypoint's bearing over the last step, less
    what own ship's way makes of it. Absent targets are put far away.
    """
    now, before = (waypoint_bearing_rad(observation.waypoint[i]) for i in (0, 1))
    waypoint = Vector(observation.waypoint[0, 0] * LENGTH_M, observation.waypoint[0, 1] * LENGTH_M)
    passing = ship.speed_m_s * velocity(now, 1.0).x / jnp.maximum(norm(waypoint), 1.0)
    moved = jnp.any(
        observation.waypoint[0] != observation.waypoint[1]
    )  # else this is the first frame
    rate = jnp.where(moved, passing - wrap_angle(now - before) / EnvSettings().step_s, 0.0)
    first = observation.targets[:, 0]
    absent = ~observation.present
    return Situation(
        waypoint,
        now,
        rate,
        Vector(jnp.where(absent, -1e6, first[:, 0] * LENGTH_M), first[:, 1] * LENGTH_M),
        Vector(first[:, 3] * SPEED_M_S, first[:, 4] * SPEED_M_S + ship.speed_m_s),
    )


def rudder_towards(
    offset_rad: Float[Array, ""], observation: Observation, ship: ShipParams
) -> Float[Array, ""]:
    """The rudder, as a fraction of the limit, that steers a course off the waypoint's bearing."""
    at = situation_of(observation, ship)
    error = wrap_angle(at.bearing_rad + offset_rad)
    return autopilot_for(ship).rudder_rad(error, at.rate_of_turn_rad_s) / ship.rudder_limit_rad
