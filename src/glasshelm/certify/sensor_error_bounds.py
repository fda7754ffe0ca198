"""The largest errors of the sensors, as a person declares them."""

import dataclasses
import math

import jax.numpy as jnp

from glasshelm.certify.measurements import SensorErrors
from glasshelm.core.errors import InputError
from glasshelm.ship.nomoto import KNOT_M_S

#: Satellite positions, a good gyro and log, class A AIS.
DEFAULT_ERRORS = "10,0.5,0.1"


@dataclasses.dataclass(frozen=True)
class SensorErrorBounds:
    """The same for own ship and every target.

    Of positions on each axis, of heading and courses, of speeds.
    """

    position_m: float
    course_rad: float
    speed_m_s: float

    def as_sensor_errors(self) -> SensorErrors:
        one = (self.position_m, self.course_rad, self.speed_m_s)
        return SensorErrors(*(jnp.asarray(x, jnp.float32) for x in one + one))


def parse_error_bounds(text: str) -> SensorErrorBounds:
    """From ``10,0.5,0.1``: metres, degrees, knots. InputError if it is not three sizes."""
    try:
        position, course, speed = map(float, text.split(","))
    except ValueError:
        position = course = speed = math.nan
    if not all(0 <= x < math.inf for x in (position, course, speed)):
        raise InputError(
            f"errors {text[:100]!r}: give three numbers, 0 or more: metres, degrees and knots "
            f"({DEFAULT_ERRORS})"
        )
    return SensorErrorBounds(position, math.radians(course), speed * KNOT_M_S)
