"""The picture of the world is the world, but for the errors that were asked for."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.evaluation.cases import SHIP, encounter

from glasshelm.core.geometry import Vector
from glasshelm.encounters.types import Track
from glasshelm.env.observe import LENGTH_M, SPEED_M_S
from glasshelm.env.step import observe_step, reset
from glasshelm.ship.nomoto import ShipState, advance
from glasshelm.simulation.disturbances import turned_track
from glasshelm.simulation.sensor_model import Disturbance, first_perception, next_perception

STEPS = 60
TWO = encounter((3000.0, 6000.0, 250.0, 6.0), (-2000.0, 4000.0, 100.0, 5.0), slots=2)
_EACH = ("position_m", "range_m", "bearing_rad", "course_rad", "speed_m_s", "report_interval_s")


def perfect(**other) -> Disturbance:
    zero, each = jnp.zeros(()), jnp.zeros(2)
    none = Disturbance(
        jnp.asarray(7), Vector(zero, zero), zero, zero, each > 0, *[each] * 4, each, each + 60, each
    )
    given = {k: each + v if k in _EACH else v for k, v in other.items()}
    return dataclasses.replace(none, **given)


def sail(by: Disturbance, where=TWO, rudder=0.03):
    """True observations and those shown, over 300 s with a steady rudder."""
    state = reset(where, SHIP)
    picture = first_perception(by, where, where.own)

    def go(carry, _):
        state, picture = carry
        own: ShipState = advance(state.own, jnp.asarray(rudder), SHIP, 5.0)
        own = eqx.tree_at(
            lambda s: (s.east_m, s.north_m),
            own,
            (own.east_m + 5 * by.current_m_s.x, own.north_m + 5 * by.current_m_s.y),
        )
        state = observe_step(where, state, own, SHIP).state
        picture = next_perception(by, picture, where, own, state.leg, state.step, 5.0)
        return (state, picture), (state.observation, picture.observation)

    run = jax.jit(lambda carry: jax.lax.scan(go, carry, length=STEPS)[1])
    true, shown = jax.device_get(run((state, picture)))
    return true, shown


def positions(observation):
    return observation.targets[:, :, 0, :2] * LENGTH_M


@pytest.mark.slow
def test_perfect_instruments_show_the_world_as_it_is():
    true, shown = sail(perfect())
    # To 2 m and 0.1 s: the two programs round otherwise, and TCPA is a quotient.
    np.testing.assert_allclose(shown.targets, true.targets, atol=1e-4)
    np.testing.assert_allclose(shown.waypoint, true.waypoint, atol=1e-6)
    np.testing.assert_array_equal(shown.present, true.present)


def test_dead_reckoning_is_exact_for_a_ship_that_keeps_on():
    true, shown = sail(perfect(report_interval_s=100.0))
    np.testing.assert_allclose(positions(shown), positions(true), atol=0.1)


def test_a_stale_report_misses_an_alteration_until_the_next_one():
    bent: Track = turned_track(TWO.targets, jnp.full(2, 120.0), jnp.full(2, 0.8))
    true, shown = sail(
        perfect(report_interval_s=200.0), eqx.tree_at(lambda e: e.targets, TWO, bent)
    )
    off = np.linalg.norm(positions(shown) - positions(true), axis=-1)
    before, blind, after = off[:23], off[38], off[40:]  # step 24 is 120 s, step 40 is 200 s
    assert before.max() < 0.1
    assert blind.min() > 2 * np.sin(0.4) * 5 * 70
    assert after.max() < 0.1


@pytest.mark.parametrize(("radar", "spread"), [(False, 30.0), (True, 50.0)])
def test_errors_have_the_spread_that_was_asked_for(radar, spread):
    def errors(seed):
        by = perfect(seed=seed, radar=jnp.full(2, radar), correlation_s=jnp.full(2, 1.0))
        by = dataclasses.replace(by, **{"range_m" if radar else "position_m": jnp.full(2, spread)})
        true, shown = sail(by, rudder=0.0)
        return positions(shown) - positions(true)

    found = errors(jnp.asarray(3))  # 120 nearly independent draws
    if radar:  # along the line of sight only
        length = np.linalg.norm(found, axis=-1)
        assert np.sqrt(np.mean(length**2)) == pytest.approx(spread, rel=0.2)
    else:
        assert found.std() == pytest.approx(spread, rel=0.2)


def test_radar_plots_turn_and_move_with_own_errors():
    """Own heading and position in error: a radar plot stays true to the heading line."""
    by = perfect(radar=jnp.full(2, True), own_position_m=jnp.asarray(100.0))
    by = dataclasses.replace(by, own_heading_rad=jnp.asarray(0.1))
    true, shown = sail(by)
    np.testing.assert_allclose(positions(shown), positions(true), atol=0.5)
    assert np.abs(shown.waypoint - true.waypoint).max() > 1e-3  # the way to the waypoint is not


def test_in_a_current_the_velocities_shown_are_those_of_the_positions_shown():
    by = perfect(current_m_s=Vector(jnp.asarray(0.7), jnp.asarray(-0.5)))
    _, shown = sail(by, rudder=0.0)
    moved = np.diff(positions(shown), axis=0) / 5.0
    np.testing.assert_allclose(moved, shown.targets[1:, :, 0, 3:5] * SPEED_M_S, atol=0.02)
