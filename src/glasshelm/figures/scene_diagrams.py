"""Figures 1-4: ship motion, the start of a target, the CPA and the domain, computed not sketched.

Every length, angle and outline comes from the code that simulates: Nomoto's model, the
distribution of encounters, the closest approach, Eq. 13.
"""

import functools
import math

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Polygon, Rectangle, Wedge
from matplotlib.transforms import Affine2D

from glasshelm.core.geometry import Vector, closest_approach, velocity
from glasshelm.encounters.random_encounters import RandomEncounters, random_encounters
from glasshelm.encounters.types import motion_at
from glasshelm.figures.maps import HALO, domain_outline, draw_rings, hull_outline
from glasshelm.figures.style import INK, SOFT, legend_below, line_style, new_figure, nm, styled
from glasshelm.ship.domain import AHEAD_LOA, ASTERN_LOA, PORT_LOA, STARBOARD_LOA, danger
from glasshelm.ship.nomoto import KNOT_M_S, NAUTICAL_MILE_M, ShipParams, ShipState, advance

_STEP_S = 5.0
_Point = tuple[float | int, float | int] | np.ndarray
_OTHER = "#0072B2"
_MEETING = "#D55E00"


@styled
def ship_motion(ships: dict[str, ShipParams]) -> Figure:
    """Figure 1: the quantities of Eq. 6-7, and the turn that each ship makes with its rudder over.

    Args:
        ships: Ships by name; the first one is drawn on the left.
    """
    ship = next(iter(ships.values()))
    figure = new_figure(8.6, 4.4)
    left, right = figure.subplots(1, 2)
    _coordinates(left, ship)
    for number, (name, other) in enumerate(ships.items()):
        track, heading_deg = turning_track(other)
        look = line_style(number, name)
        rate = math.degrees(float(other.gain_1_s) * float(other.rudder_limit_rad))
        right.plot(
            nm(track[:, 0]), nm(track[:, 1]), color=look.colour,
            label=f"{name}: K {float(other.gain_1_s):g} 1/s, T {float(other.time_constant_s):g} s, "
            f"{rate:.2f}°/s",
        )  # fmt: skip
        minute = np.arange(0, len(track), round(60 / _STEP_S))
        right.plot(nm(track[minute, 0]), nm(track[minute, 1]), ls="", marker=look.marker, ms=4,
                   color=look.colour, mec="white", mew=0.4)  # fmt: skip
        if heading_deg < 300.0:
            right.annotate(
                f"heading {heading_deg:.0f}°", nm(track[-1]), xytext=(5, 0),
                textcoords="offset points", fontsize=7.5, color=look.colour, va="center",
                path_effects=HALO,
            )  # fmt: skip
    right.set_aspect("equal", adjustable="datalim")
    right.margins(0.12)
    right.grid(True)
    right.set_xlabel("east [NM]")
    right.set_ylabel("north [NM]")
    right.set_title(f"Rudder {_deg(ship.rudder_limit_rad)} to starboard, a marker every minute")
    legend_below(figure, list(right.get_lines()[::2]))
    return figure


def turning_track(
    ship: ShipParams, duration_s: float = 390.0
) -> tuple[Float[np.ndarray, "t 2"], float]:
    """East and north [m] of a ship that puts its rudder over at the start, and its last heading.

    It turns at most a full circle. The heading is in degrees.
    """

    def go(state: ShipState, _: None) -> tuple[ShipState, ShipState]:
        following = advance(state, jnp.asarray(ship.rudder_limit_rad), ship, _STEP_S)
        return following, following

    start = ShipState.steady(0.0, 0.0, 0.0, ship.speed_m_s)
    state = jax.device_get(
        jax.jit(lambda s: jax.lax.scan(go, s, length=int(duration_s / _STEP_S))[1])(start)
    )
    track = np.stack([np.append(0.0, state.east_m), np.append(0.0, state.north_m)], axis=-1)
    heading = np.append(0.0, np.degrees(state.heading_rad))
    whole = heading <= 360.0
    return track[whole], float(heading[whole][-1])


