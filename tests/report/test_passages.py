import numpy as np
import pytest
from tests.voyages import LOA_M, SPEED_M_S, STEP_S, Other, plain, voyage

from glasshelm.frames.series import to_series
from glasshelm.report.passages import OutsideTraining, describe, outside_training, passages, verdict

AHEAD = [0.0] * 200


def test_closest_approach_is_that_of_the_track():
    v = to_series(voyage(AHEAD, [Other("A", 2000, 3000, 270)]))
    (found,) = passages(v)
    ranges = np.hypot(v.ships[0].east_m - v.east_m, v.ships[0].north_m - v.north_m)
    assert found.closest == ranges.argmin()
    assert found.closest_m == pytest.approx(ranges.min())
    assert found.is_minimum


def test_a_ship_that_only_opens_has_no_passage():
    (found,) = passages(voyage(AHEAD, [Other("A", 0, -2000, 180)]))
    assert not found.is_minimum
    assert found.closest == 0


def test_nearest_first():
    found = passages(voyage(AHEAD, [Other("far", 5000, 0, 0), Other("near", 2000, 0, 0)]))
    assert [p.name for p in found] == ["near", "far"]


def test_time_in_the_domain_is_the_time_that_danger_is_positive():
    # A ship at rest, dead ahead: in the domain from 6.4 LOA ahead to 1.6 LOA astern.
    v = to_series(voyage([0.0] * 1200, [Other("buoy", 100, 3000, 0, speed_m_s=0.0)]))
    (found,) = passages(v)
    shape = np.sqrt(1 - (100 / (3.2 * LOA_M)) ** 2)
    expected = (6.4 + 1.6) * LOA_M * shape / SPEED_M_S
    assert found.inside_s == pytest.approx(expected, abs=2 * STEP_S)


def test_verdict_without_intrusion():
    text = verdict(plain())
    assert text.startswith("No ship came nearer than")
    assert "none entered the domain" in text


def test_verdict_with_intrusion_names_the_ship():
    text = verdict(voyage([0.0] * 100, [Other("Aurora", -500, -900, 0, 7.0)]))
    assert "The domain was entered by one ship: Aurora" in text


def test_verdict_of_a_collision():
    assert "collision" in verdict(voyage(AHEAD, [Other("Aurora", 0, 2000, 180)]))


def test_verdict_of_an_empty_sea():
    assert verdict(voyage(AHEAD)) == "No other ship was there."


def test_side_of_the_closest_approach():
    (found,) = passages(voyage(AHEAD, [Other("A", 2000, 800, 0, 3.0)]))
    assert describe(found).endswith("on the starboard beam")


def test_outside_tells_first_frame_and_share():
    frames = voyage([0.0] * 10, outside_training=lambda k: ["too fast"] if k >= 5 else None)
    assert outside_training(frames) == [OutsideTraining("too fast", 5, 0.5)]


def test_outside_takes_words_with_other_numbers_for_the_same_kind():
    frames = voyage([0.0] * 4, outside_training=lambda k: [f"own speed {k}.5 kn", "many ships"])
    assert outside_training(frames) == [
        OutsideTraining("own speed 0.5 kn", 0, 1.0),
        OutsideTraining("many ships", 0, 1.0),
    ]
