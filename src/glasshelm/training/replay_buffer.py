"""Replay that stores every frame once (section 3.3: networks read five).

Each world has a ring of rows in order of time. A row is one frame with the
action taken there and the rewards that followed. The frame in which an episode
ended has a row of its own that is no transition. So the true next
observation of a truncated step is kept beside the first frame of the next
episode. The five-frame stacks are rebuilt when sampling: the frames before the
first of an episode are that first frame, as in :func:`remember`. Ships present
do not change within an episode of random encounters, and this is relied on.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray, UInt8

from glasshelm.env.observe import FRAMES, TARGET_FEATURES, WAYPOINT_FEATURES, Observation
from glasshelm.env.rewards import Reward

_WP = len(WAYPOINT_FEATURES)
_OTH = len(TARGET_FEATURES)


class Row(eqx.Module):
    """What one tick of every world leaves behind.

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


class Replay(eqx.Module):
    """Rings [time, world, ...] with one common write head: ``written`` ticks so far."""

    rows: Row
    written: Int[Array, ""]

    @property
    def ticks(self) -> int:
        return self.rows.action.shape[0]

    @property
    def worlds(self) -> int:
        return self.rows.action.shape[1]


class Batch(eqx.Module):
    """Transitions as networks read them. ``following`` is the true next observation.

    ``next_action`` is what was done there; ``weight`` is 1, or 0 for a draw that is no transition.
    """

    observation: Observation
    action: Float[Array, " b"]
    reward: Reward
    following: Observation
    next_action: Float[Array, " b"]
    terminated: Bool[Array, " b"]
    weight: Float[Array, " b"]


def empty_replay(ticks: int, worlds: int, slots: int) -> Replay:
    """Rings for ``ticks`` rows a world and ``slots`` ships, nothing written."""
    shape = (ticks, worlds)
    rows = Row(
        jnp.zeros((*shape, _WP + _OTH * slots)),
        jnp.zeros(shape),
        jnp.zeros((*shape, 1 + slots)),
        jnp.zeros((*shape, -(-slots // 8)), jnp.uint8),
        jnp.zeros(shape, jnp.int16),
        jnp.zeros(shape, bool),
        jnp.zeros(shape, bool),
    )
    return Replay(rows, jnp.zeros((), jnp.int32))


def replay_bytes(ticks: int, worlds: int, slots: int) -> int:
    """Memory of :func:`empty_replay` without allocating it."""
    shapes = jax.eval_shape(lambda: empty_replay(ticks, worlds, slots))
    return sum(leaf.size * leaf.dtype.itemsize for leaf in jax.tree.leaves(shapes))


def row_of(
    observation: Observation,
    action: Float[Array, " w"],
    reward: Reward,
    age: Int[Array, " w"],
    transition: Bool[Array, " w"],
    terminated: Bool[Array, " w"],
) -> Row:
    """The row of one tick of all worlds."""
    newest = observation.targets[..., 0, :]
    return Row(
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


def write(replay: Replay, row: Row) -> Replay:
    """The replay with one more row a world, over the oldest once the rings are full."""
    head = replay.written % replay.ticks
    rows = jax.tree.map(
        lambda ring, new: jax.lax.dynamic_update_index_in_dim(ring, new, head, 0), replay.rows, row
    )
    return Replay(rows, replay.written + 1)


def sample(replay: Replay, size: int, key: PRNGKeyArray) -> Batch:
    """``size`` transitions drawn with replacement; see :func:`gather` and :func:`drawable`."""
    world_key, time_key = jax.random.split(key)
    low, high = drawable(replay)
    world = jax.random.randint(world_key, (size,), 0, replay.worlds)
    return gather(replay, jax.random.randint(time_key, (size,), low, high), world)


def drawable(replay: Replay) -> tuple[Int[Array, ""], Int[Array, ""]]:
    """Ticks [low, high) whose row, next row and four rows before are all in the rings."""
    oldest = jnp.maximum(replay.written - replay.ticks, 0)
    return jnp.where(oldest > 0, oldest + FRAMES - 1, 0), replay.written - 1


def gather(replay: Replay, tick: Int[Array, " b"], world: Int[Array, " b"]) -> Batch:
    """The transitions of the given ticks (counted from the first ever written) and worlds."""
    flat = jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), replay.rows)
    here = (tick % replay.ticks) * replay.worlds + world
    start = tick - flat.age[here]
    # Row 0 is the next frame, row 1 this one, rows 2-5 the past: clamped to the episode.
    wanted = jnp.maximum(tick[:, None] + 1 - jnp.arange(FRAMES + 1), start[:, None])
    frames = flat.frame[(wanted % replay.ticks) * replay.worlds + world[:, None]]
    slots = flat.rewards.shape[-1] - 1
    present = jnp.unpackbits(flat.present[here], axis=-1, count=slots).astype(bool)
    waypoint = frames[..., :_WP]
    targets = frames[..., _WP:].reshape(-1, FRAMES + 1, slots, _OTH).swapaxes(1, 2)
    rewards = flat.rewards[here]
    return Batch(
        Observation(waypoint[:, 1:], targets[:, :, 1:], present),
        flat.action[here],
        Reward(rewards[:, 0], rewards[:, 1:]),
        Observation(waypoint[:, :-1], targets[:, :, :-1], present),
        flat.action[((tick + 1) % replay.ticks) * replay.worlds + world],
        flat.terminated[here],
        flat.transition[here].astype(jnp.float32),
    )