def _coordinates(ax: Axes, ship: ShipParams) -> None:
    """Axes, heading, rate of turn, speed and rudder angle of a ship to scale."""
    heading, rudder = math.radians(40), -float(ship.rudder_limit_rad)
    loa, beam = float(ship.loa_m), float(ship.beam_m)
    place = Affine2D().rotate(-heading) + ax.transData
    ax.add_patch(Polygon(hull_outline(loa, beam), fc="#eef1f4", ec=INK, lw=1.2, transform=place))
    stern = -0.5 * loa * np.array([math.sin(heading), math.cos(heading)])
    blade = heading + math.pi - rudder
    tip = stern + 0.16 * loa * np.array([math.sin(blade), math.cos(blade)])
    ax.plot(*np.stack([stern, tip], -1), color=_MEETING, lw=2.4)
    ahead = np.array([math.sin(heading), math.cos(heading)])
    _arrow(ax, (0, 0), 1.15 * loa * ahead, INK)
    _say(ax, "U", 1.22 * loa * ahead, INK)
    for end, name in (((0, 1.3 * loa), "y, north"), ((1.1 * loa, 0), "x, east")):
        _arrow(ax, (0, 0), end, SOFT)
        _say(ax, name, np.array(end) * 1.07, SOFT)
    ax.add_patch(Arc((0, 0), 1.5 * loa, 1.5 * loa, theta1=50, theta2=90, color=_OTHER, lw=1.2))
    _say(ax, "ψ", 0.86 * loa * np.array([math.sin(heading / 2), math.cos(heading / 2)]), _OTHER)
    ax.annotate(
        "", (0.97 * loa * math.sin(1.25), 0.97 * loa * math.cos(1.25)),
        (1.02 * loa * math.sin(0.85), 1.02 * loa * math.cos(0.85)),
        arrowprops={"arrowstyle": "->", "color": _OTHER, "connectionstyle": "arc3,rad=-0.15"},
    )  # fmt: skip
    _say(ax, "r = dψ/dt", 1.2 * loa * np.array([math.sin(1.12), math.cos(1.12)]), _OTHER)
    _say(ax, f"δ, up to ± {_deg(ship.rudder_limit_rad)}", tip, _MEETING, shift=(0, -0.14 * loa))
    ax.set_xlim(-0.75 * loa, 1.55 * loa)
    ax.set_ylim(-0.85 * loa, 1.5 * loa)
    ax.set_aspect("equal")
    ax.set_axis_off()
    ax.set_title(f"T dr/dt + r = K δ; the ship is {loa:.0f} m by {beam:.0f} m")


@styled
def initial_state(
    ship: ShipParams, settings: RandomEncounters, starts: int = 400, seed: int = 0
) -> Figure:
    """Figure 2: how a target's start is drawn (Eq. 8-9), and where ``starts`` of them really lie.

    Args:
        ship: Own ship.
        settings: The distribution.
        starts: How many encounters of one ship are drawn.
        seed: Of these encounters.
    """
    figure = new_figure(8.6, 4.7)
    left, right = figure.subplots(1, 2)
    _construction(left, ship, settings)
    one = jax.jit(functools.partial(_starts, size=starts, ship=ship, settings=settings))
    east, north, course = jax.device_get(one(jax.random.key(seed)))
    length = 0.55
    right.quiver(
        nm(east), nm(north), length * np.sin(course), length * np.cos(course), color=_OTHER,
        angles="xy", scale_units="xy", scale=1, width=0.0022, headwidth=5, alpha=0.75,
    )  # fmt: skip
    radius = settings.nearest_spawn_loa * float(ship.loa_m) / NAUTICAL_MILE_M
    right.add_patch(Wedge((0, 0), radius, 0, 360, fc="#eef1f4", ec=SOFT, lw=0.8, ls=(0, (4, 2))))
    right.plot([0], [0], marker="^", ms=7, color=INK)
    _say(right, f"none nearer than {settings.nearest_spawn_loa:g} LOA", (0, -1.25 * radius), INK,
         "center")  # fmt: skip
    right.set_aspect("equal")
    right.grid(True)
    right.set_xlabel("east [NM]")
    right.set_ylabel("north [NM]")
    right.set_title(f"{starts} starts as drawn, with their courses")
    return figure


def _starts(
    key: jax.Array, size: int, ship: ShipParams, settings: RandomEncounters
) -> tuple[jax.Array, jax.Array, jax.Array]:
    motion = motion_at(random_encounters(key, size, ship, settings).targets, jnp.zeros(()))
    return motion.east_m[:, 0], motion.north_m[:, 0], motion.course_rad[:, 0]


