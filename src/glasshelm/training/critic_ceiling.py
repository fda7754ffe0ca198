"""How well the returns could be foretold at all, where chance has a say in them.

The critics of a pilot who may lapse (:mod:`glasshelm.training.exploration`) are compared
with one return a state, and a later lapse is chance. Two returns G₁ and G₂ that
follow independently from the same state and action share all that can be known
there, and nothing else: with ρ their correlation, no predictor correlates better
with one of them than √ρ.
"""

from collections.abc import Callable
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from glasshelm.encounters.types import Encounter
from glasshelm.env.rewards import Reward
from glasshelm.env.step import EnvState, reset, step
from glasshelm.networks.ship_batch import Padded
from glasshelm.ship.nomoto import ShipParams
from glasshelm.training.exploration import Noise, NoiseSettings, explore, quiet
from glasshelm.training.losses import CriticOf
from glasshelm.training.validation import EVALUATION_SEED, Steers


class Foretold(eqx.Module):
    """Values beside the returns that followed, over the states that were branched.

    Each field holds three figures: of the waypoint's head, of the collision heads'
    sum, and of the collision head ship by ship, each ship against her own return
    (:data:`HEADS`). ``ceiling`` is √ρ of two independent returns, ``correlation``
    that of the critic with single returns, ``slope`` the change of the return for
    one of the value (1 is right), ``bias`` the mean of value − return, ``spread``
    the standard deviation of the returns.
    """

    ceiling: Float[Array, "*heads"]
    correlation: Float[Array, "*heads"]
    slope: Float[Array, "*heads"]
    bias: Float[Array, "*heads"]
    spread: Float[Array, "*heads"]


#: What the figures of :class:`Foretold` are of, in their order.
HEADS = ("waypoint", "collision", "collision, ship by ship")


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

    def act(state: EnvState, noise: Noise, key: PRNGKeyArray):
        return explore(noise, actor(state.observation), jnp.zeros(()), lapses, key)

    def move(state: EnvState, action: Float[Array, " w"]):
        return jax.vmap(lambda e, s, a: step(e, s, a * ship.rudder_limit_rad, ship))(
            encounters, state, action
        )

    def sail(state: EnvState, noise: Noise, key: PRNGKeyArray):
        action, noise = act(state, noise, key)
        return move(state, action).state, noise

    def follow(
        state: EnvState,
        action: Float[Array, " w"],
        noise: Noise,
        left: Int[Array, ""],
        key: PRNGKeyArray,
    ) -> Reward:
        """The discounted return of one future that begins with this action."""

        def go(carry, number: Int[Array, ""]):
            state, action, noise, total, weight = carry
            out = move(state, action)
            counts = jnp.where(number < left, weight, 0.0)
            total = jax.tree.map(lambda t, r: t + counts * r, total, out.reward)
            action, noise = act(out.state, noise, jax.random.fold_in(key, number))
            return (out.state, action, noise, total, weight * discount), None

        present = encounters.present
        nothing = Reward(jnp.zeros(present.shape[0]), jnp.zeros(present.shape))
        start = (state, action, noise, nothing, jnp.ones(()))
        return jax.lax.scan(go, start, jnp.arange(long))[0][3]

    def instant(carry: tuple[EnvState, Noise], number: Int[Array, ""]):
        state, noise = carry
        key = jax.random.fold_in(jax.random.key(EVALUATION_SEED), number)
        now, first, second, later = jax.random.split(key, 4)
        action, acting = act(state, noise, now)
        value = critic(state.observation, action, Padded(state.observation.present))
        left = long - number * every
        one, two = (follow(state, action, acting, left, k) for k in (first, second))
        onward, _ = jax.lax.scan(
            lambda c, k: (sail(*c, k), None),
            (move(state, action).state, acting),
            jax.random.split(later, every - 1),
        )
        return onward, (value, one, two)

    worlds = encounters.present.shape[0]
    start = (jax.vmap(lambda e: reset(e, ship))(encounters), quiet(worlds))
    _, found = jax.lax.scan(instant, start, jnp.arange(instants))
    value, one, two = found
    everywhere = jnp.ones_like(value.waypoint)
    ships = jnp.broadcast_to(encounters.present, value.by_ship.shape)
    parts = (
        _compared(value.waypoint, one.waypoint, two.waypoint, everywhere),
        _compared(value.collision, one.by_ship.sum(-1), two.by_ship.sum(-1), everywhere),
        _compared(value.by_ship, one.by_ship, two.by_ship, ships.astype(jnp.float32)),
    )
    return jax.tree.map(lambda *figures: jnp.stack(figures), *parts)


def _compared(
    value: Float[Array, "*s"],
    one: Float[Array, "*s"],
    two: Float[Array, "*s"],
    of: Float[Array, "*s"],
) -> Foretold:
    """The figures of one head, where ``of`` is 1; 0 for a correlation with what is constant."""

    def mean(x: Float[Array, "*s"]) -> Float[Array, ""]:
        return (x * of).sum() / of.sum()

    def moments(a: Float[Array, "*s"], b: Float[Array, "*s"]) -> Float[Array, ""]:
        return mean((a - mean(a)) * (b - mean(b)))

    def both(figure: Callable[[Float[Array, "*s"]], Float[Array, ""]]) -> Float[Array, ""]:
        return (figure(one) + figure(two)) / 2

    spread = jnp.sqrt(both(lambda x: moments(x, x)))
    scatter = jnp.sqrt(moments(value, value))
    along = both(lambda x: moments(value, x))
    return Foretold(
        jnp.sqrt(jnp.maximum(moments(one, two), 0.0)) / jnp.maximum(spread, 1e-9),
        along / jnp.maximum(scatter * spread, 1e-9),
        along / jnp.maximum(scatter**2, 1e-9),
        mean(value) - both(mean),
        spread,
    )
