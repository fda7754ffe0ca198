"""What the explanation of a chosen manoeuvre says exactly, checked by asking the pilot again."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.core.geometry import wrap_angle
from glasshelm.explanation.coalitions import coalitions, exact_from_worths
from glasshelm.explanation.manoeuvre_explanation import SAME_COURSE_RAD
from glasshelm.explanation.step_explanation import ALTERNATIVES, Explanation
from glasshelm.faithfulness.subjects import manoeuvre_of

#: Must hold in every scene; by name, in words.
CHECKS = {
    "shapley": "the Shapley values are those of the courses that it steers with each set of ships",
    "leave_one_out": "without a ship it steers the course that leave-one-out says",
    "empty_sea": "without all ships it steers the course of the alternative 'without ships'",
    "needed": "without the needed ships it steers another course; if none is needed, none does",
    "smallest": "no smaller set of ships has that effect",
    "best": "no alternative is worth more than the chosen manoeuvre",
}
#: True of every decision, and yet not what a reader may expect.
SURPRISES = {
    "together": "ships move the course, but no one ship alone: leave-one-out is 0 for all",
    "balanced": "ships are needed for the course that it would also steer in an empty sea",
    "not_needed": "the ship of the greatest danger (of keeping on) is not among the needed",
    "no_gain": "a needed ship gains nothing over keeping on (its priority is not positive)",
}
#: Courses that are computed twice are equal within this [rad], values within this [points].
_EQUAL_RAD, _EQUAL_POINTS = 1e-3, 1e-2


def manoeuvre_checks(
    why: Explanation, courses: Float[Array, " k"], bearing_rad: Float[Array, ""]
) -> dict[str, Float[Array, ""]]:
    """Every check and surprise of one scene: 1 where it is so, 0 where not, nan where undefined.

    Args:
        why: The explanation of the decision.
        courses: The courses that the pilot steers with each coalition, by its bits, off the
            waypoint's bearing [rad].
        bearing_rad: That bearing, off own ship's heading.
    """
    m, ships = manoeuvre_of(why), courses.shape[0].bit_length() - 1
    bits, full = 2 ** jnp.arange(ships), courses.shape[0] - 1
    change = jnp.abs(wrap_angle(courses - courses[full]))[::-1]  # by who is left out
    moved = change > SAME_COURSE_RAD
    needed, sizes = (m.needed * bits).sum(), coalitions(ships).sum(1)
    anyone = m.needed.any()
    smaller = (moved & (sizes < m.needed.sum())).any()
    alone = wrap_angle(courses[full] - courses[full - bits])
    empty = m.alternative_course_rad[ALTERNATIVES.index("without ships")] - bearing_rad
    keep = m.alternatives.by_ship[ALTERNATIVES.index("keep")]
    assert why.value is not None
    assert why.priority is not None

    def equal(a: Array, b: Array) -> Array:
        return (jnp.abs(wrap_angle(a - b)) <= _EQUAL_RAD).all()

    found = {
        "shapley": equal(m.course_shapley.by_ship, exact_from_worths(courses).by_ship),
        "leave_one_out": equal(m.course_leave_one_out, alone),
        "empty_sea": equal(empty, courses[0]),
        "needed": jnp.where(anyone, moved[needed], ~moved.any()),
        "smallest": jnp.where(anyone, ~smaller, jnp.nan),
        "best": jnp.nanmax(m.alternatives.total) <= why.value.total + _EQUAL_POINTS,
        "together": jnp.where(moved[full], ~moved[bits].any(), jnp.nan),
        "balanced": jnp.where(anyone, ~moved[full], jnp.nan),
        "not_needed": jnp.where(anyone & (keep.min() < 0), ~m.needed[jnp.argmin(keep)], jnp.nan),
        "no_gain": jnp.where(anyone, (m.needed & (why.priority.by_ship <= 0)).any(), jnp.nan),
    }
    return {name: value.astype(jnp.float32) for name, value in found.items()}
