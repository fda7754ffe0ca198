"""A future: the common world sailed on from a branch by its pilot, step by step."""

import dataclasses
from collections.abc import Sequence

import equinox as eqx
import jax
import msgspec
import numpy as np
from jaxtyping import Array, Bool, Float

from glasshelm.ais.limits import LOST_SHOWN_S
from glasshelm.env.rewards import Reward
from glasshelm.env.step import EnvSettings, step
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Decision, Pilot
from glasshelm.ship.nomoto import ShipParams
from glasshelm.simulation.explained_step import ExplainedStep, RudderOverride, explain_step
from glasshelm.simulation.frame_builder import FrameBuilder
from glasshelm.whatif.branch import Branch, BranchState
from glasshelm.whatif.changes import Change, masked

Row = Float[np.ndarray, " t"]


@dataclasses.dataclass(frozen=True, eq=False)
class BranchRollout:
    """What follows from a branch, one instant a step, the first at the branch.

    ``steps`` and ``reward`` (of the step after each instant) are on the host,
    stacked over time. A future ends early where the last waypoint that the log
    names is reached. ``condition`` says what is changed, "" for nothing.
    """

    branch: Branch
    condition: str
    steps: ExplainedStep
    reward: Reward

    def __len__(self) -> int:
        return len(self.steps.decision.rudder)

    @property
    def time_s(self) -> Row:
        """The times of the instants, by the clock of the log."""
        return self.branch.start.time_s + self.branch.settings.step_s * np.arange(len(self))

    @property
    def heading_rad(self) -> Row:
        """Own ship's heading, running on through ±π."""
        return np.unwrap(np.asarray(self.steps.own.heading_rad, float))

    @property
    def rudder_rad(self) -> Row:
        """The rudder decided or ordered at each instant."""
        limit = float(self.branch.ship.rudder_limit_rad)
        return np.asarray(self.steps.decision.rudder, float) * limit

    @property
    def track_m(self) -> Float[np.ndarray, "t 2"]:
        """Own ship's places (east, north)."""
        own = self.steps.own
        return np.stack([own.east_m, own.north_m], axis=-1).astype(float)

    def frames(self) -> list[Frame]:
        """The frames of this future, as a voyage gives them."""
        branch, step_s = self.branch, self.branch.settings.step_s
        words = f", {self.condition}" if self.condition else ", sailed on"
        source = f"{branch.start.source}{words} from {branch.start.time_s:g} s"
        scenario = dataclasses.replace(branch.scenario, source=source)
        framer = FrameBuilder(scenario, branch.pilot, applied=True)
        frames, reward = [], None
        for k in range(len(self)):
            moment = jax.tree.map(lambda x, k=k: x[k], self.steps)
            frames.append(framer.frame(moment, branch.start.time_s + k * step_s, reward))
            reward = jax.tree.map(lambda x, k=k: x[k], self.reward)
        frames[0] = msgspec.structs.replace(frames[0], reward=branch.start.reward)
        return frames


def roll_out(
    branch: Branch, changes: Sequence[Change] = (), steps: int = 360, explained: bool = False
) -> BranchRollout:
    """The future of so many steps with these changes, all at once; without any, as things are.

    ``explained`` frames carry the pilot's reasons, and take a program of their own.
    One program is compiled for each pilot, number of steps and number of slots.
    """
    premise = branch.initial
    for change in changes:
        premise = change.apply(branch, premise)
    told = jax.device_get(
        _scan(branch.pilot, premise, branch.ship, branch.settings, LOST_SHOWN_S, steps, explained)
    )
    ended = np.flatnonzero(told.ended)
    count = min(int(ended[0]) + 2, steps + 1) if ended.size else steps + 1
    moments, reward = jax.tree.map(lambda x: x[:count], (told.moment, told.reward))
    condition = " and ".join(change.describe(branch) for change in changes)
    return BranchRollout(branch, condition, moments, reward)


class _Steps(eqx.Module):
    moment: ExplainedStep
    reward: Reward
    ended: Bool[Array, " *t"]


@eqx.filter_jit
def _scan(
    pilot: Pilot,
    premise: BranchState,
    ship: ShipParams,
    settings: EnvSettings,
    lost_shown_s: float,
    steps: int,
    explained: bool,
) -> _Steps:
    """So many steps and the instants between them [steps + 1]."""
    encounter = premise.encounter

    def tick(carry: tuple, _: None) -> tuple[tuple, _Steps]:
        state, held, memory = carry
        order = RudderOverride(
            premise.override_rad / ship.rudder_limit_rad, state.step < premise.override_steps
        )
        moment, held, memory = explain_step(
            pilot, encounter, state, held, memory, ship, settings, lost_shown_s, order
        )
        if not explained:  # neither computed nor kept
            bare = Decision(moment.decision.rudder, overruled=moment.decision.overruled)
            moment = dataclasses.replace(moment, decision=bare)
        outcome = step(
            encounter, state, moment.decision.rudder * ship.rudder_limit_rad, ship, settings
        )
        known = masked(outcome.state.observation, premise.visible)
        after = eqx.tree_at(lambda s: s.observation, outcome.state, known)
        return (after, held, memory), _Steps(moment, outcome.reward, outcome.terminated)

    begin = premise.state, premise.last_known, premise.memory
    return jax.lax.scan(tick, begin, length=steps + 1)[1]
