"""What DDPG minimises: Eq. 2 (critic), Eq. 3 and 5 (actor), and Eq. 4 (target networks).

Misprints of the equations are settled in docs/explanation/paper.md.
"""

import dataclasses
from collections.abc import Callable
from typing import Literal, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from glasshelm.env.observe import Observation
from glasshelm.networks.critics import Values
from glasshelm.networks.ship_batch import ShipBatch
from glasshelm.training.replay_buffer import Batch

Tree = TypeVar("Tree")
#: Anything that steers as :class:`SumActor` does, and values as :class:`SubTaskCritic` does.
ActorOf = Callable[[Observation, ShipBatch], Float[Array, "*b"]]
CriticOf = Callable[[Observation, Float[Array, "*b"], ShipBatch], Values]
#: ``sum``: one TD error of the total (the paper); ``heads``: one a head.
CriticTraining = Literal["sum", "heads"]
#: Whose return a critic learns: ``pilot``, who steers as she should from the next step on (the
#: paper), or ``lapses``, who goes on as she did while exploring (SARSA).
Follows = Literal["pilot", "lapses"]


@dataclasses.dataclass(frozen=True)
class ActorLossSettings:
    """The gains of Eq. 5 (Table A.6) and the noise of ŝ."""

    regularisation: float = 0.001
    smoothing: float = 0.005
    action_size: float = 0.0001
    noise: float = 0.02
    #: One draw of noise for all five frames of a feature. Where the network
    #: magnifies differences between frames (lens ``fine``), noise of each frame
    #: by itself would drown everything else.
    noise_shared: bool = False


def td_target(
    critic: CriticOf,
    actor: ActorOf,
    batch: Batch,
    discount: float,
    fleet: ShipBatch,
    follows: Follows = "pilot",
) -> Values:
    """y_k = r_k + γ·Q'_k(s', π'(s')), head by head, with the joint target actor (Eq. 2).

    With ``lapses`` the next action is the one that was taken. Nothing follows a
    terminated step; a truncated one is bootstrapped through. The sum over the
    heads is the ordinary TD target of the total reward.
    """
    action = actor(batch.following, fleet) if follows == "pilot" else batch.next_action
    after = critic(batch.following, action, fleet)
    goes_on = discount * (1.0 - batch.terminated)
    return jax.lax.stop_gradient(
        Values(
            batch.reward.waypoint + goes_on * after.waypoint,
            batch.reward.by_ship + goes_on[:, None] * after.by_ship,
        )
    )


def critic_loss(
    critic: CriticOf, target: Values, batch: Batch, training: CriticTraining, fleet: ShipBatch
) -> Float[Array, ""]:
    """Mean squared TD error (Eq. 2): of the total, or summed over the heads."""
    value = critic(batch.observation, batch.action, fleet)
    if training == "sum":
        error = (target.total - value.total) ** 2
    else:
        by_ship = jnp.where(batch.observation.present, target.by_ship - value.by_ship, 0.0)
        error = (target.waypoint - value.waypoint) ** 2 + (by_ship**2).sum(-1)
    return weighted_mean(error, batch.weight)


def actor_loss(
    actor: ActorOf,
    critic: CriticOf,
    batch: Batch,
    settings: ActorLossSettings,
    fleet: ShipBatch,
    key: PRNGKeyArray,
) -> Float[Array, ""]:
    """Eq. 5: −E[Q(s, π(s))] + λ_reg·Σθ² + λ_s·√E[(π(s)−π(ŝ))² + (π(s)−π(s'))²] + λ_a·E|π(s)|."""
    action = actor(batch.observation, fleet)
    near = actor(perturb(batch.observation, settings, key), fleet)
    after = actor(batch.following, fleet)
    unsteady = weighted_mean((action - near) ** 2 + (action - after) ** 2, batch.weight)
    weights = jax.tree.leaves(eqx.filter(actor, eqx.is_inexact_array))
    return (
        -weighted_mean(critic(batch.observation, action, fleet).total, batch.weight)
        + settings.regularisation * sum(jnp.sum(w**2) for w in weights)
        + settings.smoothing * jnp.sqrt(unsteady + 1e-12)  # the root has no slope at 0
        + settings.action_size * weighted_mean(jnp.abs(action), batch.weight)
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


def polyak(target: Tree, online: Tree, rate: float | Float[Array, ""]) -> Tree:
    """θ' ← θ' + τ(θ − θ') on every array (Eq. 4)."""
    return jax.tree.map(
        lambda t, o: t + rate * (o - t) if eqx.is_inexact_array(t) else t, target, online
    )


def weighted_mean(x: Float[Array, " b"], weight: Float[Array, " b"]) -> Float[Array, ""]:
    return jnp.sum(weight * x) / jnp.maximum(jnp.sum(weight), 1.0)
