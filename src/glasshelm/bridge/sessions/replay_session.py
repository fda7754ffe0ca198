"""A session that replays a log."""

from glasshelm.bridge.sessions.session import Session, SessionInfo, SessionStatus
from glasshelm.bridge.sessions.session_log import FileLog
from glasshelm.core.errors import InputError
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot

_DEFAULT_STEP_S = 5.0
_MAX_STEP_S = 30.0


class ReplaySession(Session):
    """The frames of a log as they were: nothing is decided again."""

    def __init__(self, log: FileLog):
        first = log.frame(0)
        self._log, self.index = log, -1
        self._pilot = first.pilot
        weights = first.weights_sha256
        self.info = SessionInfo(
            source=first.source,
            title=f"Log {log.path.name}: {first.source}",
            mode="replay",
            ship=f"{first.ship.loa_m:.0f} m",
            end_s=log.times[-1],
            notes=() if weights is None else (f"pilot's weights: SHA-256 {weights}",),
        )

    @property
    def log(self) -> FileLog:
        return self._log

    @property
    def step_s(self) -> float:
        """The time to the next frame, but never so long that a gap looks like the end."""
        times, index = self.log.times, self.index
        if not 0 <= index < len(times) - 1:
            return _DEFAULT_STEP_S
        return min(times[index + 1] - times[index], _MAX_STEP_S)

    def status(self) -> SessionStatus:
        return SessionStatus(self._pilot, None, (self.log.times[0], self.log.times[-1]))

    def next_frame(self) -> Frame | None:
        return None if self.index + 1 >= len(self.log) else self._show(self.index + 1)

    def seek(self, time_s: float) -> None:
        self._show(self.log.index_at(time_s))

    def set_pilot(self, pilot: Pilot) -> None:
        raise InputError("a log is shown as it was: open its source to try another pilot")

    def compare(self, pilot: Pilot | None) -> None:
        if pilot is not None:
            raise InputError("a log is shown as it was: open its source to compare pilots")

    def _show(self, number: int) -> Frame:
        frame = self.log.frame(number)
        self.index, self._pilot = number, frame.pilot
        return frame
