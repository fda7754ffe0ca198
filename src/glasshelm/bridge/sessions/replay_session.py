"""A session that shows a log again."""

from glasshelm.bridge.sessions.session import PredictedTrack, Session, SessionInfo
from glasshelm.bridge.sessions.session_log import SessionLog
from glasshelm.core.errors import InputError
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot

_STEP_S = 5.0
_LONGEST_STEP_S = 30.0


class ReplaySession(Session):
    """The frames of a log, as they were: nothing is decided again."""

    def __init__(self, record: SessionLog):
        first = record.frame(0)
        self._record, self.index = record, -1
        self._pilot = first.pilot
        title = f"Log {record.path.name}: {first.source}"
        ship = f"{first.ship.loa_m:.0f} m"
        self.info = SessionInfo(
            first.source, title, "replay", ship, record.times[-1], _notes(first)
        )

    @property
    def log(self) -> SessionLog:
        return self._record

    @property
    def pilot_name(self) -> str:
        return self._pilot

    @property
    def compared_name(self) -> None:
        return None

    @property
    def seekable_range_s(self) -> tuple[float, float]:
        return self.log.times[0], self.log.times[-1]

    @property
    def step_s(self) -> float:
        """As the frames are apart, but never so far that a gap looks like an end."""
        times, at = self.log.times, self.index
        if not 0 <= at < len(times) - 1:
            return _STEP_S
        return min(times[at + 1] - times[at], _LONGEST_STEP_S)

    def next_frame(self) -> Frame | None:
        if self.index + 1 >= len(self.log):
            return None
        return self._shown(self.index + 1)

    def seek(self, time_s: float) -> None:
        self._shown(self.log.index_at(time_s))

    def set_pilot(self, pilot: Pilot) -> None:
        raise InputError("a log is shown as it was: open its source to try another pilot")

    def compare(self, pilot: Pilot | None) -> None:
        if pilot is not None:
            raise InputError("a log is shown as it was: open its source to compare pilots")

    def compared_history(self) -> list[bytes]:
        return []

    def compared_line(self) -> None:
        return None

    def predicted_track(self) -> PredictedTrack | None:
        return None

    def close(self) -> None:
        self.log.close()

    def _shown(self, number: int) -> Frame:
        frame = self.log.frame(number)
        self.index, self._pilot = number, frame.pilot
        return frame


def _notes(first: Frame) -> tuple[str, ...]:
    if first.weights_sha256 is None:
        return ()
    return (f"pilot's weights: SHA-256 {first.weights_sha256}",)
