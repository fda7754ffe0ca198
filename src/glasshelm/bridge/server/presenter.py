"""Turns a session into messages: its frames, with what is shown beside them."""

import time
from datetime import UTC, datetime

import msgspec

from glasshelm.bridge.annotate.alarms import AlarmList
from glasshelm.bridge.annotate.frame_annotator import RAISING_ALARMS, FrameAnnotator
from glasshelm.bridge.server import protocol as m
from glasshelm.bridge.server.fault_log import FaultLog
from glasshelm.bridge.server.protocol import Outgoing, encode
from glasshelm.bridge.sessions.session import PredictedTrack, Session, track_points
from glasshelm.bridge.sessions.session_log import RecentLines
from glasshelm.env.observe import FRAMES
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot

#: Least and longest rest between two predictions of the track ahead (at ×60 not every frame has
#: one); between them it is so many times what the last one took.
PREDICT_REST_S, PREDICT_REST = (0.25, 5.0), 2.0
#: After a jump so many frames are read again to classify the encounters ...
REREAD_FRAMES = 240
#: ... and at most so many bytes of them.
REREAD_BYTES = 64_000_000


class Presenter:
    """Runs in the worker thread, except for :meth:`session_message` and the properties.

    Viewers who join later are served from memory, not from the log.
    """

    def __init__(self, session: Session, limits: m.AlarmLimits):
        self.session = session
        #: The frame shown, and its alarms.
        self.frame: Frame | None = None
        self.alarms: list[m.Alarm] = []
        self._fault_log = FaultLog()
        self._alarm_list = AlarmList(limits)
        self._annotator = FrameAnnotator(self._alarm_list, self._fault_log)
        self._log = session.log
        # The lines of the frame shown and of the compared pilot's, and those before them.
        self._line: bytes | None = None
        self._compared_line: bytes | None = None
        self._past, self._compared_past = RecentLines(), RecentLines()
        self._frame_message: Outgoing | None = None
        self._prediction: PredictedTrack | None = None
        self._prediction_index = 0
        self._predicted_at = -1e9
        self._prediction_took_s = 0.0

    @property
    def alarms_are_current(self) -> bool:
        return RAISING_ALARMS not in self._fault_log

    @property
    def faults(self) -> list[str]:
        """What is going wrong, a line each."""
        return [*self._fault_log.messages, *self.session.status().faults]

    @property
    def recent(self) -> tuple[Frame, ...]:
        """The frame shown and those before it that the pilot observed (Eq. 12)."""
        return self._annotator.recent(FRAMES)

    def advance(self) -> list[Outgoing] | None:
        """Show the next frame and return its messages; None if there is none (yet)."""
        frame = self.session.next_frame()
        if frame is None:
            return None
        if self.session.log is not self._log:
            return self._after_jump()  # a new log has begun
        line, compared_line = self._read_lines()
        if self._line is not None:
            self._past.append(self._line)
            self._past.trim()
        if self._compared_line is not None:
            self._compared_past.append(self._compared_line)
            self._compared_past.trim()
        return self._show(frame, line, compared_line)

    def snapshot(self) -> list[Outgoing]:
        """Return everything that a new viewer needs."""
        past, compared = (
            [msgspec.Raw(line) for line in recent.lines]
            for recent in (self._past, self._compared_past)
        )
        messages = [encode(m.History(past, compared))]
        if self._frame_message is not None:
            messages += [self._frame_message, self._alarms_message()]
        return messages

    def seek(self, time_s: float) -> list[Outgoing]:
        self.session.seek(time_s)
        return self._after_jump()

    def set_pilot(self, pilot: Pilot) -> list[Outgoing]:
        self.session.set_pilot(pilot)
        return self._after_jump()

    def compare(self, pilot: Pilot | None) -> list[Outgoing]:
        self.session.compare(pilot)
        return self._after_jump()

    def acknowledge(self, id: str) -> list[Outgoing] | None:
        """Acknowledge an alarm; None if there is no such alarm."""
        return self._update_alarms() if self._alarm_list.acknowledge(id) else None

    def set_limits(self, limits: m.AlarmLimits) -> list[Outgoing]:
        self._alarm_list.limits = limits
        return self._update_alarms()

    def session_message(self, playing: bool, rate: float, *notes: str) -> Outgoing:
        """Return the ``session`` message, with these notes before the session's own."""
        session, info, status = self.session, self.session.info, self.session.status()
        first_s, last_s = status.seekable_range_s
        message = m.SessionMessage(
            source=info.source,
            title=info.title,
            mode=info.mode,
            pilot=status.pilot,
            compare=status.compared,
            ship=info.ship,
            playing=playing,
            rate=rate,
            time_s=session.log.times[session.index] if session.index >= 0 else first_s,
            end_s=info.end_s,
            seekable_from_s=first_s,
            seekable_to_s=last_s,
            notes=list(dict.fromkeys((*notes, *self._fault_log.messages, *info.notes))),
            connected=status.connected,
            last_report_age_s=status.last_report_age_s,
            own_position_age_s=status.own_position_age_s,
            log=None if session.log.path is None else session.log.path.name,
        )
        return encode(message)

    def close(self) -> None:
        self.session.close()

    def _after_jump(self) -> list[Outgoing]:
        """Show the session's frame after the frames before it were read from the log."""
        log, index = self.session.log, self.session.index
        if index < 0:
            return self.snapshot()
        frame, lines = log.frame(index), self._read_lines()
        past = RecentLines(log.history(index))
        compared_past = RecentLines(self.session.compared_history())
        self._annotator.reset(log.history(index, REREAD_FRAMES, REREAD_BYTES))
        self._log, self._past, self._compared_past = log, past, compared_past
        self._predicted_at = -1e9
        self._show(frame, *lines)
        return self.snapshot()

    def _read_lines(self) -> tuple[bytes, bytes | None]:
        return self.session.log.line(self.session.index), self.session.compared_line()

    def _show(self, frame: Frame, line: bytes, compared_line: bytes | None) -> list[Outgoing]:
        self._line, self._compared_line = line, compared_line
        new = None
        with self._fault_log.contain("predicting the track ahead"):
            new = self._predict()
        annotations = self._annotator.annotate(frame, self._remaining_prediction())
        message = m.FrameMessage(
            frame=msgspec.Raw(line),
            encounters=annotations.encounters,
            sent_utc=datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z"),
            sentence=annotations.sentence,
            compare=None if compared_line is None else msgspec.Raw(compared_line),
            predicted_track=None if new is None else track_points(new.rows, new.step_s),
        )
        self.frame, self._frame_message = frame, encode(message)
        messages = [self._frame_message]
        if annotations.alarms != self.alarms:
            self.alarms = annotations.alarms
            messages.append(self._alarms_message())
        return messages

    def _predict(self) -> PredictedTrack | None:
        """Return the track ahead, if it is time to predict it again."""
        begun = time.monotonic()
        least_s, most_s = PREDICT_REST_S
        rest_s = max(least_s, min(PREDICT_REST * self._prediction_took_s, most_s))
        if begun - self._predicted_at < rest_s:
            return None
        self._prediction = None
        self._prediction = self.session.predicted_track()
        self._prediction_index = self.session.index
        self._predicted_at = time.monotonic()
        self._prediction_took_s = self._predicted_at - begun
        return self._prediction

    def _remaining_prediction(self) -> PredictedTrack | None:
        """Return what still lies ahead of the last prediction."""
        if self._prediction is None:
            return None
        past = self.session.index - self._prediction_index
        return PredictedTrack(self._prediction.step_s, self._prediction.rows[past:])

    def _update_alarms(self) -> list[Outgoing]:
        if self.frame is not None:
            self.alarms = self._alarm_list.update(self.frame)
        return [self._alarms_message()]

    def _alarms_message(self) -> Outgoing:
        return encode(m.Alarms(self.alarms))
