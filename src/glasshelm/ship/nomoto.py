"""Own ship: Nomoto's first-order model (Eq. 6-7), advanced exactly over a step."""

import dataclasses
import math

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.core.errors import InputError
from glasshelm.core.fast_trig import sincos
from glasshelm.core.geometry import Vector

KNOT_M_S = 1852.0 / 3600.0
NAUTICAL_MILE_M = 1852.0

Scalar = Float[Array, "..."]


class ShipParams(eqx.Module):
    """What makes one ship differ from another.

    ``gain_1_s`` and ``time_constant_s`` are K and T of Eq. 6; the rudder obeys
    a limit and a rate (``inf``: at once); ``loa_m`` scales the ship domain
    (Eq. 14-15); ``speed_m_s`` is constant, as in the paper.
    """

    gain_1_s: float | Scalar
    time_constant_s: float | Scalar
    rudder_limit_rad: float | Scalar
    rudder_rate_rad_s: float | Scalar
    loa_m: float | Scalar
    beam_m: float | Scalar
    speed_m_s: float | Scalar


class ShipState(eqx.Module):
    """Where a ship is and how she moves: position, heading, rate of turn, rudder, speed."""

    east_m: Scalar
    north_m: Scalar
    heading_rad: Scalar
    rate_of_turn_rad_s: Scalar
    rudder_rad: Scalar
    speed_m_s: Scalar

    @staticmethod
    def steady(
        east_m: float | Scalar,
        north_m: float | Scalar,
        heading_rad: float | Scalar,
        speed_m_s: float | Scalar,
    ) -> "ShipState":
        """A ship on a steady heading: no rate of turn, rudder amidships."""
        e, n, h, v = (
            jnp.asarray(x, jnp.float32) for x in (east_m, north_m, heading_rad, speed_m_s)
        )
        return ShipState(e, n, h, jnp.zeros_like(h), jnp.zeros_like(h), v)


class _Yaw(eqx.Module):
    heading_rad: Scalar
    rate_of_turn_rad_s: Scalar
    rudder_rad: Scalar


def _turn(yaw: _Yaw, ship: ShipParams, rudder_slope: Scalar, duration_s: Scalar) -> _Yaw:
    """Exact solution of T·ṙ + r = K·(δ₀ + ρt), ψ̇ = r for a rudder moving at a constant slope ρ."""
    gain, lag = ship.gain_1_s, ship.time_constant_s
    steady = gain * (yaw.rudder_rad - rudder_slope * lag)  # r would settle on steady + K·ρ·t
    transient = yaw.rate_of_turn_rad_s - steady
    decay = jnp.exp(-duration_s / lag)
    ramp = gain * rudder_slope * duration_s
    return _Yaw(
        yaw.heading_rad + (steady + 0.5 * ramp) * duration_s + transient * lag * (1.0 - decay),
        steady + ramp + transient * decay,
        yaw.rudder_rad + rudder_slope * duration_s,
    )


def advance(
    state: ShipState, rudder_command_rad: Scalar, ship: ShipParams, duration_s: float | Scalar
) -> ShipState:
    """The ship after ``duration_s`` with a constant rudder command (Eq. 6-7).

    The rudder runs to the command (clipped to the limit) at its rate and stays;
    heading and rate of turn follow exactly; the position integrates Eq. 7 with
    Simpson's rule on the exact heading (global error of order 4 in the step).
    """
    command = jnp.clip(rudder_command_rad, -ship.rudder_limit_rad, ship.rudder_limit_rad)
    swing = command - state.rudder_rad
    swing_s = jnp.abs(swing) / ship.rudder_rate_rad_s
    moving = swing_s > 0
    # The slope is the rate and its side, not swing / swing_s: that is the same number, but its
    # gradient divides two vanishing ones when the rudder is all but there.
    rate = jnp.where(jnp.isfinite(ship.rudder_rate_rad_s), ship.rudder_rate_rad_s, 0.0)
    slope = jnp.where(moving, jnp.sign(swing) * rate, 0.0)
    start = _Yaw(
        state.heading_rad,
        state.rate_of_turn_rad_s,
        jnp.where(moving, state.rudder_rad, command),
    )

    def yaw_at(t: float | Scalar) -> _Yaw:
        ramp_s = jnp.minimum(swing_s, t)
        ramped = _turn(start, ship, slope, ramp_s)
        return _turn(ramped, ship, jnp.zeros_like(slope), t - ramp_s)

    middle, end = yaw_at(0.5 * duration_s), yaw_at(duration_s)
    sines, cosines = zip(*(sincos(yaw.heading_rad) for yaw in (start, middle, end)), strict=True)
    sine, cosine = ((v[0] + 4 * v[1] + v[2]) / 6 for v in (sines, cosines))
    run = state.speed_m_s * duration_s
    return ShipState(
        state.east_m + run * sine,
        state.north_m + run * cosine,
        end.heading_rad,
        end.rate_of_turn_rad_s,
        end.rudder_rad,
        state.speed_m_s,
    )


def with_drift(state: ShipState, current_m_s: Vector, duration_s: float) -> ShipState:
    """The ship carried along by a current (east, north) [m/s] while she sailed."""
    return eqx.tree_at(
        lambda s: (s.east_m, s.north_m),
        state,
        (state.east_m + current_m_s.x * duration_s, state.north_m + current_m_s.y * duration_s),
    )


SHIPS: dict[str, ShipParams] = {
    # The published behaviour was obtained with these K and T (docs/explanation/paper.md);
    # no 340 m ship turns 0.9°/s at 5° of rudder.
    "paper": ShipParams(
        gain_1_s=0.1827,
        time_constant_s=11.10,
        rudder_limit_rad=math.radians(5),
        rudder_rate_rad_s=math.inf,
        loa_m=340.0,
        beam_m=60.0,
        speed_m_s=10 * KNOT_M_S,
    ),
    # Fitted to zig-zags of a full-size KVLCC2 model, scaled to 340 m at 10 kn;
    # SOLAS II-1/29: the rudder runs 65° in 28 s.
    "large_ship": ShipParams(
        gain_1_s=0.035,
        time_constant_s=141.0,
        rudder_limit_rad=math.radians(5),
        rudder_rate_rad_s=math.radians(65 / 28),
        loa_m=340.0,
        beam_m=60.0,
        speed_m_s=10 * KNOT_M_S,
    ),
}


def ship_named(name: str) -> ShipParams:
    """The preset ship of that name (``large_ship`` or ``large-ship``).

    InputError names the presets if there is none.
    """
    name = name.replace("-", "_")
    if name not in SHIPS:
        raise InputError(f"unknown ship {name!r}: choose one of {', '.join(SHIPS)}")
    return SHIPS[name]


def check_ship(ship: ShipParams) -> ShipParams:
    """The same ship, or InputError naming the first parameter that no ship can have."""
    for field in dataclasses.fields(ship):
        value = float(getattr(ship, field.name))
        unlimited = field.name == "rudder_rate_rad_s" and value == math.inf
        if not (value > 0 and (math.isfinite(value) or unlimited)):
            raise InputError(f"ship {field.name} = {value}: must be a positive number")
    return ship
