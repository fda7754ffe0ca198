"""Reports made by hand of own ship and others off Helsinki, and what a picture makes of them."""

import math
from datetime import UTC, datetime, timedelta

import jax.numpy as jnp
import numpy as np

from glasshelm.ais.reports import Report
from glasshelm.env.step import targets_at
from glasshelm.live.traffic_picture import TrafficPicture
from glasshelm.ship.nomoto import SHIPS

SHIP = SHIPS["large_ship"]
T0 = datetime(2014, 8, 15, 19, tzinfo=UTC)
HERE = (59.7, 24.7)
#: Degrees a metre northwards, near enough.
NORTH = 1 / 111_400


def at(seconds):
    return T0 + timedelta(seconds=seconds)


def own(seconds=0.0, north_m=0.0, **said):
    said = {"course_rad": 0.0, "speed_m_s": 5.0} | said
    return Report(
        id="own", time=at(seconds), latitude_deg=HERE[0] + north_m * NORTH, longitude_deg=HERE[1],
        is_own=True, **said,
    )  # fmt: skip


def ship(number, seconds=0.0, north_m=2000.0, **said):
    said = {"course_rad": math.pi, "speed_m_s": 5.0} | said
    return Report(
        id=str(number), time=at(seconds), latitude_deg=HERE[0] + north_m * NORTH,
        longitude_deg=HERE[1], **said,
    )  # fmt: skip


def taken(*reports, **settings):
    picture = TrafficPicture("test", **settings)
    for report in reports:
        picture.update(report)
    return picture


def targets(picture, seconds=0.0):
    """The targets there at a time: id -> (east, north, course, speed, age)."""
    scenario = picture.scenario(at(seconds), SHIP)
    m = targets_at(scenario.encounter, jnp.zeros(()))
    columns = (m.east_m, m.north_m, m.course_rad, m.speed_m_s, m.age_s)
    return {
        scenario.targets[k].id: tuple(float(x[k]) for x in columns)
        for k in np.flatnonzero(np.asarray(m.present))
    }
