import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.core.errors import InputError
from glasshelm.core.geometry import Vector
from glasshelm.encounters.imazu import imazu_scenario
from glasshelm.encounters.random_encounters import PAPER, WIDE, RandomEncounters, random_encounter
from glasshelm.encounters.types import motion_at, straight_track
from glasshelm.env.observe import empty_observation, observe, push_frame
from glasshelm.env.step import targets_at
from glasshelm.env.training_envelope import (
    TrainingEnvelope,
    check_observation,
    invalid_features,
    outside_training,
)
from glasshelm.ship.nomoto import KNOT_M_S, SHIPS, ShipState

SHIP = SHIPS["paper"]
#: A pilot's training in round numbers.
SEEN = TrainingEnvelope(
    SHIP,
    RandomEncounters(
        target_speed_m_s=(2.5, 7.5),
        time_to_collision_s=(400.0, 2000.0),
        waypoint_m=(8_000.0, 46_300.0),
    ),
)
OWN = ShipState.steady(0.0, 0.0, 0.0, SHIP.speed_m_s)
FAR = Vector(jnp.asarray(0.0), jnp.asarray(46_300.0))


def ships(*rows):
    """Targets of (east [m], north [m], speed [m/s])."""
    table = np.array(rows, np.float32).reshape(-1, 3)
    columns = (table[:, 0], table[:, 1], 0 * table[:, 0], table[:, 2])
    track = straight_track(*map(jnp.asarray, columns))
    return motion_at(track, jnp.zeros(()))


@pytest.mark.slow
def test_the_training_distribution_is_inside():
    draw = jax.jit(jax.vmap(lambda k: random_encounter(k, SHIP, WIDE)))
    many = jax.device_get(draw(jax.random.split(jax.random.key(0), 20)))
    for i in range(20):
        e = jax.tree.map(lambda x, i=i: jnp.asarray(x[i]), many)
        motion = targets_at(e, jnp.zeros(()))
        waypoint = Vector(e.route.x[0], e.route.y[0])
        assert (
            outside_training(e.own, SHIP, waypoint, motion, None, TrainingEnvelope(SHIP, WIDE))
            == []
        )


def test_slow_imazu_ships_are_outside_the_paper():
    motion = motion_at(imazu_scenario("3", SHIP).encounter.targets, jnp.zeros(()))
    said = outside_training(OWN, SHIP, FAR, motion, None, TrainingEnvelope(SHIP, PAPER))
    assert said == ["1 of 1 ship slower than 8.0 kn"]
    assert outside_training(OWN, SHIP, FAR, motion, None, SEEN) == []


@pytest.mark.parametrize(
    ("change", "phrase"),
    [
        ({"loa_m": 122.0}, "own length 122 m (trained: 340 m)"),
        ({"gain_1_s": 0.035}, "own ship answers her rudder otherwise"),
        ({"rudder_rate_rad_s": 0.04}, "own ship answers her rudder otherwise"),
    ],
)
def test_another_ship_is_named(change, phrase):
    said = outside_training(
        OWN, dataclasses.replace(SHIP, **change), FAR, ships((3000, 5000, 5)), None, SEEN
    )
    assert len(said) == 1
    assert said[0].startswith(phrase)


def test_own_speed_and_waypoint_are_named():
    own = ShipState.steady(0.0, 0.0, 0.0, 15 * KNOT_M_S)
    near = Vector(jnp.asarray(0.0), jnp.asarray(926.0))
    said = outside_training(own, SHIP, near, ships(), None, SEEN)
    assert said == [
        "own speed 15.0 kn (trained: 10.0 kn)",
        "waypoint 0.5 NM off (trained: from 1.0 NM)",
    ]


def test_targets_are_counted_and_only_those_selected():
    many = ships(*[(3000, 5000 + 100 * i, 5) for i in range(9)], (60_000, 0, 0), (0, 5000, 12))
    said = outside_training(OWN, SHIP, FAR, many, None, SEEN)
    assert said == [
        "11 ships selected (trained: at most 6)",
        "1 of 11 ships slower than 4.9 kn",
        "1 of 11 ships faster than 14.6 kn",
        "1 of 11 ships farther than 14.4 NM",
    ]
    selected = np.arange(11) < 6
    assert outside_training(OWN, SHIP, FAR, many, selected, SEEN) == []


def test_nan_is_named_and_refused():
    motion = ships((3000, 5000, 5), (1000, 9000, 5))
    broken = dataclasses.replace(motion, speed_m_s=motion.speed_m_s.at[1].set(jnp.nan))
    observation = push_frame(empty_observation(2), observe(OWN, FAR, broken, broken.present), True)
    said = invalid_features(observation, ["ALPHA", "BRAVO"])
    assert len(said) == 1
    assert said[0].startswith("BRAVO is seen with no finite vx, vy")
    with pytest.raises(InputError, match="cannot decide: BRAVO"):
        check_observation(observation, ["ALPHA", "BRAVO"])
    gone = observe(OWN, FAR, broken, jnp.array([True, False]))
    assert invalid_features(push_frame(empty_observation(2), gone, True)) == []


def test_a_nan_waypoint_is_named():
    nowhere = Vector(jnp.asarray(jnp.nan), FAR.y)
    observation = push_frame(
        empty_observation(0), observe(OWN, nowhere, ships(), ships().present), True
    )
    assert invalid_features(observation) == ["the waypoint is seen with no finite dx, dy, bearing"]


def test_a_feature_that_no_ship_can_have_is_named():
    observation = push_frame(
        empty_observation(1), observe(OWN, FAR, ships((3000, 5000, 5)), jnp.array([True])), True
    )
    for value in (1e38, -1e7):
        huge = eqx.tree_at(
            lambda s: s.targets, observation, observation.targets.at[0, 2, 3].set(value)
        )
        assert invalid_features(huge, ["ALPHA"]) == ["ALPHA is seen with an impossible vx"]
    with pytest.raises(InputError, match="the waypoint is seen with an impossible dx"):
        check_observation(
            eqx.tree_at(lambda s: s.waypoint, observation, observation.waypoint.at[0, 0].set(3e6))
        )
