"""Why this manoeuvre: everything follows from one table of Q(s, m) by sub-task and by ship.

The pilot takes the manoeuvre of the largest sum, so what the table says *is* the decision. To
leave ships out is to leave columns out of the sum.
"""

import itertools
from functools import lru_cache

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from glasshelm.core.geometry import wrap_angle
from glasshelm.env.observe import Observation
from glasshelm.explanation.coalitions import MAX_EXACT
from glasshelm.explanation.shapley import MAX_PADDED_EXACT, leave_one_out, shapley_padded
from glasshelm.explanation.step_explanation import Explanation, ManoeuvreExplanation
from glasshelm.networks.critics import QValues
from glasshelm.planning.manoeuvres import Manoeuvres
from glasshelm.planning.simulated_critic import ManoeuvreCosts, simulate_manoeuvres
from glasshelm.planning.situation import rudder_towards, situation_of
from glasshelm.ship.nomoto import ShipParams

#: Courses nearer to each other than this are the same [rad].
SAME_COURSE_RAD = float(np.radians(1.0))
#: Of more ships than ``_MANY``, at most ``_FEW`` are left out together.
_MANY, _FEW = 6, 3
#: Rows that are compared at once, and sets of ships, for the processor's cache.
_BLOCK, _SETS = 32, 64
#: Delays and alterations among which the last safe manoeuvre is sought [s, deg].
_DELAYS_S = (*range(0, 601, 60), 720.0, 900.0, 1200.0, 1500.0, 1800.0)
_ALTERATIONS_DEG = (0.0, 20.0, 40.0, 60.0, 90.0, 120.0, -20.0, -40.0, -60.0, -90.0, -120.0)


def choose(values: QValues, members: Bool[Array, " n"] | None = None) -> Int[Array, ""]:
    """The manoeuvre of the largest total, if only the ships of ``members`` are there."""
    if members is None:
        return first_largest(values.total)
    collision = values.by_ship @ members.astype(values.by_ship.dtype)
    return first_largest(QValues(values.waypoint, collision[:, None], values.helm).total)


def first_largest(total: Float[Array, " c"]) -> Int[Array, ""]:
    """``jnp.argmax``, five times as fast on a CPU: the block of the maximum, then its row."""
    blocks = jnp.pad(total, (0, -total.size % _BLOCK), constant_values=-jnp.inf)
    blocks = blocks.reshape(-1, _BLOCK)
    block = jnp.argmax(blocks.max(-1))
    return block * _BLOCK + jnp.argmax(blocks[block])


def explain_manoeuvre(
    manoeuvres: Manoeuvres,
    values: QValues,
    observation: Observation,
    ship: ShipParams,
    costs: ManoeuvreCosts,
) -> Explanation:
    """Why the best of the manoeuvres is chosen. Pure and traceable, for one observation.

    Args:
        manoeuvres: All that there are; the last keeps course and speed.
        values: Their values.
        observation: What they were valued in.
        ship: Own ship.
        costs: How far ahead the last safe manoeuvre is sought.
    """
    present, total = observation.present, values.total
    bearing = situation_of(observation, ship).bearing_rad
    offset = manoeuvres.offset_rad  # differences of courses are those of offsets, never wrapped
    course = wrap_angle(bearing + offset)
    then = wrap_angle(bearing + manoeuvres.then_offset_rad)
    rudder = jax.vmap(lambda one: rudder_towards(one, observation, ship))(offset)
    chosen, keep = choose(values), jnp.array(course.size - 1)
    rows, there = alternatives(values, course, keep)
    value = _rows(values, chosen)
    others = jax.tree.map(lambda x: jnp.where(_as_wide(there, x), x, jnp.nan), _rows(values, rows))

    def worth(members: Bool[Array, " n"]) -> tuple[Float[Array, ""], ...]:
        row = choose(values, members)
        return rudder[row], offset[row], total[row]

    slots = present.shape[0]
    of_rudder, of_course, of_value = shapley_padded(worth, present, MAX_EXACT, sampled=True)
    rudder_alone, course_alone, _ = leave_one_out(worth, slots)
    told = present.sum() <= MAX_PADDED_EXACT  # as of any pilot
    return Explanation(
        present,
        value,
        jax.tree.map(jnp.subtract, value, _rows(values, keep)),
        far=jnp.zeros(()),
        sweep=None,
        attention=None,
        intention=None,
        rudder_shapley=of_rudder,
        leave_one_out=rudder_alone,
        value_shapley=jax.tree.map(lambda x: jnp.where(told, x, jnp.nan), of_value),
        manoeuvre=ManoeuvreExplanation(
            course[chosen],
            manoeuvres.duration_s[chosen],
            then[chosen],
            manoeuvres.then_duration_s[chosen],
            course[rows],
            others,
            of_course,
            course_alone,
            needed_ships(values, course, present),
            last_safe_s(observation, ship, costs),
        ),
    )


