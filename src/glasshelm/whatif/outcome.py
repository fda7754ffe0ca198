"""What came of a future, as numbers; and where two futures part."""

import dataclasses

import numpy as np

from glasshelm.frames.episodes import RELEASE_RAD, TURN_RAD
from glasshelm.frames.schema import BySubTask
from glasshelm.whatif.counterfactual_rollout import BranchRollout, Row


@dataclasses.dataclass(frozen=True)
class ShipOutcome:
    """One ship in a future: how near she came and when, and the worst danger (Eq. 13)."""

    id: str
    name: str
    closest_m: float
    closest_s: float
    danger: float


@dataclasses.dataclass(frozen=True)
class Alteration:
    """The first time that own ship leaves her heading: how far, and how long until then.

    ``half_s`` is how long until half of it; ``returns``: the alteration leads back towards
    the waypoint.
    """

    turn_rad: float
    within_s: float
    half_s: float
    returns: bool


@dataclasses.dataclass(frozen=True)
class Outcome:
    """A future in numbers.

    ``ships`` are those that were there, the nearest first; ``inside_s`` is the time
    with any ship in own ship's domain; ``collided`` says that one came nearer than
    own ship's length, which is only assumed (``length_known`` false) in recorded
    traffic; ``reward`` is the sum over all steps by sub-task (Eq. 16-18).
    """

    ships: tuple[ShipOutcome, ...]
    inside_s: float
    length_m: float
    length_known: bool
    reward: BySubTask
    heading_rad: float
    alteration: Alteration | None
    duration_s: float

    @property
    def nearest(self) -> ShipOutcome | None:
        return self.ships[0] if self.ships else None

    @property
    def collided(self) -> bool:
        return bool(self.ships) and self.ships[0].closest_m < self.length_m

    @property
    def worst(self) -> ShipOutcome | None:
        """The ship of the worst danger; None where the domain was never entered."""
        ship = max(self.ships, key=lambda s: s.danger, default=None)
        return ship if ship is not None and ship.danger > 0 else None


@dataclasses.dataclass(frozen=True)
class Differences:
    """Where two futures part, over the time that both last.

    ``diverge_s`` is when the rudders first differ by half a degree (time of the log),
    None if they never do; ``rudder_rad`` their largest difference; ``max_separation_m`` the
    largest distance between own ship in the one and in the other. ``max_heading_change_rad`` is
    the largest difference of the headings (+ = the second farther to starboard),
    ``max_heading_change_s`` how long after the branch.
    """

    diverge_s: float | None
    rudder_rad: float
    max_separation_m: float
    max_heading_change_rad: float
    max_heading_change_s: float


def outcome_of(future: BranchRollout) -> Outcome:
    """The numbers of a future."""
    traffic = future.steps.traffic
    there = np.asarray(traffic.motion.present) & ~np.asarray(traffic.lost)
    range_m = np.where(there, np.asarray(traffic.range_m, float), np.inf)
    danger = np.where(there, np.asarray(traffic.danger, float), 0.0)
    ships = []
    for slot in np.flatnonzero(there.any(0)):
        info, k = future.branch.scenario.targets[slot], int(np.argmin(range_m[:, slot]))
        closest, at_s = float(range_m[k, slot]), float(future.time_s[k])
        ships.append(ShipOutcome(info.id, info.name, closest, at_s, float(danger[:, slot].max())))
    ships.sort(key=lambda ship: ship.closest_m)
    steps = slice(None, -1)  # the step after the last instant is not part of the future
    waypoint = float(np.sum(np.asarray(future.reward.waypoint, float)[steps]))
    collision = float(np.sum(np.asarray(future.reward.by_ship, float)[steps]))
    start, step_s = future.branch.start, future.branch.settings.step_s
    return Outcome(
        tuple(ships),
        float(np.count_nonzero((danger[1:] > 0).any(1)) * step_s),
        start.ship.loa_m,
        start.decision is None or start.decision.applied,
        BySubTask(waypoint, collision, waypoint + collision),
        float(future.heading_rad[0]),
        _alteration(future),
        step_s * (len(future) - 1),
    )


def differences(one: BranchRollout, other: BranchRollout) -> Differences:
    """Where the second future parts from the first."""
    count = min(len(one), len(other))
    rudder = np.abs(one.rudder_rad[:count] - other.rudder_rad[:count])
    apart = np.hypot(*(one.track_m[:count] - other.track_m[:count]).T)
    parted = np.flatnonzero(rudder >= RELEASE_RAD)
    parts_s = float(one.time_s[parted[0]]) if parted.size else None
    aside = other.heading_rad[:count] - one.heading_rad[:count]
    widest = int(np.argmax(np.abs(aside)))
    after_s = float(one.time_s[widest] - one.time_s[0])
    return Differences(
        parts_s, float(rudder.max()), float(apart.max()), float(aside[widest]), after_s
    )


def _alteration(future: BranchRollout) -> Alteration | None:
    heading = future.heading_rad
    off = heading - heading[0]
    beyond = np.flatnonzero(np.abs(off) >= TURN_RAD)
    if not beyond.size:
        return None
    first = int(beyond[0])
    way = float(np.sign(off[first]))
    back = np.flatnonzero(off[first:] * way < TURN_RAD)
    end = first + int(back[0]) if back.size else len(off)
    most = float((off[first:end] * way).max())
    # What is left of a turn that settles slowly does not stretch it.
    k = first + int(np.flatnonzero(off[first:end] * way >= most - min(0.05 * most, TURN_RAD))[0])
    begin, then = (abs(float(x)) for x in _waypoint_bearing(future, heading)[[0, k]])
    returns = begin >= TURN_RAD and then <= 0.5 * begin
    half = int(np.flatnonzero(off * way >= 0.5 * off[k] * way)[0])
    step_s = future.branch.settings.step_s
    return Alteration(float(off[k]), step_s * k, step_s * half, returns)


def _waypoint_bearing(future: BranchRollout, heading: Row) -> Row:
    """The bearing of the waypoint relative to the heading, in [−π, π)."""
    own, waypoint = future.steps.own, future.steps.waypoint
    course = np.arctan2(waypoint.x - own.east_m, waypoint.y - own.north_m)
    return (np.asarray(course, float) - heading + np.pi) % (2 * np.pi) - np.pi
