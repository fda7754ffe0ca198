"""A replay buffer that stores every frame once (section 3.3: networks read five).

Every environment has a ring of rows in order of time. A row is one frame with the
action taken there and the rewards that followed. The frame in which an episode
ended has a row of its own that is no transition: a truncated step keeps its true
next observation beside the first frame of the next episode. The five-frame stacks
are rebuilt when sampling. The frames before the first of an episode are that first
frame, as in :func:`glasshelm.env.observe.push_frame`. The targets present must not
change within an episode, as they do not in random encounters.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray, UInt8

from glasshelm.env.observe import FRAMES, TARGET_FEATURES, WAYPOINT_FEATURES, Observation
from glasshelm.env.rewards import Reward

_WAYPOINT = len(WAYPOINT_FEATURES)
_TARGET = len(TARGET_FEATURES)


class ReplayRow(eqx.Module):
    """What one step of every environment adds.

    ``frame`` is the newest frame, waypoint first; ``rewards`` those of the step
    taken from it, waypoint first; ``age`` its number within the episode.
    ``transition`` is false for the last frame of an episode, ``terminated``
    true if the step from it ended the episode other than by the clock.
    """

    frame: Float[Array, "*w f"]
    action: Float[Array, "*w"]
    rewards: Float[Array, "*w heads"]
    present: UInt8[Array, "*w bytes"]
    age: Int[Array, "*w"]
    transition: Bool[Array, "*w"]
    terminated: Bool[Array, "*w"]


class ReplayBuffer(eqx.Module):
    """Rings [step, environment, ...] with one common write head; ``written`` steps so far."""

    rows: ReplayRow
    written: Int[Array, ""]

    @property
    def capacity(self) -> int:
        """Steps that a ring holds."""
        return self.rows.action.shape[0]

    @property
    def num_envs(self) -> int:
        return self.rows.action.shape[1]


class TransitionBatch(eqx.Module):
    """Transitions as networks read them.

    ``next_action`` is the action taken at the true ``next_observation``; ``weight`` is 1,
    or 0 for a draw that is no transition.
    """

    observation: Observation
    action: Float[Array, " b"]
    reward: Reward
    next_observation: Observation
    next_action: Float[Array, " b"]
    terminated: Bool[Array, " b"]
    weight: Float[Array, " b"]


def empty_buffer(capacity: int, num_envs: int, slots: int) -> ReplayBuffer:
    """Empty rings of ``capacity`` steps for ``slots`` targets."""
    shape = (capacity, num_envs)
    rows = ReplayRow(
        jnp.zeros((*shape, _WAYPOINT + _TARGET * slots)),
        jnp.zeros(shape),
        jnp.zeros((*shape, 1 + slots)),
        jnp.zeros((*shape, -(-slots // 8)), jnp.uint8),
        jnp.zeros(shape, jnp.int16),
        jnp.zeros(shape, bool),
        jnp.zeros(shape, bool),
    )
    return ReplayBuffer(rows, jnp.zeros((), jnp.int32))


def replay_row(
    observation: Observation,
    action: Float[Array, " w"],
    reward: Reward,
    age: Int[Array, " w"],
    transition: Bool[Array, " w"],
    terminated: Bool[Array, " w"],
) -> ReplayRow:
    """The row of one step of all environments."""
    newest = observation.targets[..., 0, :]
    return ReplayRow(
        jnp.concatenate(
            [observation.waypoint[..., 0, :], newest.reshape(*newest.shape[:-2], -1)], axis=-1
        ),
        action,
        jnp.concatenate([reward.waypoint[..., None], reward.by_ship], axis=-1),
        jnp.packbits(observation.present, axis=-1),
        age.astype(jnp.int16),
        transition,
        terminated,
    )


def append(buffer: ReplayBuffer, row: ReplayRow) -> ReplayBuffer:
    """The buffer with one more row, over the oldest once the rings are full."""
    head = buffer.written % buffer.capacity
    rows = jax.tree.map(
        lambda ring, new: jax.lax.dynamic_update_index_in_dim(ring, new, head, 0), buffer.rows, row
    )
    return ReplayBuffer(rows, buffer.written + 1)


def sample(buffer: ReplayBuffer, size: int, key: PRNGKeyArray) -> TransitionBatch:
    """``size`` transitions drawn with replacement (:func:`sampleable_steps`)."""
    env_key, step_key = jax.random.split(key)
    low, high = sampleable_steps(buffer)
    env = jax.random.randint(env_key, (size,), 0, buffer.num_envs)
    return gather(buffer, jax.random.randint(step_key, (size,), low, high), env)


def sampleable_steps(buffer: ReplayBuffer) -> tuple[Int[Array, ""], Int[Array, ""]]:
    """Steps [low, high) whose row, next row and four rows before are all in the rings."""
    oldest = jnp.maximum(buffer.written - buffer.capacity, 0)
    return jnp.where(oldest > 0, oldest + FRAMES - 1, 0), buffer.written - 1


def gather(buffer: ReplayBuffer, step: Int[Array, " b"], env: Int[Array, " b"]) -> TransitionBatch:
    """The transitions of given steps (counted from the first ever written) and environments."""
    flat = jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), buffer.rows)

    def index(step: Int[Array, "..."], env: Int[Array, "..."]) -> Int[Array, "..."]:
        return (step % buffer.capacity) * buffer.num_envs + env

    row = index(step, env)
    first = step - flat.age[row]
    # Row 0 is the next frame, row 1 this one, rows 2-5 the past: clamped to the episode.
    wanted = jnp.maximum(step[:, None] + 1 - jnp.arange(FRAMES + 1), first[:, None])
    frames = flat.frame[index(wanted, env[:, None])]
    slots = flat.rewards.shape[-1] - 1
    present = jnp.unpackbits(flat.present[row], axis=-1, count=slots).astype(bool)
    waypoint = frames[..., :_WAYPOINT]
    targets = frames[..., _WAYPOINT:].reshape(-1, FRAMES + 1, slots, _TARGET).swapaxes(1, 2)
    rewards = flat.rewards[row]
    return TransitionBatch(
        Observation(waypoint[:, 1:], targets[:, :, 1:], present),
        flat.action[row],
        Reward(rewards[:, 0], rewards[:, 1:]),
        Observation(waypoint[:, :-1], targets[:, :, :-1], present),
        flat.action[index(step + 1, env)],
        flat.terminated[row],
        flat.transition[row].astype(jnp.float32),
    )
