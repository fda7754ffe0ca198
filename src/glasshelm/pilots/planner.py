"""The planner: no network, a model of own ship and many simulated manoeuvres.

It is the expert that the learned pilots imitate and the strongest of the pilots without
weights (:mod:`glasshelm.planning.course_planner`). It sees only what they see; it
cannot say what it values, so its frames carry no explanation.
"""

from jaxtyping import Array, Float

from glasshelm.env.observe import Observation
from glasshelm.pilots.course_pilot import CourseMethod
from glasshelm.planning.course_planner import CourseSettings, plan_course
from glasshelm.ship.nomoto import ShipParams


def planned_course(
    observation: Observation,
    offset_rad: Float[Array, ""],
    ship: ShipParams,
    settings: CourseSettings,
) -> Float[Array, ""]:
    """What the best manoeuvre begins with."""
    return plan_course(observation, ship, settings).offset_rad


PLANNER = CourseMethod(planned_course, CourseSettings(), period=12)
