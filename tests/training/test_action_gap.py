"""What is at stake in a choice between manoeuvres."""

import jax
import numpy as np
import pytest
from tests.pilots.scenes import meeting

from glasshelm.encounters.imazu import imazu_scenario
from glasshelm.env.observe import Observation
from glasshelm.env.step import reset
from glasshelm.explanation.manoeuvre_explanation import choose
from glasshelm.planning.simulated_critic import SimulatedCritic
from glasshelm.planning.situation import rudder_towards
from glasshelm.ship.nomoto import SHIPS
from glasshelm.training.action_gap import action_gap

CRITIC = SimulatedCritic()
begin = jax.jit(reset, static_argnums=1)


def gap(observation: Observation, ship) -> float:
    return float(jax.jit(lambda o: action_gap(*CRITIC(o, ship), o, ship))(observation))


def test_more_is_at_stake_with_a_ship_ahead():
    ship = SHIPS["large_ship"]
    calm, tense = (
        gap(begin(meeting(row, ship=ship), ship).observation, ship)
        for row in ((9000.0, 9000.0, 0.0, 5.0), (0.0, 6000.0, 180.0, 5.0))
    )
    assert tense > 3 * calm


@pytest.mark.slow
def test_between_two_ways_out_the_middle_is_what_costs():
    """Imazu 19: two ships close in from both sides; a turn to either is better than none."""
    ship = SHIPS["paper"]
    observation = begin(imazu_scenario("19", ship).encounter, ship).observation
    manoeuvres, found = jax.jit(lambda o: CRITIC(o, ship))(observation)
    towards = jax.jit(jax.vmap(lambda offset: rudder_towards(offset, observation, ship)))
    rudders, values = np.asarray(towards(manoeuvres.offset_rad)), np.asarray(found.total)
    first = rudders[int(choose(found))]
    lasts = np.asarray((manoeuvres.duration_s == 0.0) | (manoeuvres.duration_s >= 200.0))
    across = values[lasts & (rudders * np.sign(first) < -0.5)].max()
    middle = values[lasts & (np.abs(rudders) < 0.25)].max()
    assert abs(first) > 0.5
    assert values.max() > across > middle + 20.0
    assert gap(observation, ship) == pytest.approx(values.max() - middle, rel=1e-5)
