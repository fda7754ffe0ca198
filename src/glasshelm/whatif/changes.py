"""What may be different in a future; each change alters the premise that it starts from."""

import dataclasses
import math
from typing import Protocol, runtime_checkable

import equinox as eqx
import jax.numpy as jnp

from glasshelm.core.errors import InputError
from glasshelm.encounters.types import Track
from glasshelm.env.observe import Observation
from glasshelm.env.step import targets_at
from glasshelm.frames.phrases import degrees, duration, side
from glasshelm.whatif.branch import Branch, BranchState

#: An order that is never taken back, in steps.
UNTIL_THE_END = 2**30


@runtime_checkable
@runtime_checkable
class Change(Protocol):
    """One thing that is different from the instant of the branch on."""

    def apply(self, branch: Branch, premise: BranchState) -> BranchState:
        """The premise with it. InputError, in one line, if this branch does not have it."""
        ...

    def describe(self, branch: Branch) -> str:
        """The condition in words, to go on with a comma: ``without ship 3``."""
        ...


@dataclasses.dataclass(frozen=True)
class Deleted:
    """The ship is not there, and never was: nobody sees her, nobody can hit her."""

    ship: str

    def apply(self, branch: Branch, premise: BranchState) -> BranchState:
        slot = branch.slot(self.ship)
        there = jnp.arange(premise.visible.shape[0]) != slot
        return eqx.tree_at(
            lambda p: (
                p.encounter.present,
                p.last_known.motion.present,
                p.state.danger,
                p.state.observation,
            ),
            premise,
            (
                premise.encounter.present & there,
                premise.last_known.motion.present & there,
                jnp.where(there, premise.state.danger, 0.0),
                masked(premise.state.observation, there),
            ),
        )

    def describe(self, branch: Branch) -> str:
        return f"without {_name(branch, self.ship)}"


@dataclasses.dataclass(frozen=True)
class Hidden:
    """The pilot does not see the ship; she is there, and counts for danger and collisions."""

    ship: str

    def apply(self, branch: Branch, premise: BranchState) -> BranchState:
        visible = premise.visible.at[branch.slot(self.ship)].set(False)
        known = masked(premise.state.observation, visible)
        return eqx.tree_at(lambda p: (p.visible, p.state.observation), premise, (visible, known))

    def describe(self, branch: Branch) -> str:
        return f"if the pilot did not see {_name(branch, self.ship)}"


@dataclasses.dataclass(frozen=True)
class KeptCourse:
    """From now on she goes straight, at the course and speed that she has.

    ``ship`` None is own ship: her rate of turn ends at once and her rudder stays
    amidships; the pilot decides nothing.
    """

    ship: str | None = None

    def apply(self, branch: Branch, premise: BranchState) -> BranchState:
        if self.ship is None:
            steady = jnp.zeros_like(premise.state.own.rate_of_turn_rad_s)
            return eqx.tree_at(
                lambda p: (p.state.own.rate_of_turn_rad_s, p.override_rad, p.override_steps),
                premise,
                (steady, jnp.zeros(()), jnp.asarray(UNTIL_THE_END, jnp.int32)),
            )
        slot = branch.slot(self.ship)
        if not branch.is_present(slot):
            name = _name(branch, self.ship)
            raise InputError(f"{name} is not there at this instant: she has no course to keep")
        now = targets_at(premise.encounter, jnp.zeros(()))
        track = premise.encounter.targets
        never = jnp.full(track.start_s.shape[1], jnp.inf).at[0].set(0.0)
        straight = Track(
            track.start_s.at[slot].set(never),
            track.end_s.at[slot].set(jnp.inf),
            track.east_m.at[slot].set(now.east_m[slot]),
            track.north_m.at[slot].set(now.north_m[slot]),
            track.course_rad.at[slot].set(now.course_rad[slot]),
            track.speed_m_s.at[slot].set(now.speed_m_s[slot]),
        )
        return eqx.tree_at(lambda p: p.encounter.targets, premise, straight)

    def describe(self, branch: Branch) -> str:
        who = "own ship" if self.ship is None else _name(branch, self.ship)
        return f"if {who} kept her course"


@dataclasses.dataclass(frozen=True)
class Rudder:
    """Own ship's rudder is held at an angle (starboard positive); then the pilot decides again."""

    degrees: float
    seconds: float = 60.0

    def apply(self, branch: Branch, premise: BranchState) -> BranchState:
        limit = math.degrees(float(branch.ship.rudder_limit_rad))
        if not abs(self.degrees) <= limit + 1e-3:
            raise InputError(
                f"rudder {self.degrees:g}°: own ship's goes to {limit:.3g}° on either side"
            )
        if not 0 < self.seconds <= 3600:
            raise InputError(
                f"{self.seconds:g} s: a rudder is held for more than 0 s, at most 3600"
            )
        steps = max(round(self.seconds / branch.settings.step_s), 1)
        return eqx.tree_at(
            lambda p: (p.override_rad, p.override_steps),
            premise,
            (jnp.asarray(math.radians(self.degrees), jnp.float32), jnp.asarray(steps, jnp.int32)),
        )

    def describe(self, branch: Branch) -> str:
        angle = math.radians(self.degrees)
        where = "amidships" if self.degrees == 0 else f"{degrees(angle)} to {side(angle)}"
        return f"with the rudder {where} for {duration(self.seconds)}"


def masked(known: Observation, visible: jnp.ndarray) -> Observation:
    """The observation with only these ships in it."""
    present = known.present & visible
    return Observation(
        known.waypoint, jnp.where(present[:, None, None], known.targets, 0.0), present
    )


def _name(branch: Branch, ship: str) -> str:
    return branch.scenario.targets[branch.slot(ship)].name