def _construction(ax: Axes, ship: ShipParams, settings: RandomEncounters) -> None:
    """One target: where the two would meet, the start that leads there, and the noise on it."""
    t_col = float(np.mean(settings.time_to_collision_s))
    speed = float(np.mean(settings.target_speed_m_s))
    course = -math.radians(75)
    meeting = np.array([0.0, float(ship.speed_m_s) * t_col])
    start = meeting - speed * t_col * np.array([math.sin(course), math.cos(course)])
    km = 1000.0
    ax.plot([0, 0], [0, meeting[1] / km], color=INK, lw=1.2)
    ax.plot(*np.stack([start, meeting], -1) / km, color=_OTHER, lw=1.2, ls=(0, (4, 2)))
    ax.plot([0], [0], marker="^", ms=8, color=INK)
    ax.plot(*(meeting / km), marker="x", ms=8, mew=1.8, color=_MEETING)
    noise = settings.position_noise_m / km
    corner = start / km - noise
    ax.add_patch(Rectangle(tuple(corner), 2 * noise, 2 * noise, fc="none", ec=SOFT, lw=0.9))
    middle = 90.0 - math.degrees(course)
    fan = math.degrees(settings.course_noise_rad)
    ax.add_patch(
        Wedge(tuple(start / km), 1.7, middle - fan, middle + fan, fc=_OTHER, alpha=0.22, ec="none")
    )
    ax.plot(*(start / km), marker="s", ms=6, color=_OTHER, mec="white")
    low, high = settings.time_to_collision_s
    slow, fast = settings.target_speed_m_s
    first, last, half = start / km, meeting / km, (start + meeting) / 2 / km
    when = f"{low:g} to {high:g} s (here {t_col:g} s)"
    _say(ax, f"own ship, north, {float(ship.speed_m_s) / KNOT_M_S:g} kn", (0.35, 0.0), INK)
    _say(ax, f"collision after t_col, {when}", last, _MEETING, shift=(-1.8, 0.6))
    text = f"start: Eq. 8, then\n± {noise:g} km and ± {fan:g}° (Eq. 9)"
    _say(ax, text, first, _OTHER, shift=(-0.9, -1.75))
    _say(ax, f"target, {slow:g} to {fast:g} m/s", half, _OTHER, shift=(-2.5, -0.85))
    ax.set_xlim(-2.6, 8.4)
    ax.set_ylim(-1.2, 8.2)
    ax.set_aspect("equal")
    ax.grid(True)
    ax.set_xlabel("east [km]")
    ax.set_ylabel("north [km]")
    ax.set_title("How a target is placed")


@styled
def closest_point(ship: ShipParams) -> Figure:
    """Figure 3: CPA, DCPA and TCPA of two ships that keep straight on, from the code that finds it.

    Args:
        ship: Own ship.
    """
    own_course, course, speed = math.radians(20), math.radians(-70), 5.0
    place = np.array([3600.0, 2600.0])
    own_v = _velocity(own_course, float(ship.speed_m_s))
    v = _velocity(course, speed)
    cpa = closest_approach(
        Vector(*map(jnp.asarray, place.tolist())), Vector(*map(jnp.asarray, (v - own_v).tolist()))
    )
    tcpa, dcpa = float(cpa.tcpa_s), float(cpa.dcpa_m)
    figure = new_figure(5.4, 4.9)
    ax = figure.add_subplot()
    ends = {}
    for name, start, way, colour in (("OS", np.zeros(2), own_v, INK), ("TS", place, v, _OTHER)):
        end = start + tcpa * way
        ends[name] = end
        ax.plot(*nm(np.stack([start, start + 1.35 * tcpa * way], -1)), color=colour, lw=0.9,
                ls=(0, (4, 2)))  # fmt: skip
        _arrow(ax, nm(start), nm(start + 240 * way), colour)
        for at, face in ((start, colour), (end, "white")):
            ax.plot(*nm(at), marker="o", ms=8, mfc=face, mec=colour, mew=1.4)
        _say(ax, name, nm(start), colour, shift=(0.08, -0.14))
        below = 0.02 if name == "TS" else -0.12
        _say(ax, f"{name} at TCPA", nm(end), colour, shift=(0.1, below))
    ax.plot(*nm(np.stack(list(ends.values()), -1)), color=_MEETING, lw=1.6)
    middle = nm((ends["OS"] + ends["TS"]) / 2)
    text = f"DCPA {dcpa / NAUTICAL_MILE_M:.2f} NM"
    _say(ax, text, middle, _MEETING, "right", shift=(-0.1, 0.09))
    ax.set_xlim(-0.5, 2.4)
    ax.set_ylim(-0.35, 2.35)
    ax.set_aspect("equal")
    ax.grid(True)
    ax.set_xlabel("east [NM]")
    ax.set_ylabel("north [NM]")
    ax.set_title(f"Both keep course and speed: TCPA {tcpa:.0f} s")
    return figure


