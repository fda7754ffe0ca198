import dataclasses
import itertools
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.core.errors import InputError
from glasshelm.ship.nomoto import SHIPS, ShipParams, ShipState, advance, check_ship, ship_named

PAPER, LARGE = SHIPS["paper"], SHIPS["large_ship"]
FIVE_DEG = math.radians(5)


def at_rest(ship: ShipParams, heading: float = 0.0) -> ShipState:
    return ShipState.steady(0.0, 0.0, heading, ship.speed_m_s)


def sail(state: ShipState, rudder: float, ship: ShipParams, step_s: float, steps: int) -> ShipState:
    def go(s, _):
        s = advance(s, jnp.asarray(rudder, s.east_m.dtype), ship, step_s)
        return s, s

    return jax.jit(lambda s: jax.lax.scan(go, s, None, length=steps)[1])(state)


def double(state: ShipState) -> ShipState:
    return jax.tree.map(lambda x: jnp.asarray(np.asarray(x, np.float64)), state)


def runge_kutta(ship: ShipParams, start: dict[str, float], command: float, duration: float):
    """Heading, rate of turn, rudder, east, north by RK4 on 4000 steps in double precision."""
    steps = 4000
    h = duration / steps

    def slope(t, y):
        psi, r, _, _ = y
        swing = command - start["rudder"]
        ramp = math.copysign(min(abs(swing), ship.rudder_rate_rad_s * t), swing)
        rudder = start["rudder"] + ramp
        return np.array(
            [
                r,
                (ship.gain_1_s * rudder - r) / ship.time_constant_s,
                ship.speed_m_s * math.sin(psi),
                ship.speed_m_s * math.cos(psi),
            ]
        )

    y = np.array([start["heading"], start["rate"], 0.0, 0.0])
    for i in range(steps):
        t = i * h
        k1 = slope(t, y)
        k2 = slope(t + h / 2, y + h / 2 * k1)
        k3 = slope(t + h / 2, y + h / 2 * k2)
        k4 = slope(t + h, y + h * k3)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return y


@pytest.mark.parametrize("t", [1.0, 5.0, 60.0, 300.0])
@pytest.mark.parametrize("rudder", [FIVE_DEG, -0.03])
@pytest.mark.parametrize("ship", [PAPER, dataclasses.replace(LARGE, rudder_rate_rad_s=math.inf)])
def test_answer_to_a_constant_rudder_is_nomotos_closed_form(ship, rudder, t):
    after = advance(at_rest(ship), jnp.float32(rudder), ship, t)
    k, lag = ship.gain_1_s, ship.time_constant_s
    decay = math.exp(-t / lag)
    assert float(after.rate_of_turn_rad_s) == pytest.approx(k * rudder * (1 - decay), rel=1e-4)
    heading = k * rudder * (t - lag * (1 - decay))
    # float32 cancels in t − T(1 − e^(−t/T)): one part in 1e7 of K·δ·T
    assert float(after.heading_rad) == pytest.approx(heading, rel=1e-5, abs=4e-7 * k * lag)


@pytest.mark.parametrize(
    ("rudder", "rate", "command"),
    [(0.0, 0.0, FIVE_DEG), (-FIVE_DEG, -0.002, FIVE_DEG), (0.03, 0.001, -0.01), (0.0, 0.0, 0.0)],
)
@pytest.mark.parametrize("duration", [1.0, 5.0, 10.0])
def test_moving_rudder_agrees_with_runge_kutta(rudder, rate, command, duration):
    ship = LARGE
    expected = runge_kutta(
        ship, {"heading": 0.7, "rate": rate, "rudder": rudder}, command, duration
    )
    state = dataclasses.replace(
        at_rest(ship, 0.7), rate_of_turn_rad_s=jnp.float32(rate), rudder_rad=jnp.float32(rudder)
    )
    with jax.enable_x64(True):
        after = advance(double(state), jnp.asarray(command, jnp.float64), ship, duration)
        assert after.heading_rad.dtype == jnp.float64
    assert float(after.heading_rad) == pytest.approx(expected[0], abs=2e-6)
    assert float(after.rate_of_turn_rad_s) == pytest.approx(expected[1], abs=2e-6)
    assert float(after.east_m) == pytest.approx(expected[2], abs=1e-3)
    assert float(after.north_m) == pytest.approx(expected[3], abs=1e-3)


