"""One decision from all that is seen: targets are chosen here, for every pilot."""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from glasshelm.env.observe import Observation
from glasshelm.env.padding import bucket_size, pad_observation
from glasshelm.env.target_selection import select_targets
from glasshelm.env.training_envelope import check_observation
from glasshelm.pilots.protocols import Decision, Memory, Pilot, check_pilot, for_ship
from glasshelm.ship.nomoto import SHIPS, ShipParams


class Selection(eqx.Module):
    """What the pilot is shown: slot k of ``observation`` is slot ``slots[k]`` of all."""

    observation: Observation
    slots: Int[Array, " k"]


def select(observation: Observation, loa_m: float | Float[Array, ""]) -> Selection:
    """The targets that matter most to a ship of that length [m]. Traceable."""
    return Selection(*select_targets(observation, loa_m=jnp.asarray(loa_m)))


def decide_on(
    pilot: Pilot, observation: Observation, memory: Memory, ship: ShipParams
) -> tuple[Decision, Memory, Selection]:
    """Choose the targets that matter most, and let the pilot decide on them. Traceable.

    Args:
        pilot: Who decides.
        observation: Of any number of targets.
        memory: Of the decision before, or ``pilot.start()``.
        ship: Own ship. Its length says who is inside its domain, and a pilot for any ship
            (:class:`~glasshelm.pilots.protocols.AnyShipPilot`) steers it.
    """
    selection = select(observation, ship.loa_m)
    decision, memory = for_ship(pilot, ship).decide(selection.observation, memory)
    return decision, memory, selection


def explain(
    pilot: Pilot,
    observation: Observation,
    memory: Memory | None = None,
    ship: ShipParams | None = None,
) -> Decision:
    """A pilot's decision on one observation, with its reasons (Eq. 19, 22-24, Shapley values).

    Any number of targets: the 20 that matter most are chosen, as in every frame. Programs are
    compiled for 0, 1, 2, 4, 8, … slots.

    Args:
        pilot: Who decides.
        observation: Eq. 10-12, as ``EnvState.observation`` holds it.
        memory: Of the decision before; by default that before the first.
        ship: Own ship; by default the pilot's own, or the paper's.

    Returns:
        The decision in NumPy arrays, its values in the slots of ``observation``. Where a guard
        steers, the explanation is the guard's.

    Raises:
        InputError: It is no pilot, or a feature of the waypoint or a target is no possible number.
    """
    check_pilot(pilot)
    check_observation(observation)
    count = observation.present.shape[-1]
    own_ship: ShipParams = ship or getattr(pilot, "ship", None) or SHIPS["paper"]
    decision, selection = jax.device_get(
        _decide(
            pilot,
            pad_observation(observation, bucket_size(count)),
            pilot.start() if memory is None else memory,
            jax.tree.map(lambda x: jnp.asarray(x, jnp.float32), own_ship),
        )
    )
    if decision.why is not None:
        placed = _in_slots(decision.why, selection, count)
        decision = eqx.tree_at(lambda d: d.explanation, decision, placed)
    if decision.guard is not None and count:
        guards = _in_slots(decision.guard.explanation, selection, count)
        slot = selection.slots[decision.guard.lookahead.slot]
        places = (lambda d: d.guard.explanation, lambda d: d.guard.lookahead.slot)
        for place, value in zip(places, (guards, slot), strict=True):
            decision = eqx.tree_at(place, decision, value)
    return decision


@eqx.filter_jit
def _decide(
    pilot: Pilot, observation: Observation, memory: Memory, ship: ShipParams
) -> tuple[Decision, Selection]:
    decision, _, selection = decide_on(pilot, observation, memory, ship)
    return decision, selection


def _in_slots(explanation: Any, selection: Selection, count: int) -> Any:
    """Every axis of the selection's slots as one of all ``count`` slots; 0 where nobody is."""
    shown = np.flatnonzero(selection.observation.present)
    slots = selection.slots[shown]

    def spread(values: np.ndarray) -> np.ndarray:
        # No other axis is as long: slots are a power of two or MAX_TARGETS, the sweep is odd.
        for axis in range(values.ndim):
            if values.shape[axis] == len(selection.slots):
                wide = np.zeros_like(values, shape=(count, *np.delete(values.shape, axis)))
                wide[slots] = np.moveaxis(values, axis, 0)[shown]
                values = np.moveaxis(wide, 0, axis)
        return values

    return jax.tree.map(lambda x: spread(np.asarray(x)), explanation)
