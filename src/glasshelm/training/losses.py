"""What DDPG minimises: Eq. 2 (critic), Eq. 3 and 5 (actor).

Misprints of the equations are settled in docs/explanation/paper.md.
"""

import dataclasses
from collections.abc import Callable
from typing import Literal

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from glasshelm.env.observe import Observation
from glasshelm.networks.critics import QValues
from glasshelm.networks.ship_batch import ShipBatch
from glasshelm.training.replay_buffer import TransitionBatch

#: Anything that steers as an actor does, and that values as
#: :class:`~glasshelm.networks.critics.SubTaskCritic` does.
ActorFn = Callable[[Observation, ShipBatch], Float[Array, "*b"]]
CriticFn = Callable[[Observation, Float[Array, "*b"], ShipBatch], QValues]
#: ``sum``: one TD error of the total (the paper); ``heads``: one for each head.
TdError = Literal["sum", "heads"]
#: What follows a transition in the TD target: ``policy``, the actor's own action (the paper),
#: or ``sarsa``, the action that was taken, exploration included.
TdTarget = Literal["policy", "sarsa"]


@dataclasses.dataclass(frozen=True)
class ActorLossSettings:
    """The gains of Eq. 5 (Table A.6) and the noise of ŝ."""

    #: λ_reg, decoupled from Adam (:func:`glasshelm.training.ddpg.actor_optimiser`).
    regularisation: float = 0.001
    smoothing: float = 0.005
    action_size: float = 0.0001
    noise: float = 0.02
    #: One draw of noise for all five frames of a feature. Where the network
    #: magnifies differences between frames (lens ``fine``), noise of each frame
    #: by itself would drown everything else.
    noise_shared: bool = False


def td_target(
    critic: CriticFn,
    actor: ActorFn,
    batch: TransitionBatch,
    discount: float,
    fleet: ShipBatch,
    target: TdTarget = "policy",
) -> QValues:
    """y_k = r_k + γ·Q'_k(s', a'), head by head (Eq. 2).

    Nothing follows a terminated step; a truncated one is bootstrapped through.
    The sum over the heads is the ordinary TD target of the total reward.

    Args:
        critic: The target critic Q'.
        actor: The target actor π'.
        batch: Transitions (s, a, r, s').
        discount: γ.
        fleet: How the batch's targets are laid out in rows.
        target: Whether a' is π'(s') or the action taken.

    Returns:
        The targets, without gradient.
    """
    observation = batch.next_observation
    action = actor(observation, fleet) if target == "policy" else batch.next_action
    following = critic(observation, action, fleet)
    bootstrap = discount * (1.0 - batch.terminated)
    return jax.lax.stop_gradient(
        QValues(
            batch.reward.waypoint + bootstrap * following.waypoint,
            batch.reward.by_ship + bootstrap[:, None] * following.by_ship,
        )
    )


def critic_loss(
    critic: CriticFn, target: QValues, batch: TransitionBatch, td_error: TdError, fleet: ShipBatch
) -> Float[Array, ""]:
    """Mean squared TD error (Eq. 2): of the total, or summed over the heads."""
    value = critic(batch.observation, batch.action, fleet)
    if td_error == "sum":
        error = (target.total - value.total) ** 2
    else:
        by_ship = jnp.where(batch.observation.present, target.by_ship - value.by_ship, 0.0)
        error = (target.waypoint - value.waypoint) ** 2 + (by_ship**2).sum(-1)
    return _weighted_mean(error, batch.weight)


def actor_loss(
    actor: ActorFn,
    critic: CriticFn,
    batch: TransitionBatch,
    settings: ActorLossSettings,
    fleet: ShipBatch,
    key: PRNGKeyArray,
) -> Float[Array, ""]:
    """Eq. 5 but for λ_reg: −E[Q(s, π(s))] + λ_s·√E[(π(s)−π(ŝ))² + (π(s)−π(s'))²] + λ_a·E|π(s)|.

    λ_reg·Σθ² is the optimiser's (:func:`glasshelm.training.ddpg.actor_optimiser`).
    """
    action = actor(batch.observation, fleet)
    perturbed = actor(perturb(batch.observation, settings, key), fleet)
    following = actor(batch.next_observation, fleet)
    change = _weighted_mean((action - perturbed) ** 2 + (action - following) ** 2, batch.weight)
    return (
        -_weighted_mean(critic(batch.observation, action, fleet).total, batch.weight)
        + settings.smoothing * jnp.sqrt(change + 1e-12)  # the root has no slope at 0
        + settings.action_size * _weighted_mean(jnp.abs(action), batch.weight)
    )


def perturb(
    observation: Observation, settings: ActorLossSettings, key: PRNGKeyArray
) -> Observation:
    """ŝ of Eq. 5: the normalised observation plus N(0, noise)."""
    # JAX's default generator would take longer than the matrix products of the actor.
    data = jnp.tile(jax.random.key_data(key), 2)
    waypoint_key, target_key = jax.random.split(jax.random.wrap_key_data(data, impl="rbg"))

    def noisy(x: Float[Array, "*b frames f"], k: PRNGKeyArray) -> Float[Array, "*b frames f"]:
        frames = 1 if settings.noise_shared else x.shape[-2]
        shape = (*x.shape[:-2], frames, x.shape[-1])
        return x + settings.noise * jax.random.normal(k, shape)

    return Observation(
        noisy(observation.waypoint, waypoint_key),
        noisy(observation.targets, target_key),
        observation.present,
    )


def _weighted_mean(x: Float[Array, " b"], weight: Float[Array, " b"]) -> Float[Array, ""]:
    return jnp.sum(weight * x) / jnp.maximum(jnp.sum(weight), 1.0)
