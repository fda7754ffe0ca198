"""How well the returns could be foretold at all, where chance has a say in them.

The critics of a pilot who may lapse (:mod:`glasshelm.learning.noise`) are compared
with one return a state, and a later lapse is chance. Two returns G₁ and G₂ that
follow independently from the same state and action share all that can be known
there, and nothing else: with ρ their correlation, no predictor correlates better
with one of them than √ρ.
"""

from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from glasshelm.encounters.types import Encounter
from glasshelm.learning.evaluate import EVALUATION_SEED, Columns, Steers, correlation
from glasshelm.learning.losses import CriticOf
from glasshelm.learning.noise import Noise, NoiseSettings, explore, quiet
from glasshelm.networks.fleet import Padded
from glasshelm.ships import ShipParams
from glasshelm.world.step import WorldState, begin, step


class Foretold(eqx.Module):
    """Values beside the returns that followed, by sub-task, over the states that were branched.

    ``ceiling`` is √ρ of two independent returns, ``correlation`` that of the
    critic with single returns, ``slope`` the change of the return for one of the
    value (1 is right), ``bias`` the mean of value − return, ``spread`` the
    standard deviation of the returns.
    """

    ceiling: Float[Array, "2"]
    correlation: Float[Array, "2"]
    slope: Float[Array, "2"]
    bias: Float[Array, "2"]
    spread: Float[Array, "2"]


@partial(jax.jit, static_argnames=("lapses", "instants", "every", "long"))
def foretold(
    actor: Steers,
    critic: CriticOf,
    encounters: Encounter,
    ship: ShipParams,
    discount: float | Float[Array, ""],
    lapses: NoiseSettings,
    instants: int = 12,
    every: int = 20,
    long: int = 480,
) -> Foretold:
    """Branch every voyage at ``instants``, ``every`` steps apart, twice, and compare.

    Returns end ``long`` steps after the start of the voyage.
    """

    def act(state: WorldState, noise: Noise, key: PRNGKeyArray):
        return explore(noise, actor(state.observation), jnp.zeros(()), lapses, key)

    def move(state: WorldState, action: Float[Array, " w"]):
        return jax.vmap(lambda e, s, a: step(e, s, a * ship.rudder_limit_rad, ship))(
            encounters, state, action
        )

    def sail(state: WorldState, noise: Noise, key: PRNGKeyArray):
        action, noise = act(state, noise, key)
        return move(state, action).state, noise

    def follow(
        state: WorldState,
        action: Float[Array, " w"],
        noise: Noise,
        left: Int[Array, ""],
        key: PRNGKeyArray,
    ) -> Columns:
        """The discounted return of one future that begins with this action."""

        def go(carry, number: Int[Array, ""]):
            state, action, noise, total, weight = carry
            out = move(state, action)
            total = total + jnp.where(number < left, weight, 0.0) * out.reward.by_task
            action, noise = act(out.state, noise, jax.random.fold_in(key, number))
            return (out.state, action, noise, total, weight * discount), None

        worlds = action.shape[0]
        start = (state, action, noise, jnp.zeros((worlds, 2)), jnp.ones(()))
        return jax.lax.scan(go, start, jnp.arange(long))[0][3]

    def instant(carry: tuple[WorldState, Noise], number: Int[Array, ""]):
        state, noise = carry
        key = jax.random.fold_in(jax.random.key(EVALUATION_SEED), number)
        now, first, second, later = jax.random.split(key, 4)
        action, acting = act(state, noise, now)
        value = critic(state.observation, action, Padded(state.observation.present)).by_task
        left = long - number * every
        one, two = (follow(state, action, acting, left, k) for k in (first, second))
        onward, _ = jax.lax.scan(
            lambda c, k: (sail(*c, k), None),
            (move(state, action).state, acting),
            jax.random.split(later, every - 1),
        )
        return onward, (value, one, two)

    worlds = encounters.present.shape[0]
    start = (jax.vmap(lambda e: begin(e, ship))(encounters), quiet(worlds))
    _, found = jax.lax.scan(instant, start, jnp.arange(instants))
    value, one, two = (x.reshape(-1, 2) for x in found)
    returns, values = jnp.concatenate([one, two]), jnp.concatenate([value, value])
    r = correlation(values, returns)
    return Foretold(
        jnp.sqrt(jnp.maximum(correlation(one, two), 0.0)),
        r,
        r * returns.std(0) / jnp.maximum(values.std(0), 1e-9),
        (values - returns).mean(0),
        returns.std(0),
    )
