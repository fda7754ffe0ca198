"""The decision process: begin an encounter, take one step of five seconds."""

import dataclasses

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from glasshelm.core.geometry import Vector, norm, offset, to_body
from glasshelm.encounters.types import Encounter, Motion, motion_at
from glasshelm.env.observe import (
    Observation,
    empty_observation,
    observe,
    push_frame,
    waypoint_bearing_rad,
)
from glasshelm.env.rewards import Reward, step_reward
from glasshelm.ship.domain import danger, danger_unclipped
from glasshelm.ship.nomoto import ShipParams, ShipState, advance


@dataclasses.dataclass(frozen=True)
class EnvSettings:
    """What shapes the decision process and never changes within it (section 3.2)."""

    step_s: float = 5.0
    episode_steps: int = 240
    #: A waypoint counts as reached within this distance.
    arrival_m: float = 500.0


class EnvState(eqx.Module):
    """The environment at one instant. ``leg`` is the waypoint of the route steered for."""

    own: ShipState
    step: Int[Array, ""]
    leg: Int[Array, ""]
    observation: Observation
    danger: Float[Array, " n"]


class StepResult(eqx.Module):
    """What a step brought.

    ``terminated``: the last waypoint is reached. ``truncated``: the clock ended
    the episode, and the value of ``state`` still counts. ``margin`` is Eq. 13
    without the clip: how deep each target is in the domain, below 0 outside. ``range_m`` is its
    distance. Absent slots count as far off; both are finite.
    """

    state: EnvState
    reward: Reward
    terminated: Bool[Array, ""]
    truncated: Bool[Array, ""]
    margin: Float[Array, " n"]
    range_m: Float[Array, " n"]


FAR_M = 1e6  # where an absent target counts as being


def reset(
    encounter: Encounter, ship: ShipParams, settings: EnvSettings = EnvSettings()
) -> EnvState:
    """The first state of an encounter: all five frames show it as it is (section 3.3).

    Args:
        encounter: Own ship's start and route, and the tracks of the targets.
        ship: Own ship.
        settings: Of the decision process.

    Returns:
        The state, with the first observation.
    """
    start = EnvState(
        encounter.own,
        jnp.zeros((), jnp.int32),
        jnp.zeros((), jnp.int32),
        empty_observation(encounter.present.shape[-1]),
        jnp.zeros(encounter.present.shape[-1]),
    )
    return _observed(encounter, ship, start, targets_at(encounter, jnp.zeros(())), first=True)


def targets_at(encounter: Encounter, time_s: Float[Array, ""]) -> Motion:
    """The targets of an encounter at an instant, empty slots absent."""
    motion = motion_at(encounter.targets, time_s)
    return eqx.tree_at(lambda m: m.present, motion, motion.present & encounter.present)


def waypoint_of(encounter: Encounter, leg: Int[Array, ""]) -> Vector:
    """The waypoint that own ship steers for."""
    return Vector(encounter.route.x[leg], encounter.route.y[leg])


def next_leg(
    encounter: Encounter, leg: Int[Array, ""], own: ShipState, settings: EnvSettings
) -> tuple[Int[Array, ""], Bool[Array, ""]]:
    """The waypoint to steer for from now on, and whether the last one is reached."""
    waypoint = waypoint_of(encounter, leg)
    reached = norm(offset(own, waypoint)) < settings.arrival_m
    last = leg >= encounter.route.x.shape[-1] - 1
    return jnp.where(reached & ~last, leg + 1, leg), reached & last


def step(
    encounter: Encounter,
    state: EnvState,
    rudder_command_rad: Float[Array, ""],
    ship: ShipParams,
    settings: EnvSettings = EnvSettings(),
) -> StepResult:
    """Hold a rudder command for one step.

    Args:
        encounter: The encounter that the state is of.
        state: The state now.
        rudder_command_rad: The rudder, starboard positive; clipped to the limit.
        ship: Own ship.
        settings: Of the decision process.

    Returns:
        The next state, its rewards and endings.
    """
    own = advance(state.own, rudder_command_rad, ship, settings.step_s)
    return observe_step(encounter, state, own, ship, settings)


def observe_step(
    encounter: Encounter,
    state: EnvState,
    own: ShipState,
    ship: ShipParams,
    settings: EnvSettings = EnvSettings(),
) -> StepResult:
    """The result of a step after which own ship is in state ``own``.

    :func:`step` with the ship's motion left to the caller: a recorded own ship
    keeps its track, and is observed and rewarded all the same.
    """
    count = state.step + 1
    motion = targets_at(encounter, count * settings.step_s)
    leg, arrived = next_leg(encounter, state.leg, own, settings)
    moved = EnvState(own, count, leg, state.observation, state.danger)
    after = _observed(encounter, ship, moved, motion, first=False)
    changed_leg = after.leg != state.leg
    bearing = waypoint_bearing_rad(after.observation.waypoint[0])
    before = waypoint_bearing_rad(state.observation.waypoint[0])
    reward = step_reward(
        bearing, jnp.where(changed_leg, bearing, before), after.danger, state.danger
    )
    return StepResult(
        after,
        reward,
        terminated=arrived,
        truncated=(count >= settings.episode_steps) & ~arrived,
        margin=margins(own, motion, ship),
        range_m=norm(_body(own, motion)),
    )


def margins(own: ShipState, motion: Motion, ship: ShipParams) -> Float[Array, " n"]:
    """Eq. 13 without the clip for every target; far below zero where nobody is."""
    return danger_unclipped(_body(own, motion), ship.loa_m)


def _body(own: ShipState, motion: Motion) -> Vector:
    """Body-frame positions of the targets; absent ones far ahead."""
    body = to_body(offset(own, motion), own.heading_rad)
    return Vector(jnp.where(motion.present, body.x, 0.0), jnp.where(motion.present, body.y, FAR_M))


def _observed(
    encounter: Encounter, ship: ShipParams, state: EnvState, motion: Motion, first: bool
) -> EnvState:
    """The state with what own ship now sees, and the danger that she is in."""
    sight = observe(state.own, waypoint_of(encounter, state.leg), motion, motion.present)
    return EnvState(
        state.own,
        state.step,
        state.leg,
        push_frame(state.observation, sight, first),
        danger(_body(state.own, motion), ship.loa_m),
    )