def test_position_converges_with_order_four():
    rudder, duration = FIVE_DEG, 80.0
    k, lag, u = PAPER.gain_1_s, PAPER.time_constant_s, PAPER.speed_m_s
    t, w = np.polynomial.legendre.leggauss(200)
    t, w = (t + 1) * duration / 2, w * duration / 2
    heading = k * rudder * (t - lag * (1 - np.exp(-t / lag)))
    exact = u * (w @ np.sin(heading)), u * (w @ np.cos(heading))
    errors = []
    with jax.enable_x64(True):
        for steps in (4, 8, 16, 32):
            track = sail(double(at_rest(PAPER)), rudder, PAPER, duration / steps, steps)
            errors.append(
                math.hypot(float(track.east_m[-1]) - exact[0], float(track.north_m[-1]) - exact[1])
            )
    ratios = [a / b for a, b in itertools.pairwise(errors)]
    assert all(13 < ratio < 20 for ratio in ratios), (errors, ratios)
    assert errors[2] < 0.01  # 5 s steps: a centimetre after 80 s of hard turning


def test_step_of_two_halves_turns_the_ship_alike():
    for ship in (PAPER, LARGE):
        whole = sail(at_rest(ship), 0.05, ship, 6.0, 10)
        halves = sail(at_rest(ship), 0.05, ship, 3.0, 20)
        for name in ("heading_rad", "rate_of_turn_rad_s", "rudder_rad"):
            np.testing.assert_allclose(
                getattr(whole, name)[-1], getattr(halves, name)[-1], rtol=2e-5
            )


@pytest.mark.parametrize("ship", [PAPER, LARGE])
def test_turning_circle_has_radius_u_over_k_delta(ship):
    track = sail(at_rest(ship), FIVE_DEG, ship, 5.0, 1500)
    settled = 300  # 1500 s: ten time constants of the larger ship
    east, north = np.asarray(track.east_m)[settled:], np.asarray(track.north_m)[settled:]
    radius = ship.speed_m_s / (ship.gain_1_s * FIVE_DEG)
    period = 2 * math.pi / (ship.gain_1_s * FIVE_DEG)
    assert len(east) * 5 > 2 * period
    for axis in (east, north):
        assert (axis.max() - axis.min()) / 2 == pytest.approx(radius, rel=0.003)
    heading = np.asarray(track.heading_rad)[settled:]
    centre = east + radius * np.cos(heading), north - radius * np.sin(heading)
    assert np.ptp(centre[0]) < 0.003 * radius
    assert np.ptp(centre[1]) < 0.003 * radius


def test_starboard_rudder_turns_to_starboard():
    track = sail(at_rest(PAPER), FIVE_DEG, PAPER, 5.0, 10)
    assert float(track.heading_rad[-1]) > 0
    assert float(track.east_m[-1]) > 0


def test_straight_ship_makes_her_speed_good():
    track = sail(at_rest(LARGE, math.radians(30)), 0.0, LARGE, 5.0, 240)
    run = LARGE.speed_m_s * 1200
    assert float(track.east_m[-1]) == pytest.approx(run * 0.5, rel=1e-5)
    assert float(track.north_m[-1]) == pytest.approx(run * math.sqrt(0.75), rel=1e-5)
    assert float(track.speed_m_s[-1]) == pytest.approx(LARGE.speed_m_s)


@pytest.mark.parametrize("sign", [1, -1])
def test_rudder_obeys_its_limit_and_its_rate(sign):
    rate = math.radians(65 / 28)
    track = sail(at_rest(LARGE), sign * math.radians(35), LARGE, 0.5, 8)
    expected = np.minimum(rate * 0.5 * np.arange(1, 9), FIVE_DEG)
    np.testing.assert_allclose(sign * np.asarray(track.rudder_rad), expected, rtol=1e-5)
    at_once = advance(at_rest(PAPER), jnp.float32(sign * 0.6), PAPER, 1.0)
    assert float(at_once.rudder_rad) == pytest.approx(sign * FIVE_DEG, rel=1e-6)


@pytest.mark.parametrize("command", [0.0, 0.02])
@pytest.mark.parametrize("ship", [PAPER, LARGE])
def test_gradient_through_the_ship_is_finite_at_rest_and_right(ship, command):
    def heading(c):
        return advance(at_rest(ship), c, ship, 5.0).heading_rad

    slope = float(jax.grad(heading)(jnp.float32(command)))
    assert math.isfinite(slope)
    assert slope > 0
    with jax.enable_x64(True):
        state, h = double(at_rest(ship)), 1e-5

        def exact(c):
            after = advance(state, jnp.asarray(c, jnp.float64), ship, 5.0)
            return float(after.heading_rad)

        difference = (exact(command + h) - exact(command - h)) / (2 * h)
    assert slope == pytest.approx(difference, rel=1e-2)


def test_unknown_ship_and_impossible_ships_are_told_in_one_line():
    with pytest.raises(InputError, match=r"unknown ship 'tug'.*paper, large_ship"):
        ship_named("tug")
    assert check_ship(ship_named("paper")) is PAPER
    for field, value in [
        ("gain_1_s", 0.0),
        ("time_constant_s", -1.0),
        ("loa_m", math.nan),
        ("speed_m_s", math.inf),
    ]:
        with pytest.raises(InputError, match=field):
            check_ship(dataclasses.replace(PAPER, **{field: value}))
