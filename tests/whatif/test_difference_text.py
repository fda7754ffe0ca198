"""Two futures that differ are told apart; two that do not are not."""

import dataclasses
import math

import pytest

from glasshelm.encounters.scenario_factory import scenario_from
from glasshelm.frames.schema import BySubTask
from glasshelm.pilots.registry import pilot_named
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.voyage import simulate
from glasshelm.whatif.ask import what_if
from glasshelm.whatif.changes import Deleted, Hidden
from glasshelm.whatif.difference_text import describe_difference
from glasshelm.whatif.outcome import Alteration, Differences, Outcome

TURN = Alteration(math.radians(-20), 600.0, 560.0, True)
FACT = Outcome((), 0.0, 340.0, True, BySubTask(0.0, 0.0, 0.0), 0.35, TURN, 1800.0)


def told(turn: Alteration | None, apart_m: float) -> str:
    parted = Differences(0.0, 0.02, apart_m, math.radians(-9), 300.0)
    other = dataclasses.replace(FACT, alteration=turn)
    return describe_difference("without ship 2", [Hidden("2")], FACT, other, parted)


@pytest.mark.slow
def test_a_turn_at_once_is_not_the_same_as_one_later():
    """Both end on one heading after 17 minutes, but on tracks 0.68 NM apart."""
    pilot = pilot_named("paper-sum")
    frames = list(simulate(scenario_from("imazu:5", SHIPS["paper"]), pilot, 112))
    assert frames[111].time_s == 555.0
    answer = what_if(frames, 111, pilot, [Deleted("2")])
    assert answer.summary.startswith(
        "Without ship 2, the pilot would return to course, 21° to port, half of it within 70 s "
        "instead of 15 min; the tracks part by 0.68 NM at most. Nearest would be ship 1"
    )
    assert "same" not in answer.summary


@pytest.mark.parametrize(
    ("turn", "apart_m", "words"),
    [
        (TURN, 150.0, "would do much the same: return to course, 20° to port within 10 min; the "),
        (TURN, 300.0, "would return to course, 20° to port within 10 min, as it does as things "
         "are, but head up to 9° more to port after 5 min; the tracks part by 0.16 NM at most."),
        (dataclasses.replace(TURN, half_s=60.0), 150.0,
         "would return to course, 20° to port, half of it within 60 s instead of 9.3 min; the "),
        (dataclasses.replace(TURN, turn_rad=math.radians(-30)), 150.0,
         "would return to course, 30° to port within 10 min; as things are, it returns to "),
    ],
)  # fmt: skip
def test_much_the_same_is_said_of_tracks_that_are(turn, apart_m, words):
    assert f"Without ship 2, the pilot {words}" in told(turn, apart_m)
