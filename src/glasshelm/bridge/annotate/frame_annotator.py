"""What is shown with a frame: sentence, COLREGs roles and alarms, all computed from frames."""

from collections import deque
from typing import NamedTuple

import msgspec

from glasshelm.bridge.annotate.alarms import AlarmList
from glasshelm.bridge.server.fault_log import FaultLog
from glasshelm.bridge.server.protocol import Alarm, EncounterStatus, Sentence
from glasshelm.bridge.sessions.session import PredictedTrack
from glasshelm.colregs.encounter_tracker import EncounterTracker
from glasshelm.colregs.rule_text import ROLES
from glasshelm.frames.schema import Frame
from glasshelm.report.current_sentence import LOOK_BACK_FRAMES, current_sentence

#: The part that raises alarms: where it fails, nothing may be written back.
RAISING_ALARMS = "raising alarms"


class Annotations(NamedTuple):
    """What is shown with one frame."""

    sentence: Sentence | None
    encounters: dict[str, EncounterStatus]
    alarms: list[Alarm]


class FrameAnnotator:
    """Annotates the frames of a session in order; call :meth:`reset` after a jump in time.

    A part that fails is recorded in ``faults`` and left out; the alarms depend on no other part.
    """

    def __init__(self, alarms: AlarmList, faults: FaultLog):
        self._alarms, self._faults = alarms, faults
        self._last_alarms: list[Alarm] = []
        self._recent: deque[Frame] = deque(maxlen=LOOK_BACK_FRAMES)
        self._encounters = EncounterTracker()

    def reset(self, lines: list[bytes]) -> None:
        """Start again after these frames, given as lines of a log."""
        self._recent.clear()
        self._encounters = EncounterTracker()
        decoder = msgspec.json.Decoder(Frame)
        for line in lines:
            frame = decoder.decode(line)
            self._recent.append(frame)
            self._encounters.update(frame)

    def recent(self, count: int) -> tuple[Frame, ...]:
        """Return the last ``count`` frames, or fewer if there are fewer."""
        return tuple(self._recent)[-count:]

    def annotate(self, frame: Frame, ahead: PredictedTrack | None) -> Annotations:
        """Annotate the next frame, given the predicted track from it on."""
        self._recent.append(frame)
        with self._faults.contain(RAISING_ALARMS):
            self._last_alarms = self._alarms.update(frame)
        encounters: dict[str, EncounterStatus] = {}
        with self._faults.contain("classifying encounters"):
            types = self._encounters.update(frame)
            encounters = {id: EncounterStatus(*ROLES[type]) for id, type in types.items()}
        sentence = None
        with self._faults.contain("writing the sentence"):
            sentence = self._sentence(ahead)
        return Annotations(sentence, encounters, self._last_alarms)

    def _sentence(self, ahead: PredictedTrack | None) -> Sentence | None:
        rows, step_s = (None, 5.0) if ahead is None else (ahead.rows, ahead.step_s)
        current = current_sentence(tuple(self._recent), rows, step_s, self._encounters.types)
        return None if current is None else Sentence(current.what, current.why, current.next)
