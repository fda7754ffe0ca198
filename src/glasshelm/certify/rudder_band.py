"""The certified rudder band: what the rudder can be while the sensors err within known bounds.

The box of errors is covered by cells; each cell's linear bounds hold in it, and the band is
the union of theirs. The cells that reach furthest are halved, again and again, across the
error to which their bound is most sensitive (best-first branch and bound).
"""

import dataclasses
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from glasshelm.certify.crown import LinearBound, rudder_bounds
from glasshelm.certify.input_bounds import AffineForm, target_inputs, waypoint_inputs
from glasshelm.certify.measurements import N_OWN_ERRORS, N_TARGET_ERRORS, RawPlots, SensorErrors
from glasshelm.core.errors import InputError
from glasshelm.networks.actors import SumActor
from glasshelm.networks.mlp import softsign
from glasshelm.pilots.guarded import GuardedPilot
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.pilots.protocols import Pilot

#: Rudders within so much of midships are no turn [rad].
DEAD_ZONE_RAD = 0.25 * np.pi / 180.0
#: What float32 may lose in the actor itself, as a fraction of the rudder limit.
ROUNDING = 2e-5
#: So many cells of many scenes go through the network at a time, and of one scene alone.
CHUNK, SINGLE_SCENE_CHUNK = 16, 4
#: Stands in for the target of an empty slot; its bounds are not used.
_HARMLESS = np.array([3000.0, 4000.0, 0.0, 5.0, 3.0, 5.0])


@dataclasses.dataclass(frozen=True)
class RudderBand:
    """The rudder lies between ``low_rad`` and ``high_rad``, starboard positive.

    ``certain_side`` is +1 if it is certainly to starboard of the dead zone, −1 if
    certainly to port, 0 if neither is certain.
    """

    low_rad: float
    high_rad: float

    @property
    def certain_side(self) -> int:
        return int(self.low_rad > DEAD_ZONE_RAD) - int(self.high_rad < -DEAD_ZONE_RAD)


@dataclasses.dataclass(frozen=True, eq=False)
class _Cell:
    """A box of a scene's errors in units of their largest, and the actor's bounds there.

    ``axes`` are those across which to halve it for a better lower and upper bound.
    """

    scene: int
    centre: Float[np.ndarray, " k"]
    radius: Float[np.ndarray, " k"]
    low: float = -1.0
    high: float = 1.0
    axes: tuple[int, int] = (0, 0)

    def halves(self, axis: int) -> list["_Cell"]:
        """What holds in the whole holds in both."""
        half = np.where(np.arange(self.radius.size) == axis, 0.5 * self.radius, 0.0)
        centres = self.centre - half, self.centre + half
        return [dataclasses.replace(self, centre=c, radius=self.radius - half) for c in centres]


def certified_band(
    pilot: LearnedPilot, scene: RawPlots, errors: SensorErrors, cells: int = 1
) -> RudderBand:
    """Bounds on the rudder of a sum pilot for every scene within ``errors`` of this one.

    ``cells`` bounds are asked for at most; more make the band narrower. InputError if the
    pilot's actor is not a sum.
    """
    low, high = action_bounds(
        require_sum_actor(pilot), jax.tree.map(lambda x: x[None], scene), errors, cells
    )
    limit = float(pilot.trained.ship.rudder_limit_rad)
    return RudderBand(float(low[0]) * limit, float(high[0]) * limit)


def require_sum_actor(pilot: Pilot) -> SumActor:
    """The pilot's actor. InputError if it has none or it is not a sum."""
    if isinstance(pilot, GuardedPilot):
        raise InputError(f"{pilot.name} is guarded; only {pilot.pilot.name} alone can be certified")
    if not isinstance(pilot, LearnedPilot):
        raise InputError(f"{pilot.name} has no network; only a sum actor can be certified")
    if not isinstance(pilot.actor, SumActor):
        raise InputError(f"{pilot.name} has an attention actor; only a sum can be certified")
    return pilot.actor


