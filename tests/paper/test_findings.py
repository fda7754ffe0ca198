import msgspec
import pytest
from tests.voyages import Other, learned, voyage

from glasshelm.frames.series import to_series
from glasshelm.paper import findings

INSIDE = Other("A", 0.0, 900.0, 180.0, q=lambda k: -1.0)
CLEAR = Other("A", 9000.0, 0.0, 90.0, q=lambda k: 0.5)


def test_tracks_say_how_many_came_into_the_domain():
    text = findings.of_tracks([to_series(voyage([0.0] * 20, [one])) for one in (INSIDE, CLEAR)])
    assert "in 1 of 2 encounters" in text
    assert "0 of 1" in findings.of_tracks([to_series(voyage([0.0] * 20, [CLEAR]))])


def test_ships_that_close_in_are_compared_with_the_others():
    both = [to_series(voyage([0.0] * 5, [one])) for one in (INSIDE, CLEAR)]
    text = findings.of_values(both)
    assert "−1.0; of all others: +0.500. 100%" in text
    assert "nothing to compare" in findings.of_values(both[1:])


@pytest.mark.parametrize(
    ("rudder", "ships", "waypoint", "words"),
    [
        (3.0, 0.5, 0.2, "As the paper"),
        (-3.0, 0.5, 0.2, "turn to starboard"),
        (3.0, -0.5, 0.2, "turn to starboard"),
        (3.0, 0.5, -0.2, "turn back"),
    ],
)
def test_priorities_are_held_against_what_the_paper_says(rudder, ships, waypoint, words):
    """The waypoint lies to port: own ship must turn to port to come back."""
    frames = voyage(
        [20.0] * 20,
        [Other("A", 3000, 3000, 270, priority=lambda k: ships - 0.1 * (k > 10))],
        waypoint_priority=lambda k: waypoint,
        rudder_deg=lambda k: rudder if k < 10 else -3.0,
    )
    text = findings.of_priorities(to_series(frames), (25.0, 75.0))
    assert words in text
    assert "At 25 s rudder 3.0°" in text


def test_attention_goes_from_ship_to_ship():
    text = findings.of_attention(to_series(learned()))
    assert "Aurora, Borealis." in text
    assert "Borealis has 80%" in text


def test_frames_that_do_not_add_up_are_found_out():
    frames = learned()
    assert float(findings.held([to_series(frames)])["13"].split("at most ")[1].split()[0]) < 1e-6
    wrong = msgspec.structs.replace(frames[0].targets[0], danger=0.5)
    broken = [msgspec.structs.replace(frames[0], targets=[wrong]), *frames[1:]]
    assert "5e-01" in findings.held([to_series(broken)])["13"]
