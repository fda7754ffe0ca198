import jax
import numpy as np
import pytest
from tests.untrained import untrained

from glasshelm.encounters.random_encounters import random_scenario
from glasshelm.pilots.straight import StraightPilot
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.prediction import predict_track
from glasshelm.simulation.voyage import Voyage

SHIP = SHIPS["paper"]
STEPS = 40


def ahead(voyage: Voyage):
    place = voyage.place
    state, memory = place.carry.state, place.carry.memory
    args = (place.pilot, voyage.encounter, state, memory, voyage.ship, voyage.settings)
    return jax.device_get(predict_track(*args, ahead_s=200.0))


@pytest.mark.parametrize("pilot", [StraightPilot(), untrained()], ids=["straight", "learned"])
def test_targets_that_keep_straight_on_make_the_prediction_come_true(pilot):
    voyage = Voyage(random_scenario(5, SHIP), pilot, 100)
    voyage.advance(8)
    own = ahead(voyage)
    frames = voyage.advance(STEPS + 1)
    for predicted_m, sailed in ((own.east_m, "east_m"), (own.north_m, "north_m")):
        wanted = [getattr(frame.own, sailed) for frame in frames]
        np.testing.assert_allclose(predicted_m, wanted, atol=0.5)
    turned = np.ptp(np.unwrap(own.heading_rad))
    assert turned > 0.2 or isinstance(pilot, StraightPilot)


def test_predicting_changes_nothing():
    voyage = Voyage(random_scenario(5, SHIP), untrained(), 100)
    voyage.advance(8)
    before = voyage.place
    ahead(voyage)
    assert voyage.place is before
