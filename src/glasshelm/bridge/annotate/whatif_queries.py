"""What-if questions of a viewer: branch the frame shown, and simulate both futures."""

import dataclasses
from collections.abc import Callable

import msgspec

from glasshelm.bridge.server.protocol import AskWhatIf, WhatIfMessage
from glasshelm.bridge.sessions.session import Session, track_points
from glasshelm.core.errors import InputError
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot
from glasshelm.whatif.ask import MINUTES, what_if
from glasshelm.whatif.changes import Change, Deleted, Hidden, KeptCourse, Rudder
from glasshelm.whatif.counterfactual_rollout import BranchRollout
from glasshelm.whatif.logged_world import pilot_of

#: Frames before the one shown that rebuild a pilot's memory (20 minutes); networks need 4.
FRAMES_BEFORE = 240
#: The first of them has a multiple of this number: a pilot that decides every 2nd, 3rd, … 6th or
#: 12th frame then decides at the same frames as in the voyage.
FIRST_MULTIPLE = 60
#: Frames after it at most, where the log goes on.
FRAMES_AFTER = 360


@dataclasses.dataclass(frozen=True)
class WhatIfQuery:
    """Everything an answer needs, copied from the session while nobody else uses it."""

    request: AskWhatIf
    frames: list[Frame]
    number: int
    pilot: Pilot

    @staticmethod
    def from_request(
        request: AskWhatIf, session: Session, pilot_named: Callable[[str], Pilot]
    ) -> "WhatIfQuery":
        """A question about the frame shown, for the pilot that made that frame."""
        index, log = session.index, session.log
        if index < 0:
            raise InputError("nothing is shown yet")
        first = max(index - FRAMES_BEFORE, 0)
        first = max(first - first % FIRST_MULTIPLE, log.first)
        decode = msgspec.json.Decoder(Frame).decode
        lines = log.lines(first, min(index + 1 + FRAMES_AFTER, len(log)))
        frames, number = [decode(line) for line in lines], index - first
        return WhatIfQuery(request, frames, number, pilot_of(frames[number], pilot_named))


def answer(query: WhatIfQuery) -> WhatIfMessage:
    """Simulate both futures for half an hour. InputError for what this frame does not allow."""
    request = query.request
    change = _change(request)
    result = what_if(query.frames, query.number, query.pilot, [change], MINUTES)
    return WhatIfMessage(
        time_s=query.frames[query.number].time_s,
        change=request.change,
        ship=request.ship,
        condition=result.counterfactual.condition,
        summary=result.summary,
        factual=_points(result.factual),
        counterfactual=_points(result.counterfactual),
    )


def _change(request: AskWhatIf) -> Change:
    if request.change == "rudder":
        if request.rudder_deg is None:
            raise InputError("give rudder_deg, a rudder in degrees")
        return Rudder(float(request.rudder_deg))
    if request.change == "keep_course":
        return KeptCourse(request.ship)
    if request.ship is None:
        raise InputError("which ship? give its id")
    return (Deleted if request.change == "delete" else Hidden)(request.ship)


def _points(future: BranchRollout) -> list[list[float]]:
    return track_points(future.track_m, future.branch.settings.step_s)
