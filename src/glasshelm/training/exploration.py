"""Exploration: what is added to the actor's rudder while it learns.

``ou`` is the usual exploration of DDPG (docs/explanation/paper.md): an Ornstein-Uhlenbeck
process that wanders and keeps the ship on excursions of many steps. What of it would put the
rudder beyond its limits is not added, and not remembered either: a value that goes on growing
while the rudder is hard over would keep it there long after. ``bursts`` is for
learning the value of an actor that is already good: it steers by itself, and now
and then a rudder drawn at random is held for a few steps, so that every rudder
is tried from states that the actor visits.
"""

import dataclasses
from typing import Literal

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, PRNGKeyArray


@dataclasses.dataclass(frozen=True)
class NoiseSettings:
    """Which exploration, how strong, and when it fades (fractions of the training)."""

    kind: Literal["ou", "bursts"] = "ou"
    theta: float = 0.01
    sigma: float = 0.30
    sigma_end: float = 0.01
    fade_from: float = 0.2
    fade_to: float = 0.8
    #: Chance per step that a burst begins, and that it ends.
    burst_begin: float = 0.05
    burst_end: float = 0.25


class Noise(eqx.Module):
    """Exploration of a batch: what OU adds or the held rudder, and whether it is held."""

    value: Float[Array, "*w"]
    active: Bool[Array, "*w"]


def no_noise(num_envs: int) -> Noise:
    """The exploration before the first step."""
    return Noise(jnp.zeros(num_envs), jnp.zeros(num_envs, bool))


def sigma_at(progress: Float[Array, ""], settings: NoiseSettings) -> Float[Array, ""]:
    """σ at a fraction of the training: constant, then linear, then constant."""
    fade = (progress - settings.fade_from) / (settings.fade_to - settings.fade_from)
    return settings.sigma + jnp.clip(fade, 0.0, 1.0) * (settings.sigma_end - settings.sigma)


def ornstein_uhlenbeck(
    value: Float[Array, "*w"], sigma: Float[Array, ""], theta: float, key: PRNGKeyArray
) -> Float[Array, "*w"]:
    """x ← x − θ·x + σ·N(0, 1): one step of the process."""
    return value - theta * value + sigma * jax.random.normal(key, value.shape)


def explore(
    noise: Noise,
    rudder: Float[Array, " w"],
    progress: Float[Array, ""],
    settings: NoiseSettings,
    key: PRNGKeyArray,
) -> tuple[Float[Array, " w"], Noise]:
    """Add exploration to the actor's rudders.

    Args:
        noise: The exploration so far.
        rudder: What the actor commands, in [−1, 1].
        progress: Fraction of the training done.
        settings: Which exploration.
        key: Random key of this step.

    Returns:
        The rudders to try, in [−1, 1], and the exploration after them.
    """
    if settings.kind == "ou":
        sigma = sigma_at(progress, settings)
        value = ornstein_uhlenbeck(noise.value, sigma, settings.theta, key)
        tried = jnp.clip(rudder + value, -1.0, 1.0)
        return tried, Noise(tried - rudder, noise.active)
    switch_key, value_key = jax.random.split(key)
    chance = jax.random.uniform(switch_key, rudder.shape)
    starts = ~noise.active & (chance < settings.burst_begin)
    stops = noise.active & (chance < settings.burst_end)
    drawn = jax.random.uniform(value_key, rudder.shape, minval=-1.0, maxval=1.0)
    value = jnp.where(starts, drawn, noise.value)
    active = (noise.active | starts) & ~stops
    return jnp.where(active, value, rudder), Noise(value, active)
