"""Looking for the widest rudders within the errors: what a band must hold."""

from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from glasshelm.certify.measurements import (
    N_OWN_ERRORS,
    N_TARGET_ERRORS,
    RawPlots,
    SensorErrors,
    observe_plots,
    with_errors,
)
from glasshelm.networks.actors import Actor


def rudder_at(
    actor: Actor, scene: RawPlots, errors: SensorErrors, fractions: Float[Array, " k"]
) -> Float[Array, ""]:
    """The rudder with these errors, as a fraction of the limit."""
    own, target = fractions[:N_OWN_ERRORS], fractions[N_OWN_ERRORS:].reshape(-1, N_TARGET_ERRORS)
    return actor(observe_plots(with_errors(scene, own * errors.own(), target * errors.target())))


def random_rudders(
    actor: Actor, scene: RawPlots, errors: SensorErrors, key: PRNGKeyArray, samples: int
) -> Float[Array, " s"]:
    """Rudders at errors drawn evenly from the box; every other one from its corners."""
    size = N_OWN_ERRORS + N_TARGET_ERRORS * scene.present.shape[0]
    inside = jax.random.uniform(key, (samples, size), minval=-1.0, maxval=1.0)
    corners = jnp.where(inside < 0, -1.0, 1.0)
    drawn = jnp.where((jnp.arange(samples) % 2 == 0)[:, None], inside, corners)
    return jax.vmap(partial(rudder_at, actor, scene, errors))(drawn)


def attacked_rudders(
    actor: Actor,
    scene: RawPlots,
    errors: SensorErrors,
    key: PRNGKeyArray,
    starts: int = 8,
    steps: int = 20,
) -> Float[Array, " s"]:
    """Every rudder on the way of projected gradient ascent and descent (Madry et al. 2018).

    From random starts; steps along the sign of the gradient, from 0.5 of the
    largest errors down to 0.02.
    """
    size = N_OWN_ERRORS + N_TARGET_ERRORS * scene.present.shape[0]
    begin = jax.random.uniform(key, (starts, size), minval=-1.0, maxval=1.0)
    begin = begin.at[0].set(0.0)
    sizes = jnp.geomspace(0.5, 0.02, steps)
    ask = jax.value_and_grad(lambda x: rudder_at(actor, scene, errors, x))

    def way(start: Array, side: Array) -> Array:
        def go(x: Array, length: Array) -> tuple[Array, Array]:
            rudder, slope = ask(x)
            slope = jnp.nan_to_num(slope)
            return jnp.clip(x + side * length * jnp.sign(slope), -1.0, 1.0), rudder

        last, rudders = jax.lax.scan(go, start, sizes)
        return jnp.append(rudders, rudder_at(actor, scene, errors, last))

    ways = jax.vmap(jax.vmap(way, (0, None)), (None, 0))(begin, jnp.array([1.0, -1.0]))
    return ways.reshape(-1)
