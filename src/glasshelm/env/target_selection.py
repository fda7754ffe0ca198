"""Which targets the pilot is shown when there are more than it was trained for.

The rule: ships within 20 km only; ships inside own ship's domain first; then
by how deep each would come into the domain within half an hour if both kept
straight on (the smallest distance, measured in half axes of the domain).
"""

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from glasshelm.core.errors import InputError
from glasshelm.core.geometry import Vector
from glasshelm.env.observe import LENGTH_M, SPEED_M_S, TARGET_FEATURES, Observation
from glasshelm.ship.domain import danger_unclipped, domain_axes
from glasshelm.ship.nomoto import SHIPS

#: Targets shown at most.
MAX_TARGETS = 20
#: Targets farther off are not shown [m].
RANGE_M = 20_000.0
#: How far ahead urgency is judged [s].
AHEAD_S = 1800.0

_DX, _DY, _VX, _VY = (TARGET_FEATURES.index(name) for name in ("dx", "dy", "vx", "vy"))


def select_targets(
    observation: Observation,
    capacity: int = MAX_TARGETS,
    loa_m: float | Float[Array, ""] = float(SHIPS["paper"].loa_m),
) -> tuple[Observation, Int[Array, " k"]]:
    """The observation of the most urgent targets, in at most ``capacity`` slots.

    With no more slots than ``capacity``, everything is shown as it is, whatever its range.

    Args:
        observation: Of any number of targets.
        capacity: Slots at most.
        loa_m: Own ship's length [m]: it decides who is inside the domain now; the order of the
            others does not depend on it.

    Returns:
        The observation, and for each of its slots the slot of the whole observation that it
        shows, in rising order; without meaning where the slot is empty.
    """
    if capacity < 1:
        raise InputError(f"room for {capacity} targets: must be 1 or more")
    slots = observation.present.shape[-1]
    if slots <= capacity:
        return observation, jnp.arange(slots)
    position, motion = _relative(observation.targets[:, 0])
    depth = smallest_distance(position, motion)
    danger = danger_unclipped(position, loa_m)
    near = observation.present & (jnp.hypot(*position) <= RANGE_M)
    # Ships inside count from −1 (own ship's place) to 0, all others from 0 up.
    urgency = jnp.where(danger > 0, -danger, depth)
    order = jnp.argsort(jnp.where(near, urgency, jnp.inf))
    indices = jnp.sort(order[:capacity])
    present = near[indices]
    targets = jnp.where(present[:, None, None], observation.targets[indices], 0.0)
    return Observation(observation.waypoint, targets, present), indices


def smallest_distance(
    position: Vector, motion: Vector, ahead_s: float = AHEAD_S
) -> Float[Array, "*n"]:
    """The smallest distance [half axes of the domain x m of ship length] from now to ``ahead_s``.

    ``position`` [m] and ``motion`` [m/s] are relative to own ship in her body
    frame, both constant in course and speed. The distance of Eq. 13, squared, is a
    parabola in each quadrant and convex in time: its least value lies at an
    end, where an axis is crossed, or at the lowest point of one of the four
    parabolas. All of these are tried, so the result is exact.
    """
    px, py, vx, vy = *position, *motion
    times = [jnp.zeros_like(px), jnp.full_like(px, ahead_s), _ratio(-px, vx), _ratio(-py, vy)]
    for side in (1.0, -1.0):
        for end in (1.0, -1.0):
            # One point of each quadrant tells its half axes, for a ship of 1 m.
            quadrant = Vector(jnp.asarray(side), jnp.asarray(end))
            ax, ay = domain_axes(quadrant, 1.0)
            dot = px * vx / ax**2 + py * vy / ay**2
            times.append(_ratio(-dot, vx**2 / ax**2 + vy**2 / ay**2))
    at = jnp.clip(jnp.stack(times), 0.0, ahead_s)
    return jnp.min(1.0 - danger_unclipped(Vector(px + vx * at, py + vy * at), 1.0), axis=0)


def _relative(rows: Float[Array, "n 10"]) -> tuple[Vector, Vector]:
    """Positions [m] and velocities [m/s] of the newest frame, in the body frame."""
    return (
        Vector(rows[:, _DX] * LENGTH_M, rows[:, _DY] * LENGTH_M),
        Vector(rows[:, _VX] * SPEED_M_S, rows[:, _VY] * SPEED_M_S),
    )


def _ratio(above: Float[Array, "*n"], below: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """A quotient; 0 where the divisor is 0."""
    some = below != 0
    return jnp.where(some, above / jnp.where(some, below, 1.0), 0.0)
