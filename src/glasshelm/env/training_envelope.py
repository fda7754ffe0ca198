"""What lies outside the training distribution, in words for people (host side).

A pilot asked about something it never met still answers. These phrases say
what it never met, step by step, beside every answer.
"""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from jax.typing import ArrayLike
from jaxtyping import Bool

from glasshelm.core.errors import InputError
from glasshelm.core.geometry import Vector
from glasshelm.encounters.random_encounters import WIDE, RandomEncounters
from glasshelm.encounters.types import Motion
from glasshelm.env.observe import TARGET_FEATURES, WAYPOINT_FEATURES, Observation
from glasshelm.env.step import EnvSettings
from glasshelm.ship.nomoto import KNOT_M_S, NAUTICAL_MILE_M, SHIPS, ShipParams, ShipState

#: Within this share of a trained value or range, nothing is said.
SLACK = 0.02
#: No feature of Eq. 10-11 is larger (of a length: 20 million km): what networks make of larger
#: ones is no number.
MAX_FEATURE = 1e6


@dataclasses.dataclass(frozen=True)
class TrainingEnvelope:
    """What a pilot was trained on: her ship, the encounters, how long they lasted."""

    ship: ShipParams = SHIPS["paper"]
    encounters: RandomEncounters = WIDE
    env: EnvSettings = dataclasses.field(default_factory=EnvSettings)

    @property
    def farthest_target_m(self) -> float:
        """The farthest that Eq. 8-9 places a ship: met end on after the longest t_col."""
        e = self.encounters
        closing = float(self.ship.speed_m_s) + e.target_speed_m_s[1]
        return e.time_to_collision_s[1] * closing + math.sqrt(2) * e.position_noise_m

    @property
    def waypoint_m(self) -> tuple[float, float]:
        """The waypoint's distances in training: from the end of an episode to its start."""
        near, far = self.encounters.waypoint_m
        run = float(self.ship.speed_m_s) * self.env.episode_steps * self.env.step_s
        return max(near - run, self.env.arrival_m), far


def outside_training(
    own: ShipState,
    ship: ShipParams,
    waypoint: Vector,
    targets: Motion,
    selected: Bool[np.ndarray, " n"] | None = None,
    trained: TrainingEnvelope = TrainingEnvelope(),
) -> list[str]:
    """Short phrases, one for each thing outside the training distribution; empty if none.

    ``targets`` are the ships at this instant, ``selected`` which of them the pilot
    is shown (default: all present). Compared are own ship's length, speed and
    steering, the number of ships, their speeds and ranges, the waypoint's
    distance.
    """
    said = _of_own_ship(own, ship, trained)
    distance = float(_range(waypoint.x, waypoint.y, own))
    near, far = trained.waypoint_m
    if distance < near * (1 - SLACK):
        said.append(f"waypoint {_nm(distance)} NM off (trained: from {_nm(near)} NM)")
    if distance > far * (1 + SLACK):
        said.append(f"waypoint {_nm(distance)} NM off (trained: up to {_nm(far)} NM)")
    shown = (
        np.asarray(targets.present) if selected is None else np.asarray(targets.present) & selected
    )
    return said + _of_targets(own, targets, shown, trained)


def _of_own_ship(own: ShipState, ship: ShipParams, trained: TrainingEnvelope) -> list[str]:
    said = []
    known = trained.ship
    if _differs(float(ship.loa_m), float(known.loa_m)):
        said.append(f"own length {float(ship.loa_m):.0f} m (trained: {float(known.loa_m):.0f} m)")
    if _differs(float(own.speed_m_s), float(known.speed_m_s)):
        said.append(f"own speed {_kn(own.speed_m_s)} kn (trained: {_kn(known.speed_m_s)} kn)")
    steering = ("gain_1_s", "time_constant_s", "rudder_limit_rad", "rudder_rate_rad_s")
    if any(_differs(float(getattr(ship, f)), float(getattr(known, f))) for f in steering):
        said.append("own ship answers her rudder otherwise than the ship trained on")
    return said


def _of_targets(
    own: ShipState, targets: Motion, shown: Bool[np.ndarray, " n"], trained: TrainingEnvelope
) -> list[str]:
    said = []
    count = int(shown.sum())
    most = trained.encounters.targets[1]
    if count > most:
        said.append(f"{count} ships selected (trained: at most {most})")
    speed = np.asarray(targets.speed_m_s)[shown]
    slow, fast = trained.encounters.target_speed_m_s
    range_m = _range(targets.east_m, targets.north_m, own)[shown]
    far = trained.farthest_target_m
    for odd, what in (
        (speed < slow * (1 - SLACK), f"slower than {_kn(slow)} kn"),
        (speed > fast * (1 + SLACK), f"faster than {_kn(fast)} kn"),
        (range_m > far * (1 + SLACK), f"farther than {_nm(far)} NM"),
    ):
        if odd.any():
            said.append(f"{int(odd.sum())} of {count} {'ship' if count == 1 else 'ships'} {what}")
    return said


def invalid_features(observation: Observation, names: Sequence[str] = ()) -> list[str]:
    """What in an observation is no possible number: the waypoint or ship, and which features.

    Not finite, or larger than :data:`MAX_FEATURE`.

    ``names`` are the ships' names by slot. Empty slots are not looked at.
    """
    said = _bad("the waypoint", np.asarray(observation.waypoint), WAYPOINT_FEATURES)
    rows = np.asarray(observation.targets)
    for slot in np.flatnonzero(np.asarray(observation.present)).tolist():
        name = names[slot] if slot < len(names) else f"ship {slot + 1}"
        said += _bad(name, rows[slot], TARGET_FEATURES)
    return said


def check_observation(observation: Observation, names: Sequence[str] = ()) -> None:
    """InputError naming the first thing in an observation that is no possible number."""
    said = invalid_features(observation, names)
    if said:
        raise InputError(f"cannot decide: {said[0]}; check the positions, courses and speeds given")


def _bad(name: str, frames: np.ndarray, features: tuple[str, ...]) -> list[str]:
    for wrong, what in (
        (~np.isfinite(frames), "no finite"),
        (np.abs(frames) > MAX_FEATURE, "an impossible"),
    ):
        columns = np.any(wrong, axis=0).tolist()
        listed = ", ".join(f for f, bad in zip(features, columns, strict=True) if bad)
        if listed:
            return [f"{name} is seen with {what} {listed}"]
    return []


def _range(east_m: ArrayLike, north_m: ArrayLike, own: ShipState) -> np.ndarray:
    """Distance from own ship, on the host: no device program for a few subtractions."""
    east, north = np.asarray(east_m) - np.asarray(own.east_m), np.asarray(north_m)
    return np.asarray(np.hypot(east, north - np.asarray(own.north_m)))


def _differs(value: float, trained: float) -> bool:
    if math.isinf(value) or math.isinf(trained):
        return value != trained
    return abs(value - trained) > SLACK * abs(trained)


def _kn(speed_m_s: object) -> str:
    return f"{float(np.asarray(speed_m_s)) / KNOT_M_S:.1f}"


def _nm(distance_m: float) -> str:
    return f"{distance_m / NAUTICAL_MILE_M:.1f}"
