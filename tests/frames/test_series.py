import dataclasses

import numpy as np
import pytest
from tests.voyages import Other, learned, plain, voyage

from glasshelm.core.errors import InputError
from glasshelm.frames.series import ships_of_note, to_series


def test_a_voyage_without_frames_is_refused():
    with pytest.raises(InputError, match="no frames"):
        to_series([])


def test_a_series_is_returned_as_it_is():
    once = to_series(plain())
    assert to_series(once) is once


def test_body_frame_position_agrees_with_the_tracks():
    v = to_series(learned())
    for ship in v.ships:
        east, north = ship.east_m - v.east_m, ship.north_m - v.north_m
        sine, cosine = np.sin(v.heading_rad), np.cos(v.heading_rad)
        np.testing.assert_allclose(ship.starboard_m, east * cosine - north * sine, atol=1e-6)
        np.testing.assert_allclose(ship.ahead_m, east * sine + north * cosine, atol=1e-6)


def test_absence_and_loss_break_the_track():
    there = Other("A", 1000, 1000, 0, here=lambda k: k >= 3, lost=lambda k: k >= 7)
    ship = to_series(voyage([0.0] * 10, [there])).ships[0]
    assert np.isfinite(ship.range_m).tolist() == [3 <= k < 7 for k in range(10)]


def test_what_a_pilot_does_not_have_is_not_a_zero():
    v = to_series(plain())
    assert not v.has("priority_waypoint")
    assert not v.has("priority")
    assert not v.has("attention")
    assert v.has("danger")


def test_heading_runs_on_through_north():
    v = to_series(voyage([358.0, 359.0, 0.0, 1.0]))
    np.testing.assert_allclose(np.degrees(np.diff(v.heading_rad)), 1.0, atol=1e-9)


def test_waypoint_bearing_is_relative_to_the_heading():
    v = to_series(voyage([30.0, 30.0]))
    assert np.degrees(v.waypoint_bearing_rad[0]) == pytest.approx(-30, abs=1e-6)


def test_notable_are_the_nearest_and_the_most_wanted():
    far = Other("wanted", 0, 30_000, 0, priority=lambda k: 1.0)
    near = [Other(f"near {i}", 1000.0 * i, 500, 0, priority=lambda k: 0.0) for i in range(1, 9)]
    v = to_series(voyage([0.0] * 5, [*near, far], waypoint_priority=lambda k: 0.0))
    kept = [s.name for s in ships_of_note(v, 4)]
    assert "wanted" in kept
    assert "near 1" in kept
    assert "near 8" not in kept
    assert len(kept) == 4


def test_ships_have_every_field_of_the_frames():
    names = {f.name for f in dataclasses.fields(to_series(plain()).ships[0])}
    assert {"danger", "q", "priority", "attention", "intention", "intention_level"} <= names
