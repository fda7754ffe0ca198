"""Small suites for tests: few worlds, few steps, made by hand."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from glasshelm.core.geometry import Vector
from glasshelm.encounters.types import Encounter, straight_track
from glasshelm.evaluation.suites.random_suite import undisturbed_cases
from glasshelm.evaluation.types import Suite
from glasshelm.ship.nomoto import ShipState, ship_named
from glasshelm.simulation.rollout import Case

SHIP = ship_named("paper")
SPEED = float(SHIP.speed_m_s)


def encounter(*targets: tuple[float, float, float, float], slots: int = 2) -> Encounter:
    """Own ship on north from the origin; targets as (east, north [m], course [°], speed [m/s])."""
    rows = np.zeros((slots, 4), np.float32)
    rows[: len(targets)] = np.reshape(targets, (-1, 4))
    east, north, course, speed = map(jnp.asarray, rows.T)
    return Encounter(
        ShipState.steady(0.0, 0.0, 0.0, SHIP.speed_m_s),
        Vector(jnp.zeros(1), jnp.full(1, 46_300.0)),
        straight_track(east, north, jnp.radians(course), speed),
        jnp.arange(slots) < len(targets),
    )


def cases(*encounters: Encounter, steps: int | None = None) -> Case:
    """A batch of cases; ``steps`` in place of what their conflicts ask for."""
    batch = undisturbed_cases(jax.tree.map(lambda *x: jnp.stack(x), *encounters), SHIP)
    if steps is None:
        return batch
    return dataclasses.replace(batch, steps=np.full(len(encounters), steps, np.int32))


def suite(*encounters: Encounter, steps: int | None = None) -> Suite:
    batch = cases(*encounters, steps=steps)
    return Suite("made", "Made by hand", batch, tuple(map(str, range(len(encounters)))))


#: A ship that meets own ship head on after 1000 s.
HEAD_ON = (0.0, 2000 * SPEED, 180.0, SPEED)
#: A ship that passes 2 km to starboard after 1000 s.
ABEAM = (2000.0, 2000 * SPEED, 180.0, SPEED)
