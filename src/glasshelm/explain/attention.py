"""Attention: how the actor shares out its weight among the ships (Eq. 23)."""

from jaxtyping import Array, Float

from glasshelm.env.observe import Observation
from glasshelm.networks.actors import Actor, AttentionActor


def attention_of(actor: Actor, observation: Observation) -> Float[Array, " n"] | None:
    """α of every slot: sums to 1 over the ships present; ``None`` if the actor has no attention."""
    return actor.attention(observation) if isinstance(actor, AttentionActor) else None
