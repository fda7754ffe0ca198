"""The decision process as a gymnasium environment, ``glasshelm/Encounter-v0``.

Importing this module registers it; ``gymnasium`` comes with the extra ``gym``:

    import gymnasium, glasshelm.env.gymnasium_env
    env = gymnasium.make("glasshelm/Encounter-v0", ship="large_ship", flat=True)

or, in one line, ``gymnasium.make("glasshelm.env.gymnasium_env:glasshelm/Encounter-v0")``.
For speed use :mod:`glasshelm.env.step` under ``vmap``: here every step pays
for its way from Python to JAX and back.
"""

import functools
from typing import Any

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
from gymnasium.spaces import Box, Dict, MultiBinary, Space
from jaxtyping import Array, Float, PRNGKeyArray

from glasshelm.core.errors import InputError
from glasshelm.core.geometry import CPA_HORIZON_S, norm, offset
from glasshelm.encounters.random_encounters import PAPER, RandomEncounters, random_encounter
from glasshelm.encounters.types import Encounter
from glasshelm.env.observe import DISTANCE_M, FRAMES, LENGTH_M, SPEED_M_S, TIME_S, Observation
from glasshelm.env.rewards import SUB_TASKS
from glasshelm.env.step import (
    FAR_M,
    EnvSettings,
    EnvState,
    StepResult,
    margins,
    reset,
    step,
    targets_at,
)
from glasshelm.ship.nomoto import ShipParams, check_ship, ship_named

ID = "glasshelm/Encounter-v0"


