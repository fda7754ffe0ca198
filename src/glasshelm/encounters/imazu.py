"""The 22 Imazu cases, and the variants 8b and 12b: designed meetings of up to three ships.

A case is a list of headings and speed ratios; every ship reaches one point at
the same time. The values and their disputes are in ``data/imazu.json``.
"""

import functools
import json
import math
from importlib.resources import files

import jax.numpy as jnp
import numpy as np

from glasshelm.core.errors import InputError
from glasshelm.core.geometry import Vector
from glasshelm.encounters.random_encounters import PAPER
from glasshelm.encounters.types import Encounter, Scenario, TargetInfo, straight_track
from glasshelm.ship.nomoto import ShipParams, ShipState

#: The waypoint of the paper's task, due north of own ship's start [m].
PAPER_WAYPOINT_M = PAPER.waypoint_m[1]


@functools.cache
def imazu_cases() -> dict[str, tuple[tuple[float, float], ...]]:
    """Name of each case -> (heading [deg], ratio to own speed) of its targets."""
    text = files("glasshelm").joinpath("data/imazu.json").read_text(encoding="utf-8")
    return {
        case: tuple((float(heading), float(ratio)) for heading, ratio in targets)
        for case, targets in json.loads(text)["cases"].items()
    }


def imazu_scenario(
    case: str,
    ship: ShipParams,
    tcpa_s: float = 1800.0,
    waypoint_m: float | None = PAPER_WAYPOINT_M,
) -> Scenario:
    """An Imazu case for a ship: all collide after ``tcpa_s`` if nobody acts (DCPA 0).

    Own ship starts at the origin on north at ``ship.speed_m_s``; the meeting
    point lies speed x ``tcpa_s`` ahead. Her waypoint is the one of the paper's
    task, 46.3 km north, as a pilot was trained for it; ``waypoint_m=None``
    takes the case's own goal, as far beyond the meeting point as she starts
    before it. InputError if there is no such case or ``tcpa_s`` is not positive.
    """
    cases = imazu_cases()
    name = case.strip().lower()
    if name not in cases:
        raise InputError(f"no Imazu case {case!r}: choose 1 to 22, 8b or 12b")
    if not (math.isfinite(tcpa_s) and tcpa_s > 0):
        raise InputError(f"Imazu case {name}: tcpa_s = {tcpa_s} must be a positive number")
    run = float(ship.speed_m_s) * tcpa_s
    goal = 2 * run if waypoint_m is None else waypoint_m
    heading = np.radians([h for h, _ in cases[name]])
    ratio = np.array([r for _, r in cases[name]])
    count = len(cases[name])
    return Scenario(
        source=f"imazu:{name}",
        title=f"Imazu case {name}: {count} {'ship' if count == 1 else 'ships'}",
        encounter=Encounter(
            ShipState.steady(0.0, 0.0, 0.0, ship.speed_m_s),
            Vector(jnp.zeros(1), jnp.asarray([goal], jnp.float32)),
            straight_track(
                *(
                    jnp.asarray(x, jnp.float32)
                    for x in (
                        -ratio * run * np.sin(heading),
                        run - ratio * run * np.cos(heading),
                        heading,
                        ratio * float(ship.speed_m_s),
                    )
                )
            ),
            jnp.ones(count, bool),
        ),
        targets=tuple(TargetInfo(str(i + 1), f"ship {i + 1}") for i in range(count)),
        ship=ship,
        duration_s=max(2 * tcpa_s, 2400.0),
    )
