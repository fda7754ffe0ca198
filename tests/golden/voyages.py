"""Voyages that a mariner can check by eye, and how they are written.

``python -m tests.golden.voyages`` writes them anew, after a change that is
meant to change them; read the difference before committing it. ``--print`` prints them instead.
"""

import functools
import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from glasshelm.core.geometry import Vector
from glasshelm.encounters.types import Encounter, straight_track
from glasshelm.env.step import EnvSettings, StepResult, reset, step
from glasshelm.ship.nomoto import KNOT_M_S, NAUTICAL_MILE_M, SHIPS, ShipParams, ShipState

HERE = Path(__file__).parent
SETTINGS = EnvSettings()


@functools.partial(jax.jit, static_argnames="steps")
def _sail(encounter: Encounter, ship: ShipParams, rudder_rad, steps: int) -> StepResult:
    def go(state, _):
        out = step(encounter, state, rudder_rad, ship, SETTINGS)
        return out.state, out

    return jax.lax.scan(go, reset(encounter, ship), None, length=steps)[1]


def _encounter(ship: ShipParams, targets: list[tuple[float, float, float, float]]) -> Encounter:
    """Own ship northbound from the origin; targets as (east NM, north NM, course °, knots)."""
    rows = jnp.asarray(targets, jnp.float32).reshape(-1, 4)
    return Encounter(
        ShipState.steady(0.0, 0.0, 0.0, ship.speed_m_s),
        Vector(jnp.zeros(1), jnp.full(1, 25 * NAUTICAL_MILE_M)),
        straight_track(
            rows[:, 0] * NAUTICAL_MILE_M,
            rows[:, 1] * NAUTICAL_MILE_M,
            jnp.radians(rows[:, 2]),
            rows[:, 3] * KNOT_M_S,
        ),
        jnp.ones(len(rows), bool),
    )


def turning_circle(ship: str) -> dict[str, Any]:
    """Five degrees of starboard rudder from a steady course, minute by minute."""
    params = SHIPS[ship]
    steps = 240
    arrays = jax.tree.map(jnp.float32, params)
    out = _sail(_encounter(params, []), arrays, params.rudder_limit_rad, steps)
    own = out.state.own
    return {
        "what": f"turning circle of the {ship!r} ship: 5° starboard rudder from a steady course",
        "speed_kn": round(float(params.speed_m_s) / KNOT_M_S, 2),
        "every_minute": [
            {
                "time": _clock(i),
                "east_m": _round(own.east_m[i], 1),
                "north_m": _round(own.north_m[i], 1),
                "heading_deg": _round(np.degrees(own.heading_rad[i]) % 360, 2),
                "rate_of_turn_deg_min": _round(np.degrees(own.rate_of_turn_rad_s[i]) * 60, 2),
                "rudder_deg": _round(np.degrees(own.rudder_rad[i]), 2),
            }
            for i in _minutes(steps)
        ],
    }


def held_course(what: str, targets: list[tuple[float, float, float, float]]) -> dict[str, Any]:
    """Both ships keep course and speed: range, danger and rewards, minute by minute."""
    params = SHIPS["paper"]
    steps = 240
    arrays = jax.tree.map(jnp.float32, params)
    out = _sail(_encounter(params, targets), arrays, 0.0, steps)
    observation = out.state.observation.targets[:, 0, 0]
    return {
        "what": what,
        "target": dict(zip(("east_nm", "north_nm", "course_deg", "kn"), targets[0], strict=True)),
        "every_minute": [
            {
                "time": _clock(i),
                "own_north_nm": _round(out.state.own.north_m[i] / NAUTICAL_MILE_M, 3),
                "range_nm": _round(out.range_m[i, 0] / NAUTICAL_MILE_M, 3),
                "relative_bearing_deg": _round(observation[i, 2] * 180, 1),
                "cpa_nm": _round(observation[i, 8] * 20_000 * 2**0.5 / NAUTICAL_MILE_M, 3),
                "tcpa_min": _round(observation[i, 9] * 1000 / 60, 2),
                "danger": _round(out.state.danger[i, 0], 3),
                "reward_waypoint": _round(out.reward.waypoint[i], 4),
                "reward_collision": _round(out.reward.by_ship[i, 0], 4),
            }
            for i in _minutes(steps)
        ],
    }


VOYAGES: dict[str, Callable[[], dict[str, Any]]] = {
    "turning-circle-paper": lambda: turning_circle("paper"),
    "turning-circle-large-ship": lambda: turning_circle("large_ship"),
    "head-on": lambda: held_course(
        "both ships at 10 kn, head on, 0.3 NM apart to starboard; nobody gives way",
        [(0.3, 4.0, 180.0, 10.0)],
    ),
    "crossing-from-starboard": lambda: held_course(
        "a ship at 12 kn crosses from starboard and passes close astern; nobody gives way",
        [(2.6, 2.0, 270.0, 12.0)],
    ),
}


def _minutes(steps: int) -> Iterator[int]:
    per_minute = int(60 / SETTINGS.step_s)
    return iter(range(per_minute - 1, steps, per_minute))


def _clock(index: int) -> str:
    seconds = round((index + 1) * SETTINGS.step_s)
    return f"{seconds // 60:02d}:{seconds % 60:02d}"


def _round(value: Any, digits: int) -> float:
    return round(float(value), digits) + 0.0  # no -0.0


def write(name: str) -> None:
    voyage = VOYAGES[name]()
    rows = voyage.pop("every_minute")
    head = json.dumps(voyage, ensure_ascii=False, indent=1)[:-2]
    body = ",\n".join("  " + json.dumps(row) for row in rows)
    text = f'{head},\n "every_minute": [\n{body}\n ]\n}}\n'
    (HERE / f"{name}.json").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    if "--print" in sys.argv:
        print(json.dumps({name: sail() for name, sail in VOYAGES.items()}))
    else:
        for each in VOYAGES:
            write(each)
