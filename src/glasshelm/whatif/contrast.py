"""Why not another course? The chosen manoeuvre against the best one along that course, by ship."""

import dataclasses
from collections.abc import Sequence
from typing import TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from glasshelm.core.errors import InputError
from glasshelm.encounters.types import TargetInfo
from glasshelm.env.observe import Observation
from glasshelm.explanation.manoeuvre_explanation import choose
from glasshelm.frames.phrases import course, duration
from glasshelm.frames.schema import Frame
from glasshelm.networks.critics import QValues
from glasshelm.pilots.decide import select
from glasshelm.pilots.glassbox import GlassboxPilot
from glasshelm.pilots.guarded import GuardedPilot
from glasshelm.pilots.protocols import Pilot, check_pilot
from glasshelm.planning.manoeuvres import Manoeuvres
from glasshelm.planning.situation import situation_of
from glasshelm.ship.nomoto import ShipParams
from glasshelm.whatif.branch import branch_at

Tree = TypeVar("Tree")


@dataclasses.dataclass(frozen=True)
class Contrast:
    """The chosen manoeuvre less another: what each sub-task and each ship has to say for it.

    All values are differences of Q in points of return, positive where they speak for the chosen
    manoeuvre. They add up to ``total``, exactly: this is the comparison that the pilot makes.

    Attributes:
        time_s: When, in the log.
        chosen_rad: The true course that the pilot chooses.
        chosen_s: How long it is to be held; 0: on to the waypoint at once.
        other_rad: The true course asked about, or the nearest that the pilot knows.
        other_s: The duration at which that is worth most.
        waypoint: For the way to the waypoint.
        helm: For altering course less.
        by_ship: For each ship, by name, the weightiest first.
    """

    time_s: float
    chosen_rad: float
    chosen_s: float
    other_rad: float
    other_s: float
    waypoint: float
    helm: float
    by_ship: dict[str, float]

    @property
    def total(self) -> float:
        return self.waypoint + self.helm + sum(self.by_ship.values())

    @property
    def summary(self) -> str:
        """The whole in one sentence."""
        steers = f"{course(self.chosen_rad)} for {duration(self.chosen_s)}"
        if self.chosen_s == 0:
            steers = f"{course(self.chosen_rad)} to the waypoint"
        other = f"{course(self.other_rad)} for {duration(self.other_s)}"
        reasons = {**self.by_ship, "the way to the waypoint": self.waypoint,
                   "altering less": self.helm}  # fmt: skip
        ranked = sorted(reasons.items(), key=lambda item: -abs(item[1]))
        named = ", ".join(f"{name} {value:+.1f}" for name, value in ranked if abs(value) >= 0.05)
        if self.total < 0:
            return (
                f"{other} would be worth {-self.total:.1f} points more than {steers}: it is not "
                f"among the courses that the pilot compares ({named})."
            )
        return f"{steers} is worth {self.total:.1f} points more than {other}: {named or 'equal'}."


def why_not(frames: Sequence[Frame], number: int, pilot: Pilot, course_rad: float) -> Contrast:
    """Compare the manoeuvre that a pilot chooses at a frame with another course.

    Args:
        frames: The frames of a log, in order.
        number: Index of the frame.
        pilot: A pilot that chooses manoeuvres; a guarded one, where its guard steers.
        course_rad: The true course that is asked about [rad].

    Returns:
        The difference of both values, by sub-task and ship.

    Raises:
        InputError: There is no such frame, or the pilot does not compare courses.
    """
    check_pilot(pilot)
    branch = branch_at(frames, number, pilot, 0)
    deciding = _comparing(pilot, branch.start)
    heading = branch.start.own.heading_rad
    relative = (course_rad - heading + np.pi) % (2 * np.pi) - np.pi
    observation = branch.initial.state.observation
    m, q, other, q_other, slots, bearing = jax.device_get(
        _compare(deciding, observation, jnp.float32(relative), branch.ship)
    )
    infos = branch.scenario.targets
    gains = {
        int(i): float(gain) for i, gain in zip(slots, q.by_ship - q_other.by_ship, strict=True)
    }
    ranked = sorted((i for i in gains if i < len(infos)), key=lambda i: -abs(gains[i]))
    return Contrast(
        branch.start.time_s,
        float(heading + bearing + m.offset_rad) % (2 * np.pi),
        float(m.duration_s),
        float(heading + bearing + other.offset_rad) % (2 * np.pi),
        float(other.duration_s),
        float(q.waypoint - q_other.waypoint),
        float(q.helm - q_other.helm),
        {_name(infos, i): gains[i] for i in ranked},
    )


def _comparing(pilot: Pilot, frame: Frame) -> GlassboxPilot:
    """Who compared courses for a frame. InputError if nobody did."""
    if isinstance(pilot, GuardedPilot):
        if frame.guard is not None and frame.guard.steers:
            return pilot.guard
        raise InputError(
            f"pilot {pilot.name!r} compares courses only while its guard steers, and at "
            f"{frame.time_s:g} s it does not"
        )
    if not isinstance(pilot, GlassboxPilot):
        raise InputError(
            f"pilot {pilot.name!r} compares no courses: choose one that does, as glassbox"
        )
    return pilot


def _name(infos: Sequence[TargetInfo], slot: int) -> str:
    """A ship's name, with its id where another has the same."""
    name = infos[slot].name
    alike = sum(info.name == name for info in infos)
    return name if alike == 1 else f"{name} ({infos[slot].id})"


@eqx.filter_jit
def _compare(
    pilot: GlassboxPilot,
    observation: Observation,
    course_rad: Float[Array, ""],
    ship: ShipParams,
) -> tuple[Manoeuvres, QValues, Manoeuvres, QValues, Array, Float[Array, ""]]:
    """The chosen manoeuvre and the best along a course, with their values."""
    selection = select(observation, ship.loa_m)
    seen, own_ship = selection.observation, pilot.ship or ship
    bearing = situation_of(seen, own_ship).bearing_rad
    manoeuvres, values = pilot.critic(seen, own_ship)
    others, other_values = pilot.critic.along(course_rad, seen, own_ship)
    row, other = choose(values), choose(other_values)

    def at(part: Tree, row: Int[Array, ""]) -> Tree:
        return jax.tree.map(lambda x: x[row], part)

    chosen = at(manoeuvres, row), at(values, row)
    return *chosen, at(others, other), at(other_values, other), selection.slots, bearing
