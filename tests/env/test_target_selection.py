import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from glasshelm.core.geometry import Vector
from glasshelm.encounters.types import motion_at, straight_track
from glasshelm.env.observe import Observation, empty_observation, observe, push_frame
from glasshelm.env.target_selection import RANGE_M, select_targets, smallest_distance
from glasshelm.ship.domain import danger_unclipped
from glasshelm.ship.nomoto import ShipState

LOA_M = 340.0


def traffic(rng: np.random.Generator, slots: int, spread_m: float = 25_000.0) -> Observation:
    east, north = rng.uniform(-spread_m, spread_m, (2, slots)).astype(np.float32)
    course = rng.uniform(-np.pi, np.pi, slots).astype(np.float32)
    speed = rng.uniform(0, 12, slots).astype(np.float32)
    return seen_of(east, north, course, speed, rng.uniform(size=slots) < 0.9)


def seen_of(east, north, course, speed, present) -> Observation:
    columns = (jnp.asarray(x, jnp.float32) for x in (east, north, course, speed))
    return look(*columns, jnp.asarray(present))


@jax.jit
def look(east, north, course, speed, present) -> Observation:
    motion = motion_at(straight_track(east, north, course, speed), jnp.zeros(()))
    own = ShipState.steady(0.0, 0.0, 0.7, 5.0)
    waypoint = Vector(jnp.asarray(0.0), jnp.asarray(46_300.0))
    sight = observe(own, waypoint, motion, present)
    return push_frame(empty_observation(east.shape[0]), sight, True)


select = jax.jit(select_targets, static_argnums=(1, 2))


def permuted(observation: Observation, order: np.ndarray) -> Observation:
    return Observation(observation.waypoint, observation.targets[order], observation.present[order])


def chosen(observation: Observation, capacity: int) -> set[int]:
    selected, indices = select(observation, capacity, LOA_M)
    return set(np.asarray(indices)[np.asarray(selected.present)].tolist())


def range_m(observation: Observation) -> np.ndarray:
    return np.hypot(*np.asarray(observation.targets[:, 0, :2]).T) * 20_000


def test_few_slots_pass_unchanged():
    observation = traffic(np.random.default_rng(0), 6)
    selected, indices = select_targets(observation, 6)
    assert selected is observation
    np.testing.assert_array_equal(indices, np.arange(6))


@pytest.mark.parametrize("slots", [0, 1])
def test_nobody_and_one(slots):
    selected, indices = select_targets(empty_observation(slots), 20)
    assert selected.present.shape == indices.shape == (slots,)


@given(st.integers(0, 10_000))
def test_chosen_ships_do_not_depend_on_the_order_of_slots(seed):
    rng = np.random.default_rng(seed)
    observation, order = traffic(rng, 40), rng.permutation(40)
    assert {int(order[i]) for i in chosen(permuted(observation, order), 8)} == chosen(
        observation, 8
    )


@given(st.integers(0, 10_000))
def test_a_ship_in_the_domain_is_always_selected(seed):
    rng = np.random.default_rng(seed)
    observation = traffic(rng, 40, spread_m=5_000.0)
    x, y = np.asarray(observation.targets[:, 0, :2]).T * 20_000
    half_axes = np.where(x >= 0, 3.2, 1.6) * LOA_M, np.where(y >= 0, 6.4, 1.6) * LOA_M
    inside = np.hypot(x / half_axes[0], y / half_axes[1]) < 1
    inside = set(np.flatnonzero(inside & np.asarray(observation.present)).tolist())
    kept = chosen(observation, 4)
    assert inside <= kept if len(inside) <= 4 else kept <= inside


@given(st.integers(0, 10_000))
def test_only_ships_that_are_there_and_near(seed):
    observation = traffic(np.random.default_rng(seed), 40)
    near = (range_m(observation) <= RANGE_M) & np.asarray(observation.present)
    kept = chosen(observation, 39)
    assert kept <= set(np.flatnonzero(near).tolist())
    assert len(kept) == min(39, near.sum())


def test_fed_rows_are_those_of_their_slots_and_the_rest_is_zero():
    observation = traffic(np.random.default_rng(3), 40)
    present = observation.present.at[5:].set(False)
    observation = Observation(observation.waypoint, observation.targets, present)
    selected, indices = select(observation, 8, LOA_M)
    for slot in range(8):
        expected = observation.targets[indices[slot]] if selected.present[slot] else 0.0
        np.testing.assert_array_equal(selected.targets[slot], jnp.broadcast_to(expected, (5, 10)))
    assert bool(jnp.all(indices[1:] > indices[:-1]))


def test_a_ship_on_collision_course_comes_before_a_nearer_one_that_opens():
    # 30 ships opening at 4 km, one far ahead that comes straight at own ship.
    bearing = np.linspace(-3, 3, 30) + 0.7
    east, north = 4000 * np.sin(bearing), 4000 * np.cos(bearing)
    own_v = 5.0 * np.array([np.sin(0.7), np.cos(0.7)])
    # Velocity over ground = own velocity + 5 m/s straight away from her.
    v = own_v[:, None] + 5 * np.array([np.sin(bearing), np.cos(bearing)])
    course, speed = np.arctan2(v[0], v[1]), np.hypot(*v)
    ahead = 12_000 * np.array([np.sin(0.7), np.cos(0.7)])
    observation = seen_of(
        np.append(east, ahead[0]),
        np.append(north, ahead[1]),
        np.append(course, 0.7 + np.pi),
        np.append(speed, 5.0),
        np.ones(31, bool),
    )
    assert chosen(observation, 1) == {30}


@jax.jit
def both_distances(p: Vector, v: Vector, t):
    path = Vector(p.x + v.x * t, p.y + v.y * t)
    return jnp.min(1 - danger_unclipped(path, 1.0), axis=0), smallest_distance(p, v)


@given(st.integers(0, 10_000))
def test_smallest_distance_against_small_steps(seed):
    rng = np.random.default_rng(seed)
    px, py = rng.uniform(-15_000, 15_000, (2, 20)).astype(np.float32)
    vx, vy = rng.uniform(-15, 15, (2, 20)).astype(np.float32)
    vx[0] = vy[0] = 0.0
    t = jnp.linspace(0, 1800, 3601)[:, None]
    position, motion = (Vector(jnp.asarray(x), jnp.asarray(y)) for x, y in ((px, py), (vx, vy)))
    brute, exact = both_distances(position, motion, t)
    assert bool(jnp.all(exact <= brute * (1 + 1e-4) + 0.1))
    np.testing.assert_allclose(exact, brute, rtol=1e-2, atol=5.0)


def test_jit_and_vmap_agree_with_eager():
    pair = [traffic(np.random.default_rng(i), 30) for i in range(2)]
    stacked = jax.tree.map(lambda *x: jnp.stack(x), *pair)
    selected, indices = jax.jit(jax.vmap(lambda s: select_targets(s, 8, LOA_M)))(stacked)
    for i, observation in enumerate(pair):
        one, places = select_targets(observation, 8, LOA_M)
        np.testing.assert_array_equal(indices[i], places)
        np.testing.assert_array_equal(selected.targets[i], one.targets)
