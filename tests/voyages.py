"""Voyages made by hand, frame by frame, for tests of what is drawn and told."""

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from glasshelm.core.geometry import Vector
from glasshelm.frames import schema as f
from glasshelm.ship.domain import danger

STEP_S = 5.0
SPEED_M_S = 5.0
LOA_M = 340.0

#: A quantity as a function of the frame's index.
Curve = Callable[[int], float]


@dataclasses.dataclass(frozen=True)
class Other:
    """A target that keeps course and speed; what the pilot makes of her, if anything."""

    name: str
    east_m: float
    north_m: float
    course_deg: float
    speed_m_s: float = 5.0
    priority: Curve | None = None
    attention: Curve | None = None
    q: Curve | None = None
    share_deg: Curve | None = None
    here: Callable[[int], bool] = lambda k: True
    lost: Callable[[int], bool] = lambda k: False


def zero(k: int) -> float:
    return 0.0


def voyage(
    headings_deg: Sequence[float],
    others: Sequence[Other] = (),
    waypoint_priority: Curve | None = None,
    rudder_deg: Curve | None = None,
    alone_deg: Curve | None = None,
    applied: bool = True,
    outside_training: Callable[[int], list[str] | None] = lambda k: None,
    time_utc: Callable[[int], str | None] = lambda k: None,
    sweep: bool = False,
) -> list[f.Frame]:
    """Own ship from the origin on these headings, one a frame; the waypoint far to the north.

    The rudder defaults to 3° towards where the heading changes.
    """
    headings = np.radians(np.asarray(headings_deg, float))
    change = np.append(np.diff(headings), 0.0)
    east = np.concatenate([[0.0], np.cumsum(np.sin(headings[:-1]) * SPEED_M_S * STEP_S)])
    north = np.concatenate([[0.0], np.cumsum(np.cos(headings[:-1]) * SPEED_M_S * STEP_S)])
    frames = []
    for k, heading in enumerate(headings.tolist()):
        time = STEP_S * k
        x, y = float(east[k]), float(north[k])
        rudder = np.sign(change[k]) * 3.0 if rudder_deg is None else rudder_deg(k)
        targets = [_target(o, k, time, x, y, heading, sweep) for o in others if o.here(k)]
        learned = waypoint_priority is not None
        total = sum(t.priority or 0.0 for t in targets)
        frames.append(
            f.Frame(
                time_s=time,
                pilot="by hand",
                source="made",
                ship=f.Ship(LOA_M, 60.0, 0.1827, 11.1, float(np.radians(5)), SPEED_M_S),
                own=f.Own(x, y, heading, SPEED_M_S, 0.0, float(np.radians(rudder))),
                waypoint=f.Waypoint(0.0, 40_000.0),
                targets=targets,
                decision=f.Decision(
                    float(np.radians(rudder)),
                    applied,
                    float(np.radians(alone_deg(k))) if alone_deg else None,
                ),
                weights_sha256="0123456789abcdef" * 4 if learned else None,
                time_utc=time_utc(k),
                priority=f.BySubTask(waypoint_priority(k), total) if waypoint_priority else None,
                sweep=_sweep(targets) if sweep else None,
                outside_training=outside_training(k),
            )
        )
    return frames


def _target(
    other: Other, k: int, time: float, east: float, north: float, heading: float, sweep: bool
) -> f.Target:
    course = float(np.radians(other.course_deg))
    x = other.east_m + other.speed_m_s * time * np.sin(course)
    y = other.north_m + other.speed_m_s * time * np.cos(course)
    dx, dy = x - east, y - north
    vx = other.speed_m_s * np.sin(course) - SPEED_M_S * np.sin(heading)
    vy = other.speed_m_s * np.cos(course) - SPEED_M_S * np.cos(heading)
    square = vx**2 + vy**2
    tcpa = float(np.clip(-(dx * vx + dy * vy) / square, -3600, 3600)) if square > 1e-9 else 0.0
    bearing = float(np.mod(np.arctan2(dx, dy) - heading + np.pi, 2 * np.pi) - np.pi)
    distance = float(np.hypot(dx, dy))
    body = Vector(distance * np.sin(bearing), distance * np.cos(bearing))  # type: ignore[arg-type]
    priority = other.priority(k) if other.priority else None
    attention = other.attention(k) if other.attention else None
    both = priority is not None and attention is not None
    return f.Target(
        id=other.name,
        name=other.name,
        east_m=float(x),
        north_m=float(y),
        course_rad=course,
        speed_m_s=other.speed_m_s,
        range_m=distance,
        bearing_rad=bearing,
        dcpa_m=float(np.hypot(dx + tcpa * vx, dy + tcpa * vy)),
        tcpa_s=tcpa,
        danger=float(danger(body, LOA_M)),
        q=other.q(k) if other.q else None,
        q_far=0.0 if other.q else None,
        q_sweep=[-0.1, 0.0, 0.1] if sweep else None,
        priority=priority,
        attention=attention,
        shapley_rad=float(np.radians(other.share_deg(k))) if other.share_deg else None,
        intention=priority * attention if both else None,  # type: ignore[operator]
        lost=other.lost(k),
    )


def _sweep(targets: list[f.Target]) -> f.Sweep:
    rudder = [float(np.radians(x)) for x in (-5, 0, 5)]
    return f.Sweep(rudder, [0.1, 0.0, -0.1], [len(targets) * x for x in (-0.1, 0.0, 0.1)])


def learned() -> list[f.Frame]:
    """A full voyage of an attention pilot: out 30° to starboard for one ship, and back."""
    headings = [0.0] * 20 + list(np.linspace(0, 30, 20)) + [30.0] * 60
    headings += list(np.linspace(30, 0, 20)) + [0.0] * 40
    crossing = Other(
        "Aurora", 3000.0, 3000.0, 270.0, priority=lambda k: 0.08 if k < 50 else -0.02,
        attention=lambda k: 0.9 if k < 80 else 0.2, q=lambda k: -0.5 if k < 80 else 0.0,
        share_deg=lambda k: 2.9 if k < 80 else -0.2,
    )  # fmt: skip
    slow = Other(
        "Borealis", -2500.0, 500.0, 10.0, 3.0, priority=lambda k: 0.01,
        attention=lambda k: 0.1 if k < 80 else 0.8, q=lambda k: -0.1,
        share_deg=lambda k: 0.05,
    )  # fmt: skip
    return voyage(
        headings,
        [crossing, slow],
        waypoint_priority=lambda k: -0.03 if k < 80 else 0.05,
        alone_deg=lambda k: 0.05 if k < 80 else -2.85,
        sweep=True,
    )


def plain() -> list[f.Frame]:
    """The same waters with a pilot that gives no reasons."""
    return voyage([0.0] * 120, [Other("Aurora", 3000.0, 600.0, 270.0)])
