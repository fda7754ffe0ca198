"""Scenes for tests: straight runners around a turning own ship."""

import jax
import jax.numpy as jnp
import numpy as np

from glasshelm.certify.measurements import RawPlots, SensorErrors

SCENES, SLOTS = 8, 3
#: Largest errors [m, °, m/s].
LEVELS = ((0.0, 0.0, 0.0), (10.0, 0.5, 0.05), (100.0, 3.0, 0.25))
KINDS = ("around", "astern", "alongside")


def errors(position_m: float, course_deg: float, speed_m_s: float) -> SensorErrors:
    """The same for own ship and targets."""
    numbers = (position_m, np.radians(course_deg), speed_m_s) * 2
    return SensorErrors(*(jnp.asarray(x, jnp.float32) for x in numbers))


def scenes(kind: str = "around") -> RawPlots:
    """``astern``: all within 0.2° of dead astern; ``alongside``: all sail nearly as own ship does.

    Nobody is there in the first scene, one ship in the second.
    """
    drawn = np.random.default_rng(3)
    shape = (SCENES, SLOTS, 5)
    age = 5.0 * np.arange(5)
    heading = drawn.uniform(-3, 3, (SCENES, 1)) - 0.004 * age * drawn.integers(0, 2, (SCENES, 1))
    range_m = drawn.uniform(800, 12_000, (SCENES, SLOTS, 1))
    away = drawn.uniform(-np.pi, np.pi, (SCENES, SLOTS, 1))
    course = drawn.uniform(-np.pi, np.pi, (SCENES, SLOTS, 1))
    speed = drawn.uniform(3, 8, (SCENES, SLOTS, 1))
    if kind == "astern":
        away = heading[:, None, :1] + np.pi + drawn.uniform(-0.003, 0.003, (SCENES, SLOTS, 1))
    if kind == "alongside":
        course = heading[:, None, :1] + 0.1 * course
        speed = 5.144 + 0.1 * (speed - 5.5)
    east = range_m * np.sin(away) - age * speed * np.sin(course)
    north = range_m * np.cos(away) - age * speed * np.cos(course)
    own = np.broadcast_to(heading[:, None], shape)
    rows = [east, north, own, np.full(shape, 5.144), course + 0 * age, speed + 0 * age]
    ahead = [0 * heading + 9_000, 0 * heading + 20_000, heading, 0 * heading + 5.144]
    ahead += [0 * heading, 0 * heading]
    present = np.ones((SCENES, SLOTS), bool)
    present[0], present[1, 1:] = False, False
    arrays = [np.stack(np.broadcast_arrays(*x), -1).astype(np.float32) for x in (ahead, rows)]
    return RawPlots(jnp.asarray(arrays[0]), jnp.asarray(arrays[1]), jnp.asarray(present))


def one_of(scene: RawPlots, number: int) -> RawPlots:
    return jax.tree.map(lambda x: x[number], scene)
