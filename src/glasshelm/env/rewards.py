"""Rewards, sub-task by sub-task (Eq. 16-18). The scalar reward is always their sum."""

import enum

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float


class SubTask(enum.IntEnum):
    """The sub-tasks in the one order used by rewards, critics and explanations."""

    WAYPOINT = 0
    COLLISION = 1


SUB_TASKS = tuple(SubTask)


class Reward(eqx.Module):
    """The reward of one step: ``waypoint`` (Eq. 17 + 18) and one value a ship (Eq. 16)."""

    waypoint: Float[Array, "*b"]
    by_ship: Float[Array, "*b n"]

    @property
    def by_task(self) -> Float[Array, "*b 2"]:
        return jnp.stack([self.waypoint, self.by_ship.sum(-1)], axis=-1)

    @property
    def total(self) -> Float[Array, "*b"]:
        return self.waypoint + self.by_ship.sum(-1)


def collision_reward(
    danger: Float[Array, "*n"], danger_before: Float[Array, "*n"]
) -> Float[Array, "*n"]:
    """Eq. 16: nothing outside the domain; inside, dearer while the danger rises."""
    rising = danger > danger_before
    inside = jnp.where(rising, -1.0 * danger - 0.5, -0.5 * danger - 0.1)
    return jnp.where(danger > 0, inside, 0.0)


def course_reward(bearing_rad: Float[Array, "*b"]) -> Float[Array, "*b"]:
    """r_wp of Eq. 17 for the bearing dθ_wp of the waypoint; 0.2 straight ahead."""
    degrees = jnp.degrees(bearing_rad)
    return 0.20 * (0.9 * jnp.exp(-((degrees / 60) ** 2) / 2) + 0.1 * (1 - jnp.abs(degrees) / 180))


#: A smaller bearing is rounding, and turning by it earns nothing to speak of (Eq. 18).
_LEAST_DEG = 0.01


def turn_reward(
    bearing_rad: Float[Array, "*b"],
    bearing_before_rad: Float[Array, "*b"],
    total_danger: Float[Array, "*b"],
) -> Float[Array, "*b"]:
    """r_Δwp of Eq. 18: for turning towards the waypoint while no ship is in the domain."""
    now, before = jnp.abs(jnp.degrees(bearing_rad)), jnp.abs(jnp.degrees(bearing_before_rad))
    share = (before - now) / jnp.clip(before, _LEAST_DEG, 10.0)
    return jnp.where(total_danger > 0, 0.0, 0.050 * jnp.clip(share, 0.0, 1.0))


def step_reward(
    bearing_rad: Float[Array, ""],
    bearing_before_rad: Float[Array, ""],
    danger: Float[Array, " n"],
    danger_before: Float[Array, " n"],
) -> Reward:
    """The reward of the step that led here (Eq. 16-18)."""
    return Reward(
        course_reward(bearing_rad) + turn_reward(bearing_rad, bearing_before_rad, danger.sum(-1)),
        collision_reward(danger, danger_before),
    )
