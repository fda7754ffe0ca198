import pytest

import glasshelm
from glasshelm.frames.series import to_series
from glasshelm.paper import findings
from glasshelm.paper.paper_figures import INSTANTS_S
from glasshelm.paper.paper_items import ENCOUNTER


@pytest.mark.slow
def test_critics_that_steer_show_avoiding_and_return_as_the_paper_describes_them():
    """Fig. 11: to starboard for the ships at 600 s, to port for the waypoint at 750 s."""
    pilot, scenario = glasshelm.pilot("paper-glassbox"), glasshelm.scenario(ENCOUNTER)
    assert len(scenario.targets) == 4
    voyage = to_series(list(glasshelm.simulate(scenario, pilot, 150)))
    away, back = (voyage.at(time) for time in INSTANTS_S)
    assert voyage.rudder_rad[away] > 0.01
    assert voyage.priority_collision[away] > 100.0
    assert voyage.rudder_rad[back] < -0.01
    assert voyage.waypoint_bearing_rad[back] < 0.0
    assert voyage.priority_waypoint[back] > 1.0
    assert voyage.priority_collision[back] < voyage.priority_collision[away]
    assert "As the paper" in findings.of_priorities(voyage, INSTANTS_S)
    assert max(ship.danger.max() for ship in voyage.ships) == 0.0
