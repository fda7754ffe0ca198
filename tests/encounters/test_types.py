import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from glasshelm.encounters.tracks import TrackColumns, single_track, stack_tracks
from glasshelm.encounters.types import Track, motion_at, straight_track

motion = jax.jit(motion_at)


def random_rows(rng: np.random.Generator, lasts_s: float) -> list[TrackColumns]:
    rows = []
    for legs in rng.integers(1, 7, 5):
        start = np.sort(rng.uniform(-200, 1000, legs))
        east, north = rng.uniform(-5000, 5000, (2, legs))
        rows.append(
            TrackColumns.of(
                start, east, north, rng.uniform(-4, 4, legs), rng.uniform(0, 9, legs), lasts_s
            )
        )
    # The widest row is of fixed size, so that one compiled program serves all examples.
    start = np.linspace(0, 900, 8)
    rows.append(TrackColumns.of(start, start, start, 0 * start, 0 * start + 5, lasts_s))
    return rows


def by_hand(row: TrackColumns, time_s: float):
    """The latest leg that has begun, if it has not ended; plain loop."""
    latest = None
    for i, start in enumerate(row.start_s):
        if start <= time_s:
            latest = i
    if latest is None or time_s >= row.end_s[latest]:
        return None
    age = time_s - row.start_s[latest]
    run = row.speed_m_s[latest] * age
    return (
        row.east_m[latest] + run * np.sin(row.course_rad[latest]),
        row.north_m[latest] + run * np.cos(row.course_rad[latest]),
        age,
    )


@given(st.integers(0, 10_000), st.integers(-300, 1500), st.sampled_from([120.0, np.inf]))
def test_motion_of_many_legs_against_a_plain_loop(seed, time_s, lasts_s):
    rows = random_rows(np.random.default_rng(seed), lasts_s)
    now = motion(stack_tracks(rows), jnp.asarray(time_s, jnp.float32))
    for i, row in enumerate(rows):
        expected = by_hand(row, time_s)
        assert bool(now.present[i]) == (expected is not None)
        if expected is not None:
            np.testing.assert_allclose(
                [now.east_m[i], now.north_m[i], now.age_s[i]], expected, atol=0.05
            )


def test_not_yet_heard_then_there_then_lost():
    row = TrackColumns.of([100.0, 130.0], [0, 0], [0, 300], [0, 0], [10, 10], leg_duration_s=60.0)
    track = single_track(row)
    expected = {99: None, 100: 0.0, 129: 290.0, 130: 300.0, 189: 890.0, 190: None}
    for time_s, north in expected.items():
        now = motion_at(track, jnp.asarray(float(time_s)))
        assert bool(now.present) == (north is not None)
        if north is not None:
            assert float(now.north_m) == pytest.approx(north)


def test_a_gap_between_reports_is_a_gap():
    track = single_track(
        TrackColumns.of([0.0, 1000.0], [0, 0], [0, 0], [0, 0], [1, 1], leg_duration_s=360.0)
    )
    there = [bool(motion_at(track, jnp.asarray(t)).present) for t in (359.0, 361.0, 999.0, 1001.0)]
    assert there == [True, False, False, True]


def test_absent_ships_have_finite_places():
    track = stack_tracks(
        [
            TrackColumns.of([50.0], [1], [2], [0], [3], 10.0),
            TrackColumns.of([0], [0], [0], [0], [1]),
        ]
    )
    for time_s in (0.0, 55.0, 1e5):
        for value in jax.tree.leaves(motion_at(track, jnp.asarray(time_s))):
            assert bool(jnp.all(jnp.isfinite(value)))


def test_a_straight_track_is_for_ever():
    track = straight_track(*(jnp.asarray([x]) for x in (10.0, 20.0, np.pi / 2, 4.0)))
    for time_s in (-100.0, 0.0, 5000.0):
        now = motion_at(track, jnp.asarray(time_s))
        if time_s >= 0:
            assert bool(now.present[0])
            assert float(now.east_m[0]) == pytest.approx(10 + 4 * time_s)
            assert float(now.north_m[0]) == pytest.approx(20, abs=1e-2)
        else:
            assert not bool(now.present[0])


def test_no_ships_and_no_slots_axis():
    empty = stack_tracks([])
    assert motion_at(empty, jnp.zeros(())).present.shape == (0,)
    one = single_track(TrackColumns.of([0.0, 1.0], [0, 0], [0, 0], [0, 0], [1, 1]))
    assert isinstance(one, Track)
    assert motion_at(one, jnp.zeros(())).present.shape == ()


def test_padding_legs_change_nothing():
    rng = np.random.default_rng(1)
    row = random_rows(rng, 200.0)[0]
    long = TrackColumns.of(np.arange(9.0), *np.zeros((4, 9)))
    for time_s in (-250.0, 0.0, 400.0, 2000.0):
        alone = motion_at(stack_tracks([row]), jnp.asarray(time_s))
        padded = motion_at(stack_tracks([row, long]), jnp.asarray(time_s))
        for a, b in zip(jax.tree.leaves(alone), jax.tree.leaves(padded), strict=True):
            np.testing.assert_array_equal(a[0], b[0])
