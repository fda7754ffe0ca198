"""The frames of a session: kept in its log on disk, with only their places in memory."""

import bisect
import contextlib
import itertools
import logging
import os
import shutil
from abc import ABC, abstractmethod
from array import array
from collections import deque
from collections.abc import Callable, Iterable
from pathlib import Path

import msgspec

from glasshelm.core.errors import NOT_JSON, InputError, hide_paths
from glasshelm.core.output_dir import atomic_write
from glasshelm.frames import frame_log
from glasshelm.frames.frame_log import FrameLog
from glasshelm.frames.schema import Frame

#: A page is sent at most so many frames of what was ...
HISTORY_FRAMES = 720
#: ... and at most so many bytes of them.
HISTORY_BYTES = 8_000_000
#: How far the reading of a log has come is told after so many bytes.
_TOLD_BYTES = 20_000_000

_decoder = msgspec.json.Decoder(Frame)
_log = logging.getLogger("glasshelm.bridge")


class FrameLines(ABC):
    """Frames in order of time, each as its line of a log. Not for several threads at once."""

    def __init__(self) -> None:
        self.times = array("d")
        self._ends = array("q", [0])
        #: The number of the first frame that can still be read.
        self.first = 0

    def __len__(self) -> int:
        return len(self.times)

    @property
    @abstractmethod
    def path(self) -> Path | None:
        """Where the log is, if there is one."""
        ...

    @abstractmethod
    def append(self, frame: Frame) -> bytes:
        """Add one more frame; its line without the end."""
        ...

    @abstractmethod
    def lines(self, first: int, end: int) -> list[bytes]:
        """Frames ``first`` to ``end`` (excluded) as they stand in the log."""
        ...

    @abstractmethod
    def close(self) -> None: ...

    def line(self, number: int) -> bytes:
        """A frame as it stands in the log."""
        return self.lines(number, number + 1)[0]

    def frame(self, number: int) -> Frame:
        return _decoder.decode(self.line(number))

    def history(self, end: int, frames: int | None = None, size: int | None = None) -> list[bytes]:
        """The frames before ``end``: so many, of so many bytes; or those that a page is sent."""
        first = max(end - (HISTORY_FRAMES if frames is None else frames), self.first)
        size = HISTORY_BYTES if size is None else size
        while first < end - 1 and self._ends[end] - self._ends[first] > size:
            first += 1
        return self.lines(first, end)

    def index_at(self, time_s: float) -> int:
        """The number of the last frame that is not later; the first if all are."""
        return max(bisect.bisect_right(self.times, time_s + 1e-6) - 1, 0)

    def _add(self, time_s: float, size: int) -> None:
        self.times.append(time_s)
        self._ends.append(self._ends[-1] + size)


class SessionLog(FrameLines):
    """Frames that are appended to a log, or read from it, by number.

    With ``fresh`` a new log is begun (the file must not be there yet);
    otherwise an existing one is read, and nothing can be appended; ``progress`` is told
    which share of it has been read. A frame that cannot be written is not there (InputError).
    """

    def __init__(
        self, path: Path, fresh: bool, progress: Callable[[float], None] = lambda share: None
    ):
        super().__init__()
        self._path = path
        self._log: FrameLog | None = None
        #: The frame added or read last: it is not read again.
        self._latest: tuple[int, bytes] = -1, b""
        if fresh:
            with hide_paths(path.name, path):
                self._log = FrameLog(path, fresh=True)
        try:
            self._file = open(path, "rb", buffering=0)  # noqa: SIM115
        except OSError as error:
            if self._log is not None:
                self._log.close()
            raise InputError(f"{path.name}: cannot read the log ({error.strerror})") from None
        if not fresh:
            self._scan(progress)

    @property
    def path(self) -> Path:
        return self._path

    def append(self, frame: Frame) -> bytes:
        """Write one more frame; its line without the end. InputError if it cannot be written."""
        assert self._log is not None, "a log that is being read is not written"
        with hide_paths(self.path.name, self.path):
            if self._log.gone:
                self._log = self._restored()
            line = self._log.write(frame)
        self._latest = len(self), line
        self._add(frame.time_s, len(line) + 1)
        return line

    def line(self, number: int) -> bytes:
        if self._latest[0] != number:
            self._latest = number, super().line(number)
        return self._latest[1]

    def lines(self, first: int, end: int) -> list[bytes]:
        start = self._ends[first]
        try:
            text = os.pread(self._file.fileno(), self._ends[end] - start, start)
        except OSError as error:
            problem = f"cannot read the log ({error.strerror})"
            raise InputError(f"{self.path.name}: {problem}") from None
        if len(text) < self._ends[end] - start:
            raise InputError(f"{self.path.name}: cannot read the log (it was cut off)")
        marks = [place - start for place in self._ends[first : end + 1]]
        return [text[a:b].strip() for a, b in itertools.pairwise(marks)]

    def close(self) -> None:
        if self._log is not None:
            try:
                self._log.close()
            except InputError as error:  # every frame has been read, or shown from memory
                _log.warning("%s", error)
        with contextlib.suppress(OSError):
            self._file.close()

    def _restored(self) -> FrameLog:
        """The log as it was, in place of one that was removed: its file can still be read."""
        try:
            with atomic_write(self.path) as path, open(path, "wb") as file:
                self._file.seek(0)
                shutil.copyfileobj(self._file, file)
                file.truncate(self._ends[-1])
            again = FrameLog(self.path)
            reading = open(self.path, "rb", buffering=0)  # noqa: SIM115
        except OSError as error:
            problem = f"cannot write the log ({error.strerror})"
            raise InputError(f"{self.path}: {problem}") from None
        self.close()
        self._file = reading
        return again

    def _scan(self, progress: Callable[[float], None]) -> None:
        """Find the lines of a log; a torn last one is left out, as reading a log does."""
        size, told = max(os.fstat(self._file.fileno()).st_size, 1), 0
        with open(self.path, "rb") as file:
            for number, line in frame_log.lines(file, self.path.name):
                start = file.tell() - len(line)
                try:
                    time_s = _decoder.decode(line).time_s
                except NOT_JSON as error:
                    if not line.endswith(b"\n"):
                        break
                    problem = f"line {number} is not a frame ({error})"
                    raise InputError(f"{self.path.name}: {problem}") from None
                if self.times and time_s <= self.times[-1]:
                    raise InputError(f"{self.path.name}: line {number} goes back in time")
                # Blank lines before it go with the frame before, where there is one.
                self._ends[-1] = start
                self._add(time_s, len(line))
                if start >= told:
                    progress(start / size)
                    told = start + _TOLD_BYTES
        if not self.times:
            raise InputError(f"{self.path.name}: no frame in it; it was cut off, or is no log")


class Past:
    """The frames that a page is sent of what was, kept in memory while time goes on."""

    def __init__(self) -> None:
        self._lines: deque[bytes] = deque()
        self._size = 0

    @property
    def lines(self) -> list[bytes]:
        return list(self._lines)

    def add(self, line: bytes) -> None:
        """One more; the oldest are left out where there are too many."""
        self._lines.append(line)
        self._size += len(line) + 1
        while len(self._lines) > 1 and (
            len(self._lines) > HISTORY_FRAMES or self._size > HISTORY_BYTES
        ):
            self._size -= len(self._lines.popleft()) + 1

    def fill(self, lines: Iterable[bytes]) -> None:
        """These in place of all."""
        self._lines.clear()
        self._size = 0
        for line in lines:
            self.add(line)
