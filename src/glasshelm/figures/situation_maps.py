"""The situation at one instant: who is where, going where, and what the pilot does."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from glasshelm.core.errors import InputError
from glasshelm.figures import maps
from glasshelm.figures.style import INK, ShipStyle, ship_styles
from glasshelm.frames.series import Series, ships_of_note
from glasshelm.ship.nomoto import NAUTICAL_MILE_M

#: Course vectors show where each ship will be after this time.
VECTOR_S = 360.0
#: The return is sought at least this long after the avoiding.
APART_S = 60.0
#: Ships farther off than this do not widen the map, unless the action is for them.
SITUATION_NM = 3.5
#: An action is for the ships whose priority is more than this share of the largest.
_SHARE = 0.1


def choose(voyage: Series, times_s: Sequence[float] | None = None) -> list[int]:
    """The frames to show: those nearest to ``times_s``, or the avoiding and the return.

    The avoiding is where the collision priority (Eq. 22) is largest; the return
    is where, a minute or more later, the rudder is towards the waypoint and the
    waypoint's priority is largest (left out if it is never positive then).
    InputError if a time lies outside the voyage.
    """
    if times_s is not None:
        for time in times_s:
            if not voyage.time_s[0] <= time <= voyage.time_s[-1]:
                raise InputError(
                    f"time {time:g} s lies outside the voyage "
                    f"({voyage.time_s[0]:g} to {voyage.time_s[-1]:g} s)"
                )
        return sorted({voyage.at(time) for time in times_s})
    if not np.isfinite(voyage.priority_collision).any():
        return [0]
    avoiding = int(np.nanargmax(voyage.priority_collision))
    towards = voyage.rudder_rad * voyage.waypoint_bearing_rad > 0
    later = voyage.time_s >= voyage.time_s[avoiding] + APART_S
    wish = np.where(towards & later, voyage.priority_waypoint, np.nan)
    if not np.isfinite(wish).any() or np.nanmax(wish) <= 0:
        return [avoiding]
    return [avoiding, int(np.nanargmax(wish))]


def describe_rudder(voyage: Series, k: int) -> str:
    """The action in words: ``rudder 3.2° to starboard``, ``rudder amidships``."""
    degrees = float(np.degrees(voyage.rudder_rad[k]))
    if not np.isfinite(degrees):
        return "rudder not known"
    verb = "rudder" if voyage.applied else "advised rudder"
    if abs(degrees) < 0.05:
        return f"{verb} amidships"
    return f"{verb} {abs(degrees):.1f}° to {'starboard' if degrees > 0 else 'port'}"


def draw_situation(ax: Axes, voyage: Series, k: int) -> None:
    """A north-up map around own ship: past tracks thin, domain, six-minute course vectors."""
    east, north = voyage.east_m[k] / NAUTICAL_MILE_M, voyage.north_m[k] / NAUTICAL_MILE_M
    past = slice(0, k + 1)
    maps.draw_domain(ax, voyage.frames[k].ship, east, north, float(voyage.heading_rad[k]))
    ax.plot(
        voyage.east_m[past] / NAUTICAL_MILE_M, voyage.north_m[past] / NAUTICAL_MILE_M,
        color=INK, lw=1.0,
    )  # fmt: skip
    own = ShipStyle(INK, "o", "own ship")
    _vector(ax, east, north, voyage.heading_rad[k], voyage.speed_m_s[k], own)
    by_id = ship_styles(voyage)
    xs, ys = [east - 1, east + 1], [north - 1, north + 1]
    largest = np.nanmax([abs(s.priority[k]) for s in voyage.ships] or [0.0])
    for ship in ships_of_note(voyage):
        if not np.isfinite(ship.east_m[k]):
            continue
        look = by_id[ship.id]
        x, y = maps.track(ship, False)
        ax.plot(x[past], y[past], color=look.colour, lw=1.0, alpha=0.7)
        _vector(ax, x[k], y[k], ship.course_rad[k], ship.speed_m_s[k], look)
        ax.plot([x[k]], [y[k]], marker=look.marker, ms=7, color=look.colour, mec="white", mew=0.6,
                zorder=5)  # fmt: skip
        is_for = abs(ship.priority[k]) > _SHARE * largest
        if is_for or ship.range_m[k] < SITUATION_NM * NAUTICAL_MILE_M:
            xs.append(x[k])
            ys.append(y[k])
            ax.annotate(
                look.label, (x[k], y[k]), xytext=(7, -8), textcoords="offset points", fontsize=7.5,
                color=look.colour, path_effects=maps.HALO, zorder=6, annotation_clip=True,
            )  # fmt: skip
    maps.limits(ax, np.array(xs), np.array(ys), least_nm=4.0)
    ax.set_xlabel("east [NM]")
    ax.set_ylabel("north [NM]")
    ax.grid(True)


def _vector(
    ax: Axes, x: float, y: float, course_rad: float, speed_m_s: float, look: ShipStyle
) -> None:
    run = speed_m_s * VECTOR_S / NAUTICAL_MILE_M
    tip = (x + run * np.sin(course_rad), y + run * np.cos(course_rad))
    vector = ax.annotate(
        "", tip, (x, y), zorder=4, annotation_clip=False,
        arrowprops={"arrowstyle": "->", "color": look.colour, "lw": 1.3, "shrinkA": 0,
                    "shrinkB": 0, "mutation_scale": 8},
    )  # fmt: skip
    assert vector.arrow_patch is not None
    vector.arrow_patch.set_clip_box(ax.bbox)