def _rows(values: QValues, rows: Int[Array, "*k"]) -> QValues:
    return jax.tree.map(lambda x: x[rows], values)


def _as_wide(flags: Bool[Array, " k"], like: Float[Array, "k *n"]) -> Bool[Array, "k *#n"]:
    return flags.reshape(-1, *(1,) * (like.ndim - 1))


def alternatives(
    values: QValues, course_rad: Float[Array, " c"], keep: Int[Array, ""]
) -> tuple[Int[Array, " a"], Bool[Array, " a"]]:
    """The rows of the alternatives, and whether there is such a manoeuvre."""
    sides = course_rad > SAME_COURSE_RAD, course_rad < -SAME_COURSE_RAD
    best = [jnp.argmax(jnp.where(side, values.total, -jnp.inf)) for side in sides]
    nobody = choose(values, jnp.zeros(values.by_ship.shape[1], bool))
    yes = jnp.ones((), bool)
    there = jnp.stack([yes, yes, *(side.any() for side in sides), yes])
    return jnp.stack([keep, jnp.zeros_like(keep), *best, nobody]), there


def needed_ships(
    values: QValues, course_rad: Float[Array, " c"], present: Bool[Array, " n"]
) -> Bool[Array, " n"]:
    """A smallest set of ships without which another course is chosen.

    Of equal sets, the one whose absence changes the course most. Among more than six ships, sets
    of more than three are not tried.
    """
    if present.shape[0] == 0:
        return present
    sets = jnp.asarray(_sets(present.shape[0]))
    course = course_rad[choose(values)]
    others = jax.lax.map(lambda out: course_rad[choose(values, ~out)], sets, batch_size=_SETS)
    change = jnp.abs(wrap_angle(others - course))
    counts = (change > SAME_COURSE_RAD) & ~(sets & ~present).any(-1)
    first = jnp.argmin(jnp.where(counts, sets.sum(-1) - change / 4.0, jnp.inf))
    return sets[first] & counts.any()


@lru_cache
def _sets(ships: int) -> Bool[np.ndarray, "k n"]:
    """The sets of ships that are left out together."""
    most = ships if ships <= _MANY else _FEW
    chosen = [c for size in range(1, most + 1) for c in itertools.combinations(range(ships), size)]
    return np.array([[i in members for i in range(ships)] for members in chosen])


def last_safe_s(
    observation: Observation, ship: ShipParams, costs: ManoeuvreCosts
) -> Float[Array, ""]:
    """How long course and speed can be kept before the last safe manoeuvre.

    Safe is what brings no ship into own ship's domain until the horizon, all targets keeping
    course and speed. The horizon itself means that nothing need be done; NaN that nothing helps.
    """
    at = situation_of(observation, ship)
    alterations = np.radians(_ALTERATIONS_DEG)
    delay, alteration = (x.ravel() for x in np.meshgrid(_DELAYS_S, alterations, indexing="ij"))
    keep = jnp.broadcast_to(-at.bearing_rad, delay.shape)
    until_the_end = jnp.full(delay.shape, costs.horizon_s)
    manoeuvres = Manoeuvres(keep, jnp.asarray(delay), keep + alteration, until_the_end)
    _, met = simulate_manoeuvres(manoeuvres, at, ship, costs)
    safe = jnp.ones(delay.shape, bool)
    for there, ahead in zip(observation.present, met, strict=True):
        safe &= ~there | (ahead.margin <= 0.0)
    latest = jnp.where(safe, delay, -1.0).max()
    latest = jnp.where(latest < 0.0, jnp.nan, latest)
    return jnp.where((safe & (alteration == 0.0)).any(), costs.horizon_s, latest)
