"""Meetings set by hand, and what own ship sees of them."""

import jax
import jax.numpy as jnp
import numpy as np

from glasshelm.core.geometry import Vector
from glasshelm.encounters.types import Encounter, straight_track
from glasshelm.env.observe import Observation
from glasshelm.env.step import reset
from glasshelm.ship.nomoto import SHIPS, ShipParams, ShipState

#: Nearly a point: she answers the rudder at once, so that closed forms hold without a turn.
AGILE = ShipParams(5.0, 0.5, float(np.radians(5)), float("inf"), 340.0, 60.0, 5.0)


def meeting(*rows, heading_deg=0.0, waypoint=(0.0, 46_300.0), ship=SHIPS["paper"]) -> Encounter:
    """Targets as rows of east, north [m], course [deg], speed [m/s]; one empty slot behind."""
    east, north, course, speed = jnp.array([*rows, (0.0, 0.0, 0.0, 0.0)]).T
    return Encounter(
        ShipState.steady(0.0, 0.0, float(np.radians(heading_deg)), ship.speed_m_s),
        Vector(jnp.array([waypoint[0]]), jnp.array([waypoint[1]])),
        straight_track(east, north, jnp.radians(course), speed),
        jnp.arange(len(rows) + 1) < len(rows),
    )


_begun = jax.jit(reset, static_argnums=1)


def observed(*rows, heading_deg=0.0, waypoint=(0.0, 46_300.0), ship=SHIPS["paper"]) -> Observation:
    """What she sees of :func:`meeting` at the start."""
    encounter = meeting(*rows, heading_deg=heading_deg, waypoint=waypoint, ship=ship)
    return _begun(encounter, ship).observation


def colliding(course_deg, speed_m_s=5.0, tcpa_s=900.0, ship=SHIPS["paper"]):
    """A row for a ship who meets own ship, northbound, at the same point after ``tcpa_s``."""
    course, run = np.radians(course_deg), float(ship.speed_m_s) * tcpa_s
    way = speed_m_s * tcpa_s
    return (-way * np.sin(course), run - way * np.cos(course), course_deg, speed_m_s)


def mirrored(*rows):
    """The same rows seen in a mirror: port and starboard change places."""
    return tuple((-east, north, -course, speed) for east, north, course, speed in rows)
