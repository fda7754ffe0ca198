"""The certified rudder band: what the rudder can be while the sensors err within known bounds.

The box of errors is covered by cells; each cell's linear bounds hold in it, and the band is
the union of theirs. The cell that reaches furthest is halved, again and again, across the
error to which its bound is most sensitive.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.certify.features import target_inputs, waypoint_inputs
from glasshelm.certify.linear import Bound, rudder_bounds
from glasshelm.certify.scene import EACH, OWN, Scene, SensorErrors, shifted
from glasshelm.errors import InputError
from glasshelm.networks.actors import SumActor
from glasshelm.networks.mlp import softsign
from glasshelm.pilots.learned import LearnedPilot

#: Rudders within so much of midships are no turn [rad].
DEAD_ZONE_RAD = 0.25 * jnp.pi / 180.0
#: What float32 may lose in the actor itself, as a fraction of the rudder limit.
ROUNDING = 2e-5


class Band(eqx.Module):
    """The rudder lies between ``low_rad`` and ``high_rad``, starboard positive.

    ``turn`` is +1 if it is certainly to starboard of the dead zone, −1 if
    certainly to port, 0 if neither is certain.
    """

    low_rad: Float[Array, ""]
    high_rad: Float[Array, ""]
    turn: Float[Array, ""]


class _Cell(eqx.Module):
    """A box of errors in units of their largest, bounds of the actor there, where to halve it."""

    centre: Float[Array, " k"]
    radius: Float[Array, " k"]
    low: Float[Array, ""]
    high: Float[Array, ""]
    axis_low: Float[Array, " k"]
    axis_high: Float[Array, " k"]


def certified_band(
    pilot: LearnedPilot, scene: Scene, errors: SensorErrors, halvings: int = 0
) -> Band:
    """Bounds on the rudder of a sum pilot for every scene within ``errors`` of this one.

    Pure and traceable, for one scene. ``halvings`` more pairs of cells make the band narrower
    and cost as much again each. InputError if the pilot's actor is not a sum.
    """
    actor = pilot.actor
    if not isinstance(actor, SumActor):
        raise InputError(f"pilot {pilot.name}: only the rudder of a sum actor can be certified")
    low, high = action_bounds(actor, scene, errors, halvings)
    limit = pilot.trained.ship.rudder_limit_rad
    turn = jnp.where(low * limit > DEAD_ZONE_RAD, 1.0, 0.0)
    turn = jnp.where(high * limit < -DEAD_ZONE_RAD, -1.0, turn)
    return Band(low * limit, high * limit, turn)


def action_bounds(
    actor: SumActor, scene: Scene, errors: SensorErrors, halvings: int = 0
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """The same as fractions of the rudder limit."""
    size = OWN + EACH * scene.present.shape[0]
    whole = _bounded(actor, scene, errors, jnp.zeros(size), jnp.ones(size))
    if halvings == 0:
        return whole.low, whole.high
    nothing = jax.tree.map(lambda x: jnp.zeros((halvings, *x.shape), x.dtype), whole)
    nothing = eqx.tree_at(
        lambda c: (c.low, c.high), nothing,
        (jnp.full(halvings, jnp.inf), jnp.full(halvings, -jnp.inf)),
    )  # fmt: skip
    cells = jax.tree.map(lambda x, y: jnp.concatenate([x[None], y]), whole, nothing)

    def halve(cells: _Cell, number: Array) -> tuple[_Cell, None]:
        lower = number % 2 == 0
        worst = jnp.where(lower, jnp.argmin(cells.low), jnp.argmax(cells.high))
        cell = jax.tree.map(lambda x: x[worst], cells)
        weight = jnp.where(lower, cell.axis_low, cell.axis_high)
        axis = jnp.arange(size) == jnp.argmax(weight)
        radius = jnp.where(axis, 0.5 * cell.radius, cell.radius)
        centres = cell.centre + jnp.array([-1.0, 1.0])[:, None] * jnp.where(axis, radius, 0.0)
        halves = jax.vmap(lambda c: _bounded(actor, scene, errors, c, radius))(centres)
        # What holds in the whole cell holds in its halves.
        halves = eqx.tree_at(
            lambda h: (h.low, h.high), halves,
            (jnp.maximum(halves.low, cell.low), jnp.minimum(halves.high, cell.high)),
        )  # fmt: skip
        place = jnp.array([worst, number + 1])
        return jax.tree.map(lambda x, y: x.at[place].set(y), cells, halves), None

    cells, _ = jax.lax.scan(halve, cells, jnp.arange(halvings))
    return cells.low.min(), cells.high.max()


def _bounded(
    actor: SumActor,
    scene: Scene,
    errors: SensorErrors,
    centre: Float[Array, " k"],
    radius: Float[Array, " k"],
) -> _Cell:
    """The bounds of one cell."""
    here = shifted(scene, *in_units(errors, centre))
    # Cells overlap by what rounding may open between them.
    own, each = in_units(errors, radius * (1 + 1e-5))
    lens = actor.lens
    bounds = rudder_bounds(
        actor, waypoint_inputs(lens, here, own), target_inputs(lens, here, own, each), here.present
    )
    low, negated = (softsign(b.least[0]) for b in bounds)
    sides = [_sensitivity(b) for b in bounds]
    low = jnp.where(jnp.isnan(low), -1.0, low)
    negated = jnp.where(jnp.isnan(negated), -1.0, negated)
    low = jnp.clip(low - ROUNDING, -1.0, 1.0)
    high = jnp.clip(ROUNDING - negated, -1.0, 1.0)
    return _Cell(centre, radius, low, high, *sides)


def _sensitivity(bound: Bound) -> Float[Array, " k"]:
    return jnp.nan_to_num(jnp.abs(jnp.concatenate([bound.own[0], bound.each[0].reshape(-1)])))


def in_units(
    errors: SensorErrors, fractions: Float[Array, " k"]
) -> tuple[Float[Array, "4"], Float[Array, "n 4"]]:
    """Errors [m, rad, m/s] of own ship and of each target from fractions of their largest."""
    own, each = fractions[:OWN], fractions[OWN:].reshape(-1, EACH)
    return own * errors.own(), each * errors.each()
