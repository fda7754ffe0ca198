"""A few encounters sailed once more, as frames, to be drawn."""

from collections.abc import Iterator
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from glasshelm.core.geometry import Vector, closest_approach, direction, norm, to_body, velocity
from glasshelm.encounters.types import TargetInfo
from glasshelm.evaluation.measure_columns import SuiteResult
from glasshelm.evaluation.result_cache import CHUNK
from glasshelm.frames.schema import Decision, Frame, Own, Target, Waypoint
from glasshelm.ship.domain import danger
from glasshelm.simulation.frame_builder import ship_part
from glasshelm.simulation.rollout import SETTINGS, Case, Positions, policy_for, rollout_tracks


def worst_cases(one: SuiteResult, count: int) -> np.ndarray:
    """The encounters in which the pilot was deepest in somebody's domain, or nearest to it."""
    met = np.flatnonzero(one.columns["ships"] > 0)
    return met[np.argsort(-one.columns["margin"][met], kind="stable")][:count]


def replay_cases(one: SuiteResult, which: np.ndarray) -> Iterator[list[Frame]]:
    """The frames of some encounters, each as long as it was measured.

    They are sailed in a batch of the size that was evaluated, as near to the same
    program as can be: a voyage that hangs by the last bit of a number may still differ.
    """
    if len(which) == 0:
        return
    size = max(min(CHUNK, one.suite.size), len(which))
    filled = np.resize(which, size)
    cases = jax.tree.map(jnp.asarray, one.suite.take(filled))
    steps = int(np.asarray(cases.steps).max())
    policy = policy_for(one.contender.pilots[one.seed], cases)
    places = jax.device_get(rollout_tracks(policy, cases, steps))
    for k, number in enumerate(which):
        case = jax.tree.map(lambda x, k=k: x[k], cases)
        last = round(float(one.columns["time_s"][number]) / SETTINGS.step_s)
        place = jax.tree.map(lambda x, k=k, last=last: x[: last + 1, k], places)
        infos = one.suite.targets[number] if one.suite.targets else ()
        yield _frames(one, case, place, f"{one.suite.name} {one.suite.labels[number]}", infos)


def _frames(
    one: SuiteResult, case: Case, place: Positions, source: str, infos: tuple[TargetInfo, ...]
) -> list[Frame]:
    """Frames without reasons: what was where, and the rudder decided."""
    ship = ship_part(jax.tree.map(float, case.ship))
    waypoint = Waypoint(float(case.encounter.route.x[-1]), float(case.encounter.route.y[-1]))
    targets = _targets(case, place, infos)
    own = place.own
    return [
        Frame(
            time_s=SETTINGS.step_s * t,
            pilot=one.contender.name,
            source=source,
            ship=ship,
            own=Own(
                float(own.east_m[t]),
                float(own.north_m[t]),
                float(own.heading_rad[t]),
                float(own.speed_m_s[t]),
                float(own.rate_of_turn_rad_s[t]),
                float(own.rudder_rad[t]),
            ),
            waypoint=waypoint,
            targets=targets[t],
            decision=Decision(float(place.rudder_rad[t])),
        )
        for t in range(len(own.east_m))
    ]


def _targets(case: Case, place: Positions, infos: tuple[TargetInfo, ...]) -> list[list[Target]]:
    """The targets at each instant."""
    own = jax.tree.map(lambda x: x[:, None], place.own)
    offset = Vector(place.east_m - own.east_m, place.north_m - own.north_m)
    body = to_body(offset, jnp.asarray(own.heading_rad))
    mine = velocity(jnp.asarray(own.heading_rad), jnp.asarray(own.speed_m_s))
    theirs = velocity(jnp.asarray(place.course_rad), jnp.asarray(place.speed_m_s))
    cpa = closest_approach(offset, Vector(theirs.x - mine.x, theirs.y - mine.y))
    facts = jax.device_get(
        {
            "east_m": place.east_m,
            "north_m": place.north_m,
            "course_rad": place.course_rad,
            "speed_m_s": place.speed_m_s,
            "range_m": norm(body),
            "bearing_rad": direction(body),
            "dcpa_m": cpa.dcpa_m,
            "tcpa_s": cpa.tcpa_s,
            "danger": danger(body, float(case.ship.loa_m)),
        }
    )

    def target(t: int, k: int) -> Target:
        info = infos[k] if k < len(infos) else TargetInfo(str(k + 1), f"ship {k + 1}")
        here: dict[str, Any] = {name: float(values[t, k]) for name, values in facts.items()}
        return Target(info.id, info.name, **here)

    present = np.asarray(place.present)
    return [[target(t, int(k)) for k in np.flatnonzero(row)] for t, row in enumerate(present)]
