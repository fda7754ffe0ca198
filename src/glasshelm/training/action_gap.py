"""What is lost by another decision than the expert's: the weight of a label."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from glasshelm.env.observe import Observation
from glasshelm.explanation.manoeuvre_explanation import choose
from glasshelm.networks.critics import QValues
from glasshelm.planning.manoeuvres import Manoeuvres
from glasshelm.planning.situation import rudder_towards
from glasshelm.ship.nomoto import ShipParams

#: A course that is held for so long counts as another choice.
_LASTS_S = 200.0

#: Rudders farther apart than this share of the limit are another choice.
_ANOTHER = 0.5


def action_gap(
    manoeuvres: Manoeuvres, values: QValues, observation: Observation, ship: ShipParams
) -> Float[Array, ""]:
    """What is lost by the best manoeuvre that begins with quite another rudder.

    Another by half of the limit or more, for 200 s or more: what lasts a moment can be
    mended. Where the best one begins with much rudder, also about amidships, if that costs
    more: between two ways out the other one costs nothing, but none of them much.

    Args:
        manoeuvres: All that there are [c].
        values: Their values.
        observation: What they were valued in.
        ship: Own ship.

    Returns:
        The loss in points of return; 0 if there is no other manoeuvre.
    """
    rudders = jax.vmap(lambda o: rudder_towards(o, observation, ship))(manoeuvres.offset_rad)
    total, first = values.total, rudders[choose(values)]
    lasts = (manoeuvres.duration_s == 0.0) | (manoeuvres.duration_s >= _LASTS_S)

    def lost(those: Bool[Array, " c"]) -> Float[Array, ""]:
        value = jnp.where(those & lasts, total, -jnp.inf).max()
        return jnp.where(jnp.isfinite(value), total.max() - value, 0.0)

    amidships = (jnp.abs(rudders) < 0.25) & (jnp.abs(first) > 0.5)
    return jnp.maximum(lost(jnp.abs(rudders - first) > _ANOTHER), lost(amidships))
