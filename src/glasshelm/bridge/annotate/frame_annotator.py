"""What is told beside the frames: sentence, rules, alarms. All of it follows from frames."""

from collections import deque
from typing import NamedTuple

import msgspec

from glasshelm.bridge.annotate.alarms import AlarmList
from glasshelm.bridge.server.fault_log import FaultLog
from glasshelm.bridge.server.protocol import Alarm, EncounterStatus, Sentence
from glasshelm.bridge.sessions.session import PredictedTrack
from glasshelm.colregs.encounter_tracker import EncounterTracker
from glasshelm.frames.schema import Frame
from glasshelm.report.current_sentence import FRAMES, now

#: The part that raises alarms: where it fails, nothing may be written back.
RAISING_ALARMS = "raising alarms"


class Annotations(NamedTuple):
    """What is told beside one frame."""

    sentence: Sentence | None
    encounters: dict[str, EncounterStatus]
    alarms: list[Alarm]


class FrameAnnotator:
    """Sees the frames of a session in order; :meth:`again` after a jump in time.

    What fails is in ``faults`` and left out; alarms wait for nothing else.
    """

    def __init__(self, alarms: AlarmList, faults: FaultLog | None = None):
        self.alarms, self.faults = alarms, faults or FaultLog()
        self._listed: list[Alarm] = []
        self._recent: deque[Frame] = deque(maxlen=FRAMES)
        self._rules = EncounterTracker()

    def reset(self, before: list[bytes]) -> None:
        """Begin anew, after these frames (as they stand in a log)."""
        self._recent.clear()
        self._rules = EncounterTracker()
        decoder = msgspec.json.Decoder(Frame)
        for line in before:
            frame = decoder.decode(line)
            self._recent.append(frame)
            self._rules.see(frame)

    def recent(self, count: int) -> tuple[Frame, ...]:
        """The last frames seen, as far as there are so many."""
        return tuple(self._recent)[-count:]

    def annotate(self, frame: Frame, ahead: PredictedTrack | None) -> Annotations:
        """What is to be told of the next frame."""
        self._recent.append(frame)
        with self.faults.contain(RAISING_ALARMS):
            self._listed = self.alarms.update(frame)
        meetings: dict[str, EncounterStatus] = {}
        with self.faults.contain("telling the rules"):
            meetings = self._rules.see(frame)
        sentence = None
        with self.faults.contain("telling the sentence"):
            sentence = self._sentence(ahead)
        return Annotations(sentence, meetings, self._listed)

    def _sentence(self, ahead: PredictedTrack | None) -> Sentence | None:
        rows, step_s = (None, 5.0) if ahead is None else (ahead.rows, ahead.step_s)
        told = now(tuple(self._recent), rows, step_s, self._rules.kinds)
        return None if told is None else Sentence(told.what, told.why, told.next)
