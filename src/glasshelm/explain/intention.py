"""Intention: what the pilot makes of a ship, weighted with how much it looks at her (Eq. 24)."""

import equinox as eqx
from jaxtyping import Array, Float

from glasshelm.networks.critics import QValues


class Intention(eqx.Module):
    """Eq. 24 in both readings, one value a slot.

    ``level`` is Q_ca(s_i, a)·α_i (the preprint); ``increment`` is
    (Q_ca(s_i, a) − Q_ca(s_i, 0))·α_i (the journal version, the default reading).
    """

    increment: Float[Array, " n"]
    level: Float[Array, " n"]


def intentions(value: QValues, priority: QValues, attention: Float[Array, " n"]) -> Intention:
    """Intention from the values and priorities of the decided rudder and the attention (Eq. 24)."""
    return Intention(priority.by_ship * attention, value.by_ship * attention)