def action_bounds(
    actor: SumActor, scenes: RawPlots, errors: SensorErrors, cells: int = 1
) -> tuple[Float[np.ndarray, " s"], Float[np.ndarray, " s"]]:
    """The least and the greatest rudder of each of many scenes, as fractions of the limit."""
    count, slots = scenes.present.shape
    bounded = partial(_bounded, actor, _Plots(scenes), _largest(errors, slots))
    size = N_OWN_ERRORS + N_TARGET_ERRORS * slots
    cover = [[cell] for cell in bounded([_whole(i, size) for i in range(count)])]
    # Two cells are halved at most at a time: the lowest and the highest.
    for _ in range((cells - 1) // 4):
        halved: list[_Cell] = []
        for mine in cover:
            lowest, highest = (
                min(mine, key=lambda cell: cell.low), max(mine, key=lambda cell: cell.high)
            )  # fmt: skip
            mine.remove(lowest)
            halved += lowest.halves(lowest.axes[0])
            if highest is not lowest:
                mine.remove(highest)
                halved += highest.halves(highest.axes[1])
        for cell in bounded(halved):
            cover[cell.scene].append(cell)
    low = np.array([min(cell.low for cell in mine) for mine in cover])
    return low, np.array([max(cell.high for cell in mine) for mine in cover])


def _whole(scene: int, size: int) -> _Cell:
    return _Cell(scene, np.zeros(size), np.ones(size))


class _Plots:
    """Scenes in double precision."""

    def __init__(self, scenes: RawPlots):
        self.waypoint = np.asarray(scenes.waypoint, np.float64)
        self.present = np.asarray(scenes.present)
        observation = self.present[..., None, None]
        self.targets = np.where(observation, np.asarray(scenes.targets, np.float64), _HARMLESS)


def _largest(errors: SensorErrors, slots: int) -> Float[np.ndarray, " k"]:
    """The unit of every symbol [m, rad, m/s]."""
    own, target = np.asarray(errors.own(), np.float64), np.asarray(errors.target(), np.float64)
    return np.concatenate([own, np.tile(target, slots)])


def _bounded(
    actor: SumActor, scenes: _Plots, unit: Float[np.ndarray, " k"], cells: list[_Cell]
) -> list[_Cell]:
    """Cells with their bounds."""
    chunk = CHUNK if len(scenes.present) > 1 else SINGLE_SCENE_CHUNK
    result = []
    for start in range(0, len(cells), chunk):
        some = cells[start : start + chunk]
        filled = some + [some[-1]] * (chunk - len(some))
        which = np.array([cell.scene for cell in filled])
        centres = np.stack([cell.centre for cell in filled]) * unit
        # Cells overlap by what rounding may open between them.
        radii = np.stack([cell.radius for cell in filled]) * unit * (1 + 1e-5)
        waypoint, targets = _forms(actor, scenes, which, centres, radii)
        bounds = _through_network(actor, waypoint, targets, jnp.asarray(scenes.present[which]))
        for cell, low, high, *axes in zip(some, *map(np.asarray, bounds), strict=False):
            result.append(
                dataclasses.replace(
                    cell,
                    low=max(cell.low, float(low)),
                    high=min(cell.high, float(high)),
                    axes=(int(axes[0]), int(axes[1])),
                )
            )
    return result


def _forms(
    actor: SumActor, scenes: _Plots, which: np.ndarray, centres: np.ndarray, radii: np.ndarray
) -> tuple[AffineForm, AffineForm]:
    """The networks' inputs [cell, d] and [cell, slot, d], of present targets only."""
    count, slots = scenes.present[which].shape
    own, target = (
        centres[:, :N_OWN_ERRORS],
        centres[:, N_OWN_ERRORS:].reshape(count, slots, N_TARGET_ERRORS),
    )
    still = np.zeros_like(own[:, :2])
    # An own ship shown too far east sees everything too far west.
    mine = np.concatenate([-own[:, :2], own[:, 2:], still], -1)[:, None]
    theirs = np.concatenate([target[..., :2], 0 * target[..., :2], target[..., 2:]], -1)
    ahead = waypoint_inputs(actor.lens, scenes.waypoint[which] + mine, radii[:, :N_OWN_ERRORS])
    cell, slot = np.nonzero(scenes.present[which])
    if not cell.size:  # without targets one is computed all the same; its row is not used
        cell = slot = np.zeros(1, int)
    plots = scenes.targets[which[cell], slot] + mine[cell] + theirs[cell, slot][:, None]
    spread = radii[:, N_OWN_ERRORS:].reshape(count, slots, N_TARGET_ERRORS)
    rows = target_inputs(actor.lens, plots, radii[cell, :N_OWN_ERRORS], spread[cell, slot])
    around = [np.zeros((count, slots, *x.shape[1:])) for x in rows]
    for whole, part in zip(around, rows, strict=True):
        whole[cell, slot] = part
    return _single(ahead), _single(AffineForm(*around))


def _single(form: AffineForm) -> AffineForm:
    """In float32; the slack takes what that loses."""
    lost = 2e-7 * (np.abs(form.centre) + form.radius)
    parts = form.centre, form.slope, form.slack + lost
    return AffineForm(*(jnp.asarray(x, jnp.float32) for x in parts))


@eqx.filter_jit
@partial(jax.vmap, in_axes=(None, 0, 0, 0))
def _through_network(
    actor: SumActor, waypoint: AffineForm, targets: AffineForm, present: Bool[Array, " n"]
) -> tuple[Array, Array, Array, Array]:
    """The least and greatest action of a cell, and the axis that matters most to each."""
    bounds = rudder_bounds(actor, waypoint, targets, present)
    low, negated = (softsign(bound.minimum[0]) for bound in bounds)
    low = jnp.clip(jnp.where(jnp.isnan(low), -1.0, low) - ROUNDING, -1.0, 1.0)
    high = jnp.clip(ROUNDING - jnp.where(jnp.isnan(negated), -1.0, negated), -1.0, 1.0)
    return low, high, _axis(bounds[0]), _axis(bounds[1])


def _axis(bound: LinearBound) -> Array:
    slopes = jnp.concatenate([bound.own[0], bound.target[0].reshape(-1)])
    return jnp.argmax(jnp.nan_to_num(jnp.abs(slopes)))
