"""A question and its answer: two futures of one branch, and what the change makes of them."""

import dataclasses
from collections.abc import Sequence

from glasshelm.core.errors import InputError
from glasshelm.env.step import EnvSettings
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot
from glasshelm.whatif.branch import branch_at
from glasshelm.whatif.changes import Change
from glasshelm.whatif.counterfactual_rollout import Future, future
from glasshelm.whatif.difference_text import sentence
from glasshelm.whatif.outcome import Account, Differences, account, differences

#: How far ahead is sailed [min], and at most.
MINUTES = 30.0
MOST_MINUTES = 240.0


@dataclasses.dataclass(frozen=True, eq=False)
class Answer:
    """The future as things are (``fact``) and with the changes (``other``), and their difference.

    Both are sailed by the same pilot in the same world, which has no chance in
    it: what differs, differs because of the changes alone.
    """

    fact: Future
    other: Future
    fact_account: Account
    other_account: Account
    parted: Differences
    sentence: str


def what_if(
    frames: Sequence[Frame],
    number: int,
    pilot: Pilot,
    changes: Sequence[Change],
    minutes: float = MINUTES,
    explained: bool = False,
    settings: EnvSettings = EnvSettings(),
) -> Answer:
    """Branch a log at a frame and sail both futures. InputError for what cannot be asked."""
    if not changes:
        raise InputError("nothing is asked: name a ship to delete, to hide or to keep, or a rudder")
    if not 0 < minutes <= MOST_MINUTES:
        raise InputError(f"{minutes:g} minutes: more than 0, at most {MOST_MINUTES:g}")
    steps = max(round(60 * minutes / settings.step_s), 1)
    branch = branch_at(frames, number, pilot, steps, settings)
    fact = future(branch, (), steps, explained)
    other = future(branch, changes, steps, explained)
    told = account(fact), account(other)
    parted = differences(fact, other)
    words = sentence(other.condition, changes, *told, parted)
    return Answer(fact, other, *told, parted, words)
