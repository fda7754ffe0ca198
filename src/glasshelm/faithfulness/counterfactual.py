"""What really happens when a ship is taken away: two futures from one scene (Atrey et al. 2020)."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from glasshelm.core.geometry import wrap_angle
from glasshelm.encounters.types import Encounter
from glasshelm.env.step import EnvState, step
from glasshelm.networks.actors import Policy
from glasshelm.ship.nomoto import ShipParams

#: Steps of the two futures: five minutes.
STEPS = 60


def heading_effects(
    policy: Policy, encounter: Encounter, state: EnvState, ship: ShipParams
) -> Float[Array, " n"]:
    """How much farther to starboard own ship heads after five minutes because ship i is there.

    Both futures begin in the same state and know no chance; in one of them ship
    i has never been. [rad], one number a ship.
    """

    def heading(members: Bool[Array, " n"]) -> Float[Array, ""]:
        world = eqx.tree_at(lambda e: e.present, encounter, encounter.present & members)
        observation = eqx.tree_at(
            lambda s: (s.observation.present, s.danger),
            state,
            (state.observation.present & members, jnp.where(members, state.danger, 0.0)),
        )

        def go(state: EnvState, _: None):
            rudder = policy(state.observation) * ship.rudder_limit_rad
            return step(world, state, rudder, ship).state, None

        return jax.lax.scan(go, observation, None, length=STEPS)[0].own.heading_rad

    ships = encounter.present.shape[-1]
    everyone = jnp.ones(ships, bool)
    others = ~jnp.eye(ships, dtype=bool)
    return wrap_angle(heading(everyone) - jax.vmap(heading)(others))
