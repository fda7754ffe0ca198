"""What is told beside the frames: sentence, rules, alarms. All of it follows from frames."""

from collections import deque
from typing import NamedTuple

import msgspec

from glasshelm.bridge.alarms import AlarmList
from glasshelm.bridge.messages import Alarm, Meeting, Sentence
from glasshelm.bridge.rules import Rules
from glasshelm.bridge.session import Predicted
from glasshelm.frames import Frame
from glasshelm.report.now import FRAMES, now


class Beside(NamedTuple):
    """What is told beside one frame."""

    sentence: Sentence | None
    encounters: dict[str, Meeting]
    alarms: list[Alarm]


class Lookout:
    """Sees the frames of a session in order; :meth:`again` after a jump in time."""

    def __init__(self, alarms: AlarmList):
        self.alarms = alarms
        self._recent: deque[Frame] = deque(maxlen=FRAMES)
        self._rules = Rules()

    def again(self, before: list[bytes]) -> None:
        """Begin anew, after these frames (as they stand in a log)."""
        self._recent.clear()
        self._rules = Rules()
        decoder = msgspec.json.Decoder(Frame)
        for line in before:
            frame = decoder.decode(line)
            self._recent.append(frame)
            self._rules.see(frame)

    def recent(self, count: int) -> tuple[Frame, ...]:
        """The last frames seen, as far as there are so many."""
        return tuple(self._recent)[-count:]

    def see(self, frame: Frame, ahead: Predicted | None) -> Beside:
        """What is to be told of the next frame."""
        self._recent.append(frame)
        rows, step_s = (None, 5.0) if ahead is None else (ahead.rows, ahead.step_s)
        meetings = self._rules.see(frame)
        told = now(tuple(self._recent), rows, step_s, self._rules.kinds)
        sentence = None if told is None else Sentence(told.what, told.why, told.next)
        return Beside(sentence, meetings, self.alarms.see(frame))