class EncounterEnv(gymnasium.Env[Any, np.ndarray]):
    """Random encounters (Eq. 8-9), one ship to steer, five seconds a step.

    Action: the rudder as a fraction of the limit, [−1, 1], starboard positive.
    Observation (Eq. 10-12, normalised, newest frame first): a dictionary of
    ``waypoint`` [5, 3], ``targets`` [N, 5, 10] and ``present`` [N]; with
    ``flat`` these three side by side in one vector of 15 + 51·N. Reward: the
    sum of Eq. 16-18. ``terminated`` is arrival, ``truncated`` the clock.
    ``info`` holds ``reward`` by sub-task (after a step), and for every slot
    ``margin`` (Eq. 13 before the clip: positive inside the domain) and
    ``range_m``. InputError: an unknown ship, no target slots, no steps.
    """

    metadata = {"render_modes": []}  # noqa: RUF012 (gymnasium declares it so)

    def __init__(
        self,
        ship: str | ShipParams = "paper",
        encounters: RandomEncounters = PAPER,
        episode_steps: int = 240,
        flat: bool = False,
        render_mode: str | None = None,
    ):
        if render_mode is not None:
            raise InputError(f"render_mode {render_mode!r}: {ID} draws nothing; leave it out")
        if encounters.slots < 1:
            raise InputError("encounters.targets allows no target: must allow one or more")
        if episode_steps < 1:
            raise InputError(f"episode_steps {episode_steps}: must be 1 or more")
        params = ship_named(ship) if isinstance(ship, str) else check_ship(ship)
        self.render_mode = None
        self._encounters = encounters
        self._settings = EnvSettings(episode_steps=episode_steps)
        self._flat = flat
        self._ship = jax.tree.map(jnp.float32, params)
        spaces = _spaces(params, encounters, self._settings)
        self.observation_space = _side_by_side(spaces) if flat else Dict(spaces)
        self.action_space = Box(-1.0, 1.0, (1,), np.float32)
        self._world: tuple[Encounter, EnvState] | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """A new encounter; the same ``seed`` gives the same one. No ``options``."""
        super().reset(seed=seed)
        key = jax.random.key(int(self.np_random.integers(2**31)))
        encounter, state, margin, range_m = _begin(key, self._ship, self._encounters)
        self._world = encounter, state
        info = {"margin": np.asarray(margin), "range_m": np.asarray(range_m)}
        return self._seen(state.observation), info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Hold a rudder for five seconds. InputError if ``action`` is none of the action space."""
        if self._world is None:
            raise InputError("step before reset: call reset first")
        encounter, state = self._world
        rudder = _rudder(action)
        out, by_task, total = _step(encounter, state, rudder, self._ship, self._settings)
        self._world = encounter, out.state
        by_task = np.asarray(by_task)
        info = {
            "reward": {task.name.lower(): float(by_task[task]) for task in SUB_TASKS},
            "margin": np.asarray(out.margin),
            "range_m": np.asarray(out.range_m),
        }
        return (
            self._seen(out.state.observation),
            float(total),
            bool(out.terminated),
            bool(out.truncated),
            info,
        )

    def _seen(self, observation: Observation) -> Any:
        parts = {
            "waypoint": np.asarray(observation.waypoint),
            "targets": np.asarray(observation.targets),
            "present": np.asarray(observation.present).astype(np.int8),
        }
        if self._flat:
            return np.concatenate([x.ravel() for x in parts.values()], dtype=np.float32)
        return parts


@functools.partial(jax.jit, static_argnames="settings")
def _begin(
    key: PRNGKeyArray, ship: ShipParams, settings: RandomEncounters
) -> tuple[Encounter, EnvState, Float[Array, " n"], Float[Array, " n"]]:
    encounter = random_encounter(key, ship, settings)
    state = reset(encounter, ship)
    motion = targets_at(encounter, jnp.zeros(()))
    range_m = jnp.where(motion.present, norm(offset(state.own, motion)), FAR_M)
    return encounter, state, margins(state.own, motion, ship), range_m


@functools.partial(jax.jit, static_argnames="settings")
def _step(
    encounter: Encounter,
    state: EnvState,
    action: Float[Array, ""],
    ship: ShipParams,
    settings: EnvSettings,
) -> tuple[StepResult, Float[Array, "2"], Float[Array, ""]]:
    out = step(encounter, state, action * ship.rudder_limit_rad, ship, settings)
    return out, out.reward.by_task, out.reward.total


def _rudder(action: Any) -> np.ndarray:
    """The action as a scalar."""
    try:
        given = np.asarray(action, np.float64)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.shape not in ((), (1,)) or not abs(given.item()) <= 1.0:
        told = repr(action)
        told = told if len(told) <= 100 else f"{told[:100]}…"
        raise InputError(
            f"action {told}: must be one number from -1 to 1, in an array of shape (1,)"
        )
    return given.reshape(()).astype(np.float32)


def _spaces(
    ship: ShipParams, encounters: RandomEncounters, settings: EnvSettings
) -> dict[str, Space[Any]]:
    """What can be seen at most: how far apart own ship and the others can be, how fast.

    A target begins at most where Eq. 8-9 put her and then runs for an episode;
    DCPA never exceeds the distance, TCPA never its horizon.
    """
    closing = float(ship.speed_m_s) + encounters.target_speed_m_s[1]
    sailed_s = settings.step_s * settings.episode_steps
    apart = closing * (encounters.time_to_collision_s[1] + sailed_s)
    apart += encounters.position_noise_m * 2**0.5
    to_go = encounters.waypoint_m[1] + float(ship.speed_m_s) * sailed_s
    length, speed, distance = apart / LENGTH_M, closing / SPEED_M_S, apart / DISTANCE_M
    tcpa = CPA_HORIZON_S / TIME_S
    waypoint = np.array([to_go / LENGTH_M, to_go / LENGTH_M, 1.0])
    high = np.array(
        # the columns of TARGET_FEATURES
        [length, length, 1, speed, speed, distance, length, length, distance, tcpa]
    )
    low = np.where(np.isin(np.arange(10), (5, 8)), 0.0, -high)  # distances
    slots = encounters.slots
    return {
        "waypoint": _box(-waypoint, waypoint, (FRAMES, 3)),
        "targets": _box(low, high, (slots, FRAMES, 10)),
        "present": MultiBinary(slots),
    }


def _box(low: np.ndarray, high: np.ndarray, shape: tuple[int, ...]) -> Box:
    """The bounds for all frames (and ships), a thousandth wider for rounding."""
    wide = [np.broadcast_to(1.001 * x, shape).astype(np.float32) for x in (low, high)]
    return Box(wide[0], wide[1], dtype=np.float32)


def _side_by_side(spaces: dict[str, Space[Any]]) -> Box:
    low, high = [], []
    for space in spaces.values():
        if isinstance(space, Box):
            low.append(space.low.ravel())
            high.append(space.high.ravel())
        else:
            low.append(np.zeros(space.shape or ()))
            high.append(np.ones(space.shape or ()))
    return Box(
        np.concatenate(low, dtype=np.float32),
        np.concatenate(high, dtype=np.float32),
        dtype=np.float32,
    )


if ID not in gymnasium.registry:
    gymnasium.register(ID, "glasshelm.env.gymnasium_env:EncounterEnv")
