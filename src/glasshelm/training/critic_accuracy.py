"""How accurate are the critics: their values against the returns that followed."""

from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from glasshelm.encounters.random_encounters import VALIDATION_SEED
from glasshelm.encounters.types import Encounter
from glasshelm.env.rewards import SUB_TASKS
from glasshelm.env.step import EnvState
from glasshelm.networks.actors import Policy
from glasshelm.networks.ship_batch import Padded
from glasshelm.ship.nomoto import ShipParams
from glasshelm.training.exploration import Noise, NoiseSettings, explore, no_noise
from glasshelm.training.losses import CriticFn
from glasshelm.training.vector_env import reset_batch, step_batch

#: The correlation with what is constant is 0.
_LEAST = 1e-9


class CriticAccuracy(eqx.Module):
    """How well values agree with the returns that followed, by sub-task.

    Correlation, root mean square error and spread (standard deviation) of the
    discounted returns, over all states of the short voyages.
    """

    correlation: Float[np.ndarray, "2"]
    error: Float[np.ndarray, "2"]
    spread: Float[np.ndarray, "2"]

    def as_dict(self) -> dict[str, float]:
        """The same by name, for a log."""
        return {
            f"{task.name.lower()}_{name}": float(getattr(self, name)[task])
            for task in SUB_TASKS
            for name in ("correlation", "error", "spread")
        }


def critic_accuracy(
    actor: Policy,
    critic: CriticFn,
    encounters: Encounter,
    ship: ShipParams,
    discount: float,
    short: int = 240,
    long: int = 480,
    exploration: NoiseSettings | None = None,
) -> CriticAccuracy:
    """Compare Q(s, a) with the discounted return of the rest of the voyage.

    Args:
        actor: What steers.
        critic: The critics Q.
        encounters: A batch of encounters.
        ship: Own ship.
        discount: γ.
        short: Values are taken in the first so many steps.
        long: Returns end after so many steps.
        exploration: What is added to the actor's rudder; None: nothing.
    """
    values, returns = _values_and_returns(
        actor, critic, encounters, ship, discount, long, exploration
    )
    q, g = (np.asarray(x[:short], np.float64).reshape(-1, 2) for x in (values, returns))
    return CriticAccuracy(
        np.array([correlation(q[:, task], g[:, task]) for task in SUB_TASKS]),
        np.sqrt(((q - g) ** 2).mean(0)),
        g.std(0),
    )


def correlation(a: Float[np.ndarray, " n"], b: Float[np.ndarray, " n"]) -> float:
    """Pearson's r; 0 where one of them is constant."""
    covariance = np.cov(a, b, bias=True)
    return covariance[0, 1] / max(np.sqrt(covariance[0, 0] * covariance[1, 1]), _LEAST)


@partial(jax.jit, static_argnames=("long", "exploration"))
def _values_and_returns(
    actor: Policy,
    critic: CriticFn,
    encounters: Encounter,
    ship: ShipParams,
    discount: float | Float[Array, ""],
    long: int,
    exploration: NoiseSettings | None,
) -> tuple[Float[Array, "t w 2"], Float[Array, "t w 2"]]:
    def go(carry: tuple[EnvState, Noise], number: Int[Array, ""]):
        state, noise = carry
        action = actor(state.observation)
        if exploration is not None:
            key = jax.random.fold_in(jax.random.key(VALIDATION_SEED), number)
            action, noise = explore(noise, action, jnp.zeros(()), exploration, key)
        values = critic(state.observation, action, Padded(state.observation.present)).by_task
        result = step_batch(encounters, state, action, ship)
        return (result.state, noise), (values, result.reward.by_task)

    def backward(following: Float[Array, "w 2"], reward: Float[Array, "w 2"]):
        value = reward + discount * following
        return value, value

    start = (reset_batch(encounters, ship), no_noise(encounters.present.shape[0]))
    _, (values, rewards) = jax.lax.scan(go, start, jnp.arange(long))
    _, returns = jax.lax.scan(backward, jnp.zeros_like(rewards[0]), rewards, reverse=True)
    return values, returns
