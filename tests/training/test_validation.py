import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.core.geometry import Vector
from glasshelm.encounters.random_encounters import PAPER, validation_encounters
from glasshelm.encounters.types import Encounter, straight_track
from glasshelm.networks.critics import QValues
from glasshelm.ship.nomoto import ShipState, ship_named
from glasshelm.simulation.rollout import plain_cases, rollout
from glasshelm.training.critic_accuracy import critic_accuracy
from glasshelm.training.exploration import NoiseSettings
from glasshelm.training.validation import LEAST_RETURN, Memoryless, score, validate

SHIP = ship_named("paper")


class Amidships(eqx.Module):
    def __call__(self, observation, fleet=None):
        return jnp.zeros(observation.present.shape[0])


class OnTheCourse(eqx.Module):
    """The exact value of a course that is kept in open water, when nothing else counts."""

    each: jax.Array

    def __call__(self, observation, action, fleet=None):
        return QValues(
            self.each + 1e-3 * observation.waypoint[:, 0, 1],
            jnp.zeros_like(observation.targets[:, :, 0, 0]),
        )


def encounters():
    """Three starts on north: empty sea; a ship meeting head on at 1000 s; the same at 2000 s."""
    speed = 10 * 1852 / 3600

    def one(north, present):
        zero = jnp.zeros(1)
        track = straight_track(zero, zero + north, zero + jnp.pi, zero + speed)
        own = ShipState.steady(0.0, 0.0, 0.0, SHIP.speed_m_s)
        return Encounter(own, Vector(jnp.zeros(1), jnp.full(1, 46_300.0)), track, present[None])

    cases = [(10_000.0, False), (2000 * speed, True), (4000 * speed, True)]
    return jax.tree.map(lambda *x: jnp.stack(x), *(one(n, jnp.array(p)) for n, p in cases))


def test_rates_and_returns_of_the_pilot_that_does_nothing():
    result = validate(Amidships(), encounters(), SHIP)
    assert result.intrusions == pytest.approx(1 / 3)
    assert result.intrusions_long == pytest.approx(2 / 3)
    assert result.collisions == pytest.approx(1 / 3)
    assert result.collisions_long == pytest.approx(2 / 3)
    assert result.intrusions_by_targets == (0.0, 1.0)
    assert result.rudder == 0.0
    # 240 steps on course: 0.2 a step (Eq. 17); the ships are all that costs.
    assert result.return_waypoint == pytest.approx(48.0, rel=1e-3)
    assert result.return_collision < -1.0
    assert result.total_return == result.return_waypoint + result.return_collision


def test_collisions_weigh_most_in_the_choice_of_the_pilot_kept():
    cases = plain_cases(encounters(), SHIP, 480)
    measures = jax.device_get(rollout(Memoryless(Amidships()), cases, 480))
    targets = np.array([0, 1, 1])
    bad = score(measures, targets, 480, 340.0)
    apart = eqx.tree_at(lambda m: m.range_m, measures, measures.range_m + 1e4)
    better = score(apart, targets, 480, 340.0)
    assert better.collisions == 0
    assert better.selection_loss < bad.selection_loss - 5


def test_a_policy_that_sails_in_circles_is_not_kept():
    """It meets nobody, and does not get anywhere: one that sails and intrudes sometimes is kept."""
    cases = plain_cases(encounters(), SHIP, 480)
    targets = np.array([0, 1, 1])
    measures = jax.device_get(rollout(Memoryless(Amidships()), cases, 480))
    sails = score(measures, targets, 480, 340.0)
    some = dataclasses.replace(
        sails,
        intrusions=0.2,
        intrusions_long=0.2,
        collisions=0.0,
        collisions_long=0.0,
        return_collision=-3.0,
    )
    circles = dataclasses.replace(
        some, intrusions=0.0, intrusions_long=0.0, return_waypoint=24.0, return_collision=0.0
    )
    assert some.total_return > LEAST_RETURN > circles.total_return
    assert some.selection_loss < circles.selection_loss


def test_the_validation_set_is_fixed():
    first, second = validation_encounters(SHIP, 16, PAPER), validation_encounters(SHIP, 16, PAPER)
    np.testing.assert_array_equal(first.targets.east_m, second.targets.east_m)


def test_critic_accuracy_compares_values_with_the_returns_that_followed():
    open_sea = jax.tree.map(lambda x: x[:1], encounters())
    exact = 0.2 / (1 - 0.98)
    result = critic_accuracy(Amidships(), OnTheCourse(jnp.array(exact)), open_sea, SHIP, 0.98)
    waypoint, collision = np.asarray(result.error)
    assert waypoint == pytest.approx(0.0, abs=0.1)  # what follows after 480 steps is cut off
    assert collision == 0.0
    off = critic_accuracy(Amidships(), OnTheCourse(jnp.array(exact + 2.0)), open_sea, SHIP, 0.98)
    assert float(off.error[0]) == pytest.approx(2.0, abs=0.1)


def test_critic_accuracy_with_exploration_values_what_was_done():
    """Exploration turns the ship off her course: the same values agree less with what follows."""
    open_sea = jax.tree.map(lambda x: x[:1], encounters())
    exact = OnTheCourse(jnp.array(0.2 / (1 - 0.98)))
    steady = critic_accuracy(Amidships(), exact, open_sea, SHIP, 0.98)
    noise = NoiseSettings("bursts", burst_begin=0.1, burst_end=0.2)
    exploring = critic_accuracy(Amidships(), exact, open_sea, SHIP, 0.98, exploration=noise)
    assert float(exploring.error[0]) > 10 * float(steady.error[0])
    assert float(exploring.spread[0]) > float(steady.spread[0])
