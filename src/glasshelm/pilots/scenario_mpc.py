"""Scenario-based MPC as Johansen, Perez & Cristofaro printed it (IEEE T-ITS 2016).

Own ship is sailed ahead with each of thirteen course offsets kept over the
whole horizon, targets straight on; the offset of least cost is taken. The cost
of an offset χ is

    max over ships and times of [C·R + κ·μ]  +  k_χ·χ² + Δ_χ(χ − χ_last),

with the collision risk R = (d_safe/d)^q / t^p for d ≤ d_safe, its cost
C = K·|v_o − v_i|², the COLREGs violation μ for d ≤ d_close, and altering to
port dearer than to starboard. The speed factors of the paper are left out:
speed is fixed here.
"""

import dataclasses
import math

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from glasshelm.core.geometry import Vector, direction, norm, velocity, wrap_angle
from glasshelm.env.observe import Observation
from glasshelm.pilots.course_pilot import CourseMethod
from glasshelm.planning.manoeuvres import PredictedOwn, predict_step
from glasshelm.planning.situation import Situation, situation_of
from glasshelm.ship.autopilot import autopilot_for
from glasshelm.ship.nomoto import ShipParams


@dataclasses.dataclass(frozen=True)
class ScenarioSettings:
    """The paper's symbols. Tuned: docs/explanation/classical-pilots.md."""

    offsets_deg: tuple[float, ...] = (
        -90.0, -75.0, -60.0, -45.0, -30.0, -15.0, 0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0,
    )  # fmt: skip
    horizon_s: float = 1800.0
    step_s: float = 15.0
    safe_m: float = 2125.0
    close_m: float = 2900.0
    time_exponent: float = 0.65
    range_exponent: float = 4.0
    collision_gain: float = 500.0
    rules_cost: float = 3.4
    offset_gain: float = 0.57
    to_starboard_gain: float = 1.56
    to_port_gain: float = 2.41
    #: Ahead of, abaft, head-on and crossing sectors.
    ahead_deg: float = 68.5
    overtaken_deg: float = 68.5
    head_on_deg: float = 22.5
    crossing_deg: float = 68.5


def scenario_costs(
    at: Situation, last_rad: Float[Array, ""], ship: ShipParams, settings: ScenarioSettings
) -> tuple[Float[Array, " c"], Float[Array, " c"]]:
    """The offsets [rad] and what each costs."""
    offsets = jnp.radians(jnp.asarray(settings.offsets_deg))
    autopilot, tau = autopilot_for(ship), settings.step_s
    zero = jnp.zeros_like(offsets)
    start = PredictedOwn.here(at.rate_of_turn_rad_s, offsets.size)

    def go(
        carry: tuple[PredictedOwn, Array], time: Float[Array, ""]
    ) -> tuple[tuple[PredictedOwn, Array], None]:
        ahead, worst = carry
        moved = predict_step(ahead, at.bearing_rad + offsets, autopilot, ship, tau)
        for i in range(at.position.x.shape[0]):
            there = Vector(
                at.position.x[i] + at.velocity.x[i] * time - moved.x,
                at.position.y[i] + at.velocity.y[i] * time - moved.y,
            )
            hers = Vector(at.velocity.x[i], at.velocity.y[i])
            worst = jnp.maximum(worst, hazard(there, hers, moved.heading, time, ship, settings))
        return (moved, worst), None

    times = jnp.arange(1, round(settings.horizon_s / tau) + 1, dtype=jnp.float32) * tau
    (_, worst), _ = jax.lax.scan(go, (start, zero), times)
    change = wrap_angle(offsets - last_rad)
    gain = jnp.where(change > 0, settings.to_starboard_gain, settings.to_port_gain)
    return offsets, worst + settings.offset_gain * offsets**2 + gain * change**2


def hazard(
    offset: Vector,
    hers: Vector,
    heading_rad: Float[Array, " c"],
    time_s: Float[Array, ""],
    ship: ShipParams,
    settings: ScenarioSettings,
) -> Float[Array, " c"]:
    """C·R + κ·μ of one ship at one time, for every imagined own ship."""
    distance = jnp.maximum(norm(offset), 1.0)
    own = velocity(heading_rad, ship.speed_m_s)
    closing = (own.x - hers.x) ** 2 + (own.y - hers.y) ** 2
    risk = (settings.safe_m / distance) ** settings.range_exponent
    risk = risk / time_s**settings.time_exponent
    risk = jnp.where(distance < settings.safe_m, settings.collision_gain * closing * risk, 0.0)
    against = violation(offset, hers, heading_rad, ship, settings)
    return risk + settings.rules_cost * (against & (distance < settings.close_m))


def violation(
    offset: Vector,
    hers: Vector,
    heading_rad: Float[Array, " c"],
    ship: ShipParams,
    settings: ScenarioSettings,
) -> Bool[Array, " c"]:
    """μ: a ship to starboard met head-on, or crossing from there and not overtaking own ship."""
    own = velocity(heading_rad, ship.speed_m_s)
    dot = own.x * hers.x + own.y * hers.y
    fast = norm(hers)
    both = ship.speed_m_s * fast
    bearing = wrap_angle(direction(offset) - heading_rad)
    starboard = bearing >= 0
    ahead = jnp.abs(bearing) < math.radians(settings.ahead_deg)
    overtaken = (dot > math.cos(math.radians(settings.overtaken_deg)) * both) & (
        fast > ship.speed_m_s
    )
    head_on = (dot < -math.cos(math.radians(settings.head_on_deg)) * both) & ahead & (fast > 0.05)
    from_port = wrap_angle(direction(hers) - heading_rad) < 0
    crossing = (dot < math.cos(math.radians(settings.crossing_deg)) * both) & from_port
    return starboard & (head_on | (crossing & ~overtaken))


def scenario_course(
    observation: Observation,
    offset_rad: Float[Array, ""],
    ship: ShipParams,
    settings: ScenarioSettings,
) -> Float[Array, ""]:
    """The offset of least cost."""
    offsets, costs = scenario_costs(situation_of(observation, ship), offset_rad, ship, settings)
    return offsets[jnp.argmin(costs)]


SCENARIOS = CourseMethod(scenario_course, ScenarioSettings())
