"""The log of live traffic: frames are shown whether or not they can be written.

Nothing is read from disk. While the log cannot be written the newest MAX_HELD_FRAMES frames, of
MAX_HELD_BYTES at most, wait in memory and are written as soon as it can be.
"""

import logging
from collections.abc import Callable
from pathlib import Path

import msgspec

from glasshelm.bridge.server.fault_log import describe_error
from glasshelm.bridge.sessions.session_log import RecentLines, SessionLog
from glasshelm.core.errors import InputError
from glasshelm.frames.frame_log import FrameLog
from glasshelm.frames.schema import Frame

#: Frames kept in memory: an hour.
MAX_HELD_FRAMES = 720
#: Bytes kept in memory: an hour of some 200 ships.
MAX_HELD_BYTES = 64_000_000
_log = logging.getLogger("glasshelm.bridge")


class LiveLog(SessionLog):
    """The newest frames in memory, and all of them in a log.

    Where the log was removed, or never could be opened, another one is begun with what is in
    memory. ``error`` says why the log cannot be written; ``n_lost`` counts the frames that were
    shown but dropped before they could be written.
    """

    def __init__(self, new_path: Callable[[], Path]):
        super().__init__()
        self.error: str | None = None
        self.n_lost = 0
        self._new_path = new_path
        self._log: FrameLog | None = None
        self._encoder = msgspec.json.Encoder()
        self._held = RecentLines((), MAX_HELD_FRAMES, MAX_HELD_BYTES)
        #: So many of the newest frames are not in the log yet.
        self._n_unwritten = 0
        self._try_to_write()

    @property
    def path(self) -> Path | None:
        return None if self._log is None else self._log.path

    @property
    def first(self) -> int:
        return len(self) - len(self._held.lines)

    def append(self, frame: Frame) -> bytes:
        line = self._encoder.encode(frame)
        self._add(frame, line)
        self._held.append(line)
        self._n_unwritten += 1
        self._try_to_write()
        self._held.trim()
        n_lost = max(self._n_unwritten - len(self._held.lines), 0)
        self._n_unwritten -= n_lost
        self.n_lost += n_lost
        return line

    def lines(self, first: int, end: int) -> list[bytes]:
        return [self._held.lines[k - self.first] for k in range(first, end)]

    def close(self) -> None:
        if self._n_unwritten:
            self._try_to_write()
        if self._n_unwritten:
            _log.error("%s; %d frames are lost", self.error, self._n_unwritten)
        self._close_file()

    def _try_to_write(self) -> None:
        try:
            if self._log is not None and self._log.replaced:
                self._close_file()
                self._n_unwritten = len(self._held.lines)
            if self._log is None:
                self._log = FrameLog(self._new_path())
            while self._n_unwritten:
                self._log.append_line(self._held.lines[-self._n_unwritten])
                self._n_unwritten -= 1
        except Exception as error:
            # The reason alone, without the folder.
            reason = describe_error(error).rpartition("cannot write the log (")[2].removesuffix(")")
            before = self.error
            self.error = f"the log cannot be written ({reason}): frames are shown without it"
            if before != self.error:
                _log.error("%s", self.error)
        else:
            if self.error is not None:
                _log.warning("the log %s is written again", self.path)
            self.error = None

    def _close_file(self) -> None:
        if self._log is not None:
            try:
                self._log.close()
            except InputError as error:
                _log.warning("%s", error)
        self._log = None