@styled
def domain_shape(ship: ShipParams) -> Figure:
    """Figure 4: the exclusive area (Eq. 14-15) and the level of danger in it (Eq. 13).

    Args:
        ship: Own ship, whose length scales the area.
    """
    loa = float(ship.loa_m)
    figure = new_figure(5.6, 5.6)
    ax = figure.add_subplot()
    reach = 1.25 * AHEAD_LOA * loa / NAUTICAL_MILE_M
    x, y = np.meshgrid(np.linspace(-reach, reach, 241), np.linspace(-reach, reach, 241))
    level = danger(
        Vector(jnp.asarray(x * NAUTICAL_MILE_M), jnp.asarray(y * NAUTICAL_MILE_M)), ship.loa_m
    )
    cmap = LinearSegmentedColormap.from_list("level", ["#fbeeea", "#e9b8ac", "#8f1d14"])
    inside = np.ma.masked_less_equal(np.asarray(level), 0.0)
    filled = ax.contourf(x, y, inside, levels=np.linspace(0, 1, 11), cmap=cmap)
    edge = domain_outline(loa) / NAUTICAL_MILE_M
    ax.plot(edge[:, 0], edge[:, 1], color=INK, lw=1.3)
    ax.add_patch(Polygon(hull_outline(loa, float(ship.beam_m)) / NAUTICAL_MILE_M, fc="white",
                         ec=INK, lw=0.9, zorder=5))  # fmt: skip
    unit = loa / NAUTICAL_MILE_M
    for length, way, side in (
        (AHEAD_LOA, (0, 1), (0.06, 0)), (ASTERN_LOA, (0, -1), (0.06, 0)),
        (STARBOARD_LOA, (1, 0), (0, 0.07)), (PORT_LOA, (-1, 0), (0, 0.07)),
    ):  # fmt: skip
        end = length * unit * np.array(way)
        _arrow(ax, (0, 0), end, INK)
        text = f"{length:g} LOA\n{length * loa / 1000:.2f} km"
        along = way[0] == 0
        _say(ax, text, end * 0.62 + side, INK, "left" if along else "center",
             "center" if along else "bottom")  # fmt: skip
    draw_rings(ax, reach)
    ax.set_xlim(-0.75 * reach, 0.85 * reach)
    ax.set_ylim(-0.5 * reach, 1.1 * reach)
    ax.set_aspect("equal")
    ax.set_xlabel("to port  ←  across own ship [NM]  →  to starboard")
    ax.set_ylabel("ahead of own ship [NM]")
    ax.set_title(f"LOA {loa:.0f} m")
    bar = figure.colorbar(filled, ax=ax, label="level of danger (Eq. 13)", shrink=0.75, aspect=28)
    bar.outline.set_visible(False)  # type: ignore[attr-defined]
    return figure


def _velocity(course_rad: float, speed_m_s: float) -> np.ndarray:
    return np.array([float(part) for part in velocity(jnp.asarray(course_rad), speed_m_s)])


def _deg(angle_rad: object) -> str:
    return f"{math.degrees(float(angle_rad)):g}°"  # type: ignore[arg-type]


def _arrow(ax: Axes, start: _Point, end: _Point, colour: str) -> None:
    (x, y), tip = np.asarray(start, float), np.asarray(end, float)
    ax.annotate(
        "", (tip[0], tip[1]), (x, y), zorder=4,
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.2, "shrinkA": 0, "shrinkB": 0,
                    "mutation_scale": 10},
    )  # fmt: skip


def _say(
    ax: Axes,
    text: str,
    at: _Point,
    colour: str,
    ha: str = "left",
    va: str = "center",
    shift: _Point = (0.0, 0.0),
) -> None:
    x, y = np.asarray(at, float) + shift
    ax.text(x, y, text, color=colour, fontsize=8, ha=ha, va=va, path_effects=HALO, zorder=6)
