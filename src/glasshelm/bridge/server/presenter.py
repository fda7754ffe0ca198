"""A session as its viewers get it: its frames as messages, with what is told beside them."""

import time
from datetime import UTC, datetime

import msgspec

from glasshelm.bridge.annotate.alarms import AlarmList
from glasshelm.bridge.annotate.frame_annotator import RAISING_ALARMS, FrameAnnotator
from glasshelm.bridge.server import protocol as m
from glasshelm.bridge.server.fault_log import FaultLog
from glasshelm.bridge.sessions.session import PredictedTrack, Session
from glasshelm.bridge.sessions.session_log import Past
from glasshelm.env.observe import FRAMES
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot

#: A message and its kind.
Told = tuple[str, bytes]
#: The track ahead is predicted no oftener than this (at ×60 not for every frame).
PREDICT_EVERY_S = 0.25
#: One point of the predicted track so often.
POINT_S = 30.0
#: So many frames before a jump are seen again, for the rules' meetings.
SEEN_AGAIN = 240
#: And so many bytes of them at most.
SEEN_AGAIN_BYTES = 64_000_000


class Presenter:
    """Runs in the worker thread, except for what only reads: ``session_now``, properties.

    Who looks on later is told of memory: what was shown last, and what a page is sent of before.
    """

    def __init__(self, session: Session, limits: m.SetLimits):
        self.session = session
        self._faults = FaultLog()
        self._alarms = AlarmList(limits)
        self._lookout = FrameAnnotator(self._alarms, self._faults)
        #: The frame shown and that of the compared pilot, as they stand in their logs, and those
        #: before them.
        self._line: bytes | None = None
        self._line_beside: bytes | None = None
        self._past, self._past_beside = Past(), Past()
        self._record = session.log
        self._frame: Frame | None = None
        self._told: bytes | None = None
        self._listed: list[m.Alarm] = []
        self._ahead: PredictedTrack | None = None
        self._ahead_of = 0
        self._predicted_at = -1e9

    @property
    def frame(self) -> Frame | None:
        """The frame shown."""
        return self._frame

    @property
    def alarms_are_current(self) -> bool:
        """Whether its alarms are of the frame shown."""
        return RAISING_ALARMS not in self._faults

    @property
    def faults(self) -> list[str]:
        """What goes wrong now, one line each."""
        return [*self._faults.messages, *self.session.faults]

    @property
    def recent(self) -> tuple[Frame, ...]:
        """The frame shown and those before it that the pilot saw (Eq. 12)."""
        return self._lookout.recent(FRAMES)

    @property
    def alarms(self) -> list[m.Alarm]:
        """The alarms of the frame shown."""
        return self._listed

    def advance(self) -> list[Told] | None:
        """The messages of the next frame; None where there is none (yet)."""
        frame = self.session.next_frame()
        if frame is None:
            return None
        record = self.session.log
        if record is not self._record:
            return self._after_jump()  # a new log has begun
        if self._line is not None:
            self._past.add(self._line)
        if self._line_beside is not None:
            self._past_beside.add(self._line_beside)
        self._line, self._line_beside = (
            record.line(self.session.index),
            self.session.compared_line(),
        )
        return self._tell(frame)

    def snapshot(self) -> list[Told]:
        """Everything that a viewer needs who knows nothing yet."""
        history = m.History(_raw(self._past.lines), _raw(self._past_beside.lines))
        told = [("history", m.encode(history))]
        if self._told is not None:
            told += [("frame", self._told), self._alarm_list()]
        return told

    def seek(self, time_s: float) -> list[Told]:
        self.session.seek(time_s)
        return self._after_jump()

    def set_pilot(self, pilot: Pilot) -> list[Told]:
        self.session.set_pilot(pilot)
        return self._after_jump()

    def compare(self, pilot: Pilot | None) -> list[Told]:
        self.session.compare(pilot)
        return self._after_jump()

    def acknowledge(self, id: str) -> list[Told] | None:
        """None if there is no such alarm."""
        return self._alarms_again() if self._alarms.acknowledge(id) else None

    def set_limits(self, limits: m.SetLimits) -> list[Told]:
        self._alarms.limits = limits
        return self._alarms_again()

    def session_message(self, playing: bool, rate: float, *notes: str) -> bytes:
        """The ``session`` message, with these notes before the session's own."""
        session, card = self.session, self.session.info
        first, last = session.seekable_range_s
        now = m.SessionMessage(
            source=card.source,
            title=card.title,
            mode=card.mode,
            pilot=session.pilot_name,
            compare=session.compared_name,
            ship=card.ship,
            playing=playing,
            rate=rate,
            time_s=session.log.times[session.index] if session.index >= 0 else first,
            end_s=card.end_s,
            seekable_from_s=first,
            seekable_to_s=last,
            notes=list(dict.fromkeys((*notes, *self._faults.messages, *card.notes))),
            connected=session.connected,
            heard_s=session.last_report_age_s,
            own_s=session.own_position_age_s,
            log=None if session.log.path is None else session.log.path.name,
        )
        return m.encode(now)

    def close(self) -> None:
        self.session.close()

    def _after_jump(self) -> list[Told]:
        record, at = self.session.log, self.session.index
        beside = self.session.compared_history()
        if at < 0:
            return self.snapshot()
        before, line, line_beside = (
            record.history(at),
            record.line(at),
            self.session.compared_line(),
        )
        self._past.fill(before)
        self._past_beside.fill(beside)
        self._record, self._line, self._line_beside = record, line, line_beside
        self._lookout.reset(record.history(at, SEEN_AGAIN, SEEN_AGAIN_BYTES))
        self._predicted_at = -1e9
        self._tell(record.frame(at))
        return self.snapshot()

    def _tell(self, frame: Frame) -> list[Told]:
        assert self._line is not None
        fresh = None
        with self._faults.contain("predicting the track ahead"):
            fresh = self._predict()
        beside = self._lookout.annotate(frame, self._left())
        compared = self._line_beside
        message = m.FrameMessage(
            frame=msgspec.Raw(self._line),
            encounters=beside.encounters,
            sent_utc=datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z"),
            sentence=beside.sentence,
            compare=None if compared is None else msgspec.Raw(compared),
            path=None if fresh is None else _points(fresh),
        )
        self._frame, self._told = frame, m.encode(message)
        told = [("frame", self._told)]
        if beside.alarms != self._listed:
            self._listed = beside.alarms
            told.append(self._alarm_list())
        return told

    def _predict(self) -> PredictedTrack | None:
        """The track ahead, where it is time to predict it again."""
        if time.monotonic() - self._predicted_at < PREDICT_EVERY_S:
            return None
        self._ahead = None
        self._ahead, self._ahead_of = self.session.predicted_track(), self.session.index
        self._predicted_at = time.monotonic()
        return self._ahead

    def _left(self) -> PredictedTrack | None:
        """What of the last prediction still lies ahead."""
        if self._ahead is None:
            return None
        return PredictedTrack(
            self._ahead.step_s, self._ahead.rows[self.session.index - self._ahead_of :]
        )

    def _alarms_again(self) -> list[Told]:
        if self._frame is not None:
            self._listed = self._alarms.update(self._frame)
        return [self._alarm_list()]

    def _alarm_list(self) -> Told:
        return "alarms", m.encode(m.Alarms(self._listed))


def _raw(lines: list[bytes]) -> list[msgspec.Raw]:
    return [msgspec.Raw(line) for line in lines]


def _points(ahead: PredictedTrack) -> list[list[float]]:
    every = max(round(POINT_S / ahead.step_s), 1)
    return ahead.rows[::every, :2].astype(float).round(1).tolist()
