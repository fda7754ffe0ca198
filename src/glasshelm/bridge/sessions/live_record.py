"""The frames of live traffic: shown whether or not they can be logged, logged as soon as they can.

Nothing of it is read from disk. What was shown while the log could not be written is
kept in memory, the newest HELD_FRAMES frames or HELD_BYTES of them, and written when
it can be.
"""

import logging
from collections import deque
from collections.abc import Callable
from pathlib import Path

import msgspec

from glasshelm.bridge.server.fault_log import describe_error
from glasshelm.bridge.sessions.session_log import FrameLines
from glasshelm.core.errors import InputError
from glasshelm.frames.frame_log import FrameLog
from glasshelm.frames.schema import Frame

#: Frames kept in memory at most: an hour.
MAX_HELD_FRAMES = 720
#: Bytes of them at most: the hour of some 200 ships.
MAX_HELD_BYTES = 64_000_000
_log = logging.getLogger("glasshelm.bridge")


class LiveRecord(FrameLines):
    """The newest frames, and a log of all; ``new_path`` names a file that is not there yet.

    Where the log was removed, or never could be opened, another one is begun, with what is in
    memory. ``trouble`` says why the log cannot be written, ``lost`` counts the frames that were
    shown, and let go before they could be logged.
    """

    def __init__(self, new_path: Callable[[], Path]):
        super().__init__()
        self.trouble: str | None = None
        self.lost = 0
        self._new_path = new_path
        self._log: FrameLog | None = None
        self._encoder = msgspec.json.Encoder()
        self._held: deque[bytes] = deque()
        #: So many of the newest are not in the log.
        self._owed = 0
        self._try_to_log()

    @property
    def path(self) -> Path | None:
        return None if self._log is None else self._log.path

    def append(self, frame: Frame) -> bytes:
        """One more frame is there; why it is not logged yet is in ``trouble``."""
        line = self._encoder.encode(frame)
        self._add(frame.time_s, len(line) + 1)
        self._held.append(line)
        self._owed += 1
        self._try_to_log()
        self._let_the_oldest_go()
        return line

    def lines(self, first: int, end: int) -> list[bytes]:
        return [self._held[k - self.first] for k in range(first, end)]

    def close(self) -> None:
        if self._owed:
            self._try_to_log()
        if self._owed:
            _log.error("%s; %d frames are lost", self.trouble, self._owed)
        self._close_log()

    def _let_the_oldest_go(self) -> None:
        while len(self._held) > MAX_HELD_FRAMES or (
            len(self._held) > 1 and self._ends[-1] - self._ends[self.first] > MAX_HELD_BYTES
        ):
            self._held.popleft()
            self.first += 1
        n_lost = max(self._owed - len(self._held), 0)
        self._owed -= n_lost
        self.lost += n_lost

    def _try_to_log(self) -> None:
        try:
            if self._log is not None and self._log.gone:
                self._close_log()
                self._owed = len(self._held)
            if self._log is None:
                self._log = FrameLog(self._new_path())
            while self._owed:
                self._log.add(self._held[-self._owed])
                self._owed -= 1
        except Exception as error:
            before, self.trouble = self.trouble, _told(error)
            if before != self.trouble:
                _log.error("%s", self.trouble)
        else:
            if self.trouble is not None:
                _log.warning("the log %s is written again", self.path)
            self.trouble = None

    def _close_log(self) -> None:
        if self._log is not None:
            try:
                self._log.close()
            except InputError as error:
                _log.warning("%s", error)
        self._log = None


def _told(error: Exception) -> str:
    """Why, without the folder."""
    words = describe_error(error)
    why = words.rpartition("cannot write the log (")[2].removesuffix(")")
    return f"the log cannot be written ({why}): frames are shown without it"
