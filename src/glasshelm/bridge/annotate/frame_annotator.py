"""What accompanies the frames: sentence, rules, alarms. All of it follows from frames."""

from collections import deque
from typing import NamedTuple

import msgspec

from glasshelm.bridge.annotate.alarms import AlarmList
from glasshelm.bridge.server.fault_log import Faults
from glasshelm.bridge.server.protocol import Alarm, Meeting, Sentence
from glasshelm.bridge.sessions.session import Predicted
from glasshelm.colregs.encounter_tracker import EncounterTracker
from glasshelm.colregs.rule_text import ROLES
from glasshelm.frames.schema import Frame
from glasshelm.report.current_sentence import LOOK_BACK_FRAMES, current_sentence

#: The part that raises alarms: where it fails, nothing may be written back.
ALARMS = "raising alarms"


class Beside(NamedTuple):
    """What accompanies one frame."""

    sentence: Sentence | None
    encounters: dict[str, Meeting]
    alarms: list[Alarm]


class Lookout:
    """Sees the frames of a session in order; :meth:`again` after a jump in time.

    What fails is in ``faults`` and left out; alarms wait for nothing else.
    """

    def __init__(self, alarms: AlarmList, faults: Faults | None = None):
        self.alarms, self.faults = alarms, faults or Faults()
        self._listed: list[Alarm] = []
        self._recent: deque[Frame] = deque(maxlen=LOOK_BACK_FRAMES)
        self._rules = EncounterTracker()

    def again(self, before: list[bytes]) -> None:
        """Begin anew, after these frames (as they stand in a log)."""
        self._recent.clear()
        self._rules = EncounterTracker()
        decoder = msgspec.json.Decoder(Frame)
        for line in before:
            frame = decoder.decode(line)
            self._recent.append(frame)
            self._rules.update(frame)

    def recent(self, count: int) -> tuple[Frame, ...]:
        """The last frames seen, as far as there are so many."""
        return tuple(self._recent)[-count:]

    def see(self, frame: Frame, ahead: Predicted | None) -> Beside:
        """What accompanies the next frame."""
        self._recent.append(frame)
        with self.faults.contained(ALARMS):
            self._listed = self.alarms.see(frame)
        meetings: dict[str, Meeting] = {}
        with self.faults.contained("telling the rules"):
            types = self._rules.update(frame)
            meetings = {id: Meeting(*ROLES[type]) for id, type in types.items()}
        sentence = None
        with self.faults.contained("telling the sentence"):
            sentence = self._sentence(ahead)
        return Beside(sentence, meetings, self._listed)

    def _sentence(self, ahead: Predicted | None) -> Sentence | None:
        rows, step_s = (None, 5.0) if ahead is None else (ahead.rows, ahead.step_s)
        told = current_sentence(tuple(self._recent), rows, step_s, self._rules.types)
        return None if told is None else Sentence(told.what, told.why, told.next)
