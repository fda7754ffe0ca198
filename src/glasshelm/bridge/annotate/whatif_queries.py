"""What-if questions of a viewer: the frame shown is branched, both futures are told."""

import dataclasses
from collections.abc import Callable

import msgspec

from glasshelm.bridge.server import protocol as m
from glasshelm.bridge.sessions.session import Session
from glasshelm.core.errors import InputError
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot
from glasshelm.whatif.ask import MINUTES, what_if
from glasshelm.whatif.changes import Change, Deleted, Hidden, KeptCourse, Rudder
from glasshelm.whatif.counterfactual_rollout import Future
from glasshelm.whatif.logged_world import pilot_of

#: Frames before the one shown that a pilot's memory is rebuilt from (20 minutes); networks need 4.
BEFORE = 240
#: A memory is begun at a multiple of so many frames: whoever looks every 2nd, 3rd, … 6th or 12th
#: decision looks again at the same frames as in the voyage.
PHASE = 60
#: Frames after it at most, where the log goes on.
AFTER = 360
#: One point of a track so often.
POINT_S = 30.0


@dataclasses.dataclass(frozen=True)
class WhatIfQuery:
    """Everything that an answer needs, taken from the session while nobody else uses it."""

    asked: m.AskWhatIf
    frames: list[Frame]
    number: int
    pilot: Pilot

    @staticmethod
    def from_request(
        asked: m.AskWhatIf, session: Session, named: Callable[[str], Pilot]
    ) -> "WhatIfQuery":
        """The question about the frame shown; its pilot is the one who made that frame."""
        at, record = session.index, session.log
        if at < 0:
            raise InputError("nothing is shown yet")
        first, end = max(at - BEFORE, 0), min(at + 1 + AFTER, len(record))
        first = max(first - first % PHASE, record.first)
        decode = msgspec.json.Decoder(Frame).decode
        frames = [decode(line) for line in record.lines(first, end)]
        number = at - first
        return WhatIfQuery(asked, frames, number, pilot_of(frames[number], named))


def answer(question: WhatIfQuery) -> m.WhatIfMessage:
    """Sail both futures for half an hour. InputError for what cannot be asked of this frame."""
    asked = question.asked
    change = _change(asked)
    told = what_if(question.frames, question.number, question.pilot, [change], MINUTES)
    return m.WhatIfMessage(
        time_s=question.frames[question.number].time_s,
        change=asked.change,
        ship=asked.ship,
        condition=told.other.condition,
        sentence=told.sentence,
        fact=_points(told.fact),
        other=_points(told.other),
    )


def _change(asked: m.AskWhatIf) -> Change:
    if asked.change == "rudder":
        if asked.degrees is None:
            raise InputError("a rudder in degrees is asked for")
        return Rudder(float(asked.degrees))
    if asked.change == "kept":
        return KeptCourse(asked.ship)
    if asked.ship is None:
        raise InputError("which ship? name her by her id")
    return (Deleted if asked.change == "deleted" else Hidden)(asked.ship)


def _points(future: Future) -> list[list[float]]:
    every = max(round(POINT_S / future.branch.settings.step_s), 1)
    return future.track_m[::every].round(1).tolist()
