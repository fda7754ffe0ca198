"""A question and its answer: two futures of one branch, and what the change makes of them."""

import dataclasses
from collections.abc import Sequence

from glasshelm.core.errors import InputError
from glasshelm.env.step import EnvSettings
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot, check_pilot
from glasshelm.whatif.branch import branch_at
from glasshelm.whatif.changes import Change
from glasshelm.whatif.counterfactual_rollout import BranchRollout, roll_out
from glasshelm.whatif.difference_text import describe_difference
from glasshelm.whatif.outcome import Differences, Outcome, differences, outcome_of

#: How far ahead is simulated [min], and at most.
MINUTES = 30.0
MOST_MINUTES = 240.0


@dataclasses.dataclass(frozen=True, eq=False)
class WhatIfAnswer:
    """The future as things are (``factual``) and with the changes (``counterfactual``).

    Both are simulated with the same pilot, and the simulation is deterministic: what differs,
    differs because of the changes alone.
    """

    factual: BranchRollout
    counterfactual: BranchRollout
    factual_outcome: Outcome
    counterfactual_outcome: Outcome
    differences: Differences
    summary: str


def what_if(
    frames: Sequence[Frame],
    number: int,
    pilot: Pilot,
    changes: Sequence[Change],
    minutes: float = MINUTES,
    explained: bool = False,
    settings: EnvSettings = EnvSettings(),
) -> WhatIfAnswer:
    """Branch a log at a frame, and simulate on with and without the changes.

    Args:
        frames: The log.
        number: The frame at which it branches.
        pilot: What steers from there on.
        changes: What is different from there on, all at once.
        minutes: How far to simulate.
        explained: Whether the frames of the branches carry explanations.
        settings: Of the decision process.

    Returns:
        Both futures, and the difference in numbers and in a sentence.

    Raises:
        InputError: There is no such frame, no change, or a change that is not possible.
    """
    if not changes:
        raise InputError("nothing is asked: name a ship to delete, to hide or to keep, or a rudder")
    check_pilot(pilot)
    wrong = next((c for c in changes if not isinstance(c, Change)), None)
    if wrong is not None:
        raise InputError(f"{wrong!r} is no change: glasshelm.Deleted(ship), for example, is one")
    if not 0 < minutes <= MOST_MINUTES:
        raise InputError(f"{minutes:g} minutes: more than 0, at most {MOST_MINUTES:g}")
    steps = max(round(60 * minutes / settings.step_s), 1)
    branch = branch_at(frames, number, pilot, steps, settings)
    fact = roll_out(branch, (), steps, explained)
    other = roll_out(branch, changes, steps, explained)
    told = outcome_of(fact), outcome_of(other)
    parted = differences(fact, other)
    words = describe_difference(other.condition, changes, *told, parted)
    return WhatIfAnswer(fact, other, *told, parted, words)
