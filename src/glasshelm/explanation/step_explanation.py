"""What can be said of one decision, whatever kind of pilot made it."""

import equinox as eqx
from jaxtyping import Array, Bool, Float

from glasshelm.explanation.coalitions import ShapleyValues
from glasshelm.explanation.quantities import Intention, Sweep
from glasshelm.networks.critics import QValues

#: The manoeuvres that a frame compares with the chosen one, in this order. Not as many as slots
#: can be (a power of two, or 20): :func:`glasshelm.pilots.decide.explain` tells axes by length.
ALTERNATIVES = ("keep", "to the waypoint", "best to starboard", "best to port", "without ships")


class ManoeuvreExplanation(eqx.Module):
    """The chosen manoeuvre, what else there was, and for which ships it is.

    Courses are relative to own heading, starboard positive [rad].

    Attributes:
        course_rad: The course that the chosen manoeuvre begins with.
        duration_s: How long it is held; 0: on to the waypoint at once.
        then_course_rad: The second course.
        then_duration_s: How long that is held; 0: there is none.
        alternative_course_rad: The first courses of :data:`ALTERNATIVES`.
        alternatives: Their Q; NaN where there is no such manoeuvre.
        course_shapley: How far each ship moves the course.
        course_leave_one_out: The course less what it would be without each ship alone.
        needed: A smallest set of ships without which another course would be steered; none where
            the course is that of an empty sea.
        last_safe_s: How long course and speed can still be kept before the last manoeuvre that
            brings no ship into the domain; NaN if there is none even now.
    """

    course_rad: Float[Array, ""]
    duration_s: Float[Array, ""]
    then_course_rad: Float[Array, ""]
    then_duration_s: Float[Array, ""]
    alternative_course_rad: Float[Array, " a"]
    alternatives: QValues
    course_shapley: ShapleyValues
    course_leave_one_out: Float[Array, " n"]
    needed: Bool[Array, " n"]
    last_safe_s: Float[Array, ""]


class Explanation(eqx.Module):
    """The reasons of one decision (sections 4-5 of the paper); empty slots are 0.

    Attributes:
        present: Which slots hold a ship.
        value: Q of the decision (Eq. 19): of the rudder, or of the manoeuvre; None without a
            critic.
        priority: Its gain over rudder 0, or over keeping course and speed (Eq. 22); None without
            a critic.
        far: The critic's zero of danger: Q_ca of a ship far off; None without a critic.
        sweep: Q over the rudder range; None without a critic.
        attention: α of every slot (Eq. 23); None without an attention actor.
        intention: Eq. 24; None unless there are both a critic and attention.
        rudder_shapley: How much each ship moves the rudder (a fraction of the limit).
        leave_one_out: What each ship alone changes by not being there (the same unit).
        value_shapley: What each ship contributes to Q of the decision, NaN for more than
            :data:`~glasshelm.explanation.shapley.MAX_PADDED_EXACT` ships; None without a critic.
        manoeuvre: Of pilots that choose manoeuvres; None of others.
    """

    present: Bool[Array, " n"]
    value: QValues | None
    priority: QValues | None
    far: Float[Array, ""] | None
    sweep: Sweep | None
    attention: Float[Array, " n"] | None
    intention: Intention | None
    rudder_shapley: ShapleyValues
    leave_one_out: Float[Array, " n"]
    value_shapley: ShapleyValues | None
    manoeuvre: ManoeuvreExplanation | None = None
