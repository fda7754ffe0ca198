"""Johansen's MPC: the offset of least cost, by an independent brute force of the formula."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.pilots.scenes import colliding, observed

from glasshelm.core.geometry import wrap_angle
from glasshelm.pilots.scenario_mpc import ScenarioSettings, scenario_costs, scenario_course
from glasshelm.planning.situation import situation_of
from glasshelm.ship.autopilot import autopilot_for
from glasshelm.ship.nomoto import SHIPS, ShipState, advance

SHIP = SHIPS["paper"]
SETTINGS = ScenarioSettings(
    offsets_deg=(-60.0, 0.0, 60.0), horizon_s=900.0, step_s=5.0, safe_m=1500.0, close_m=3000.0
)


def by_hand(row, last_deg=0.0) -> np.ndarray:
    """The printed cost, sailing own ship in the world itself and looking every 5 s."""
    east, north, heading, speed = row
    way, helm = np.radians(heading), autopilot_for(SHIP)
    hers = speed * np.array([np.sin(way), np.cos(way)])
    costs = []
    for degrees in SETTINGS.offsets_deg:
        offset, worst = np.radians(degrees), 0.0
        own = ShipState.steady(0.0, 0.0, 0.0, SHIP.speed_m_s)
        for k in range(1, round(SETTINGS.horizon_s / SETTINGS.step_s) + 1):
            error = wrap_angle(jnp.float32(offset) - own.heading_rad)
            rudder = helm.rudder_rad(error, own.rate_of_turn_rad_s)
            own = _advance(own, rudder)
            time, psi = k * SETTINGS.step_s, float(own.heading_rad)
            apart = np.array([east, north]) + hers * time
            apart = apart - [float(own.east_m), float(own.north_m)]
            distance = np.hypot(*apart)
            mine = SHIP.speed_m_s * np.array([np.sin(psi), np.cos(psi)])
            hazard = 0.0
            if distance < SETTINGS.safe_m:
                risk = (SETTINGS.safe_m / distance) ** SETTINGS.range_exponent
                risk /= time**SETTINGS.time_exponent
                hazard += SETTINGS.collision_gain * ((mine - hers) ** 2).sum() * risk
            bearing = (np.arctan2(*apart) - psi + np.pi) % (2 * np.pi) - np.pi
            cosine = mine @ hers / (SHIP.speed_m_s * speed)
            head_on = cosine < -np.cos(np.radians(22.5)) and abs(bearing) < np.radians(68.5)
            from_port = (way - psi + np.pi) % (2 * np.pi) - np.pi < 0
            faster = speed > SHIP.speed_m_s and cosine > np.cos(np.radians(68.5))
            crossing = cosine < np.cos(np.radians(68.5)) and from_port and not faster
            if distance < SETTINGS.close_m and bearing >= 0 and (head_on or crossing):
                hazard += SETTINGS.rules_cost
            worst = max(worst, hazard)
        change = offset - np.radians(last_deg)
        gain = SETTINGS.to_starboard_gain if change > 0 else SETTINGS.to_port_gain
        costs.append(worst + SETTINGS.offset_gain * offset**2 + gain * change**2)
    return np.array(costs)


def near_by(course_deg: float) -> tuple[float, ...]:
    """A ship who crosses some 200 m off: at none the risk is infinite, and rounding decides."""
    east, north, course, speed = colliding(course_deg, tcpa_s=500.0)
    return (float(east), float(north) + 300.0, course, speed)


_advance = jax.jit(lambda own, rudder: advance(own, rudder, SHIP, SETTINGS.step_s))


@jax.jit
def _ours(s, last):
    return (
        scenario_costs(situation_of(s, SHIP), last, SHIP, SETTINGS)[1],
        scenario_course(s, last, SHIP, SETTINGS),
    )


@pytest.mark.parametrize(
    ("row", "last_deg"),
    [
        ((300.0, 5500.0, 180.0, 5.0), 0.0),
        (near_by(265.0), 0.0),
        (near_by(95.0), 60.0),
    ],
)
def test_costs_are_the_formula_s_and_the_least_is_taken(row, last_deg):
    last = jnp.radians(jnp.float32(last_deg))
    ours, chosen = _ours(observed(row), last)
    expected = by_hand(row, last_deg)
    np.testing.assert_allclose(ours, expected, rtol=0.05, atol=0.05)
    assert np.degrees(float(chosen)) == pytest.approx(
        SETTINGS.offsets_deg[int(np.argmin(expected))], abs=1e-3
    )


def test_at_the_very_place_of_the_other_the_cost_is_finite_and_above_all_others():
    costs = np.asarray(_ours(observed(colliding(265.0, tcpa_s=500.0)), jnp.zeros(()))[0])
    assert np.isfinite(costs).all()
    assert costs[1] > 1e6 * costs[[0, 2]].max()


def test_starboard_is_cheaper_than_port():
    cheap = dataclasses.replace(SETTINGS, horizon_s=5.0)
    assert cheap.to_starboard_gain < cheap.to_port_gain
    costs = np.asarray(_ours(observed((0.0, 30_000.0, 180.0, 5.0)), jnp.zeros(()))[0])
    assert costs[2] < costs[0]
    assert costs[1] == 0.0
