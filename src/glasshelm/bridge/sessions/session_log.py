"""The frames of a session by number, on disk: of each only its time and place are in memory."""

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

from glasshelm.core.errors import DECODE_ERRORS, InputError, hide_paths
from glasshelm.core.output_dir import atomic_write
from glasshelm.frames import frame_log
from glasshelm.frames.frame_log import FrameLog
from glasshelm.frames.schema import Frame

#: A page is sent at most so many past frames ...
HISTORY_FRAMES = 720
#: ... and at most so many bytes of them.
HISTORY_BYTES = 8_000_000
#: Progress of reading a log is reported after so many bytes.
_PROGRESS_BYTES = 20_000_000

_decoder = msgspec.json.Decoder(Frame)
_log = logging.getLogger("glasshelm.bridge")


class RecentLines:
    """The newest lines of a log in memory, bounded in number and in bytes."""

    def __init__(
        self,
        lines: Iterable[bytes] = (),
        max_lines: int = HISTORY_FRAMES,
        max_bytes: int = HISTORY_BYTES,
    ):
        self.lines: deque[bytes] = deque()
        self._max_lines, self._max_bytes, self._bytes = max_lines, max_bytes, 0
        for line in lines:
            self.append(line)
        self.trim()

    def append(self, line: bytes) -> None:
        self.lines.append(line)
        self._bytes += len(line) + 1

    def trim(self) -> None:
        """Drop the oldest lines beyond the bounds; the newest always stays."""
        while len(self.lines) > 1 and (
            len(self.lines) > self._max_lines or self._bytes > self._max_bytes
        ):
            self._bytes -= len(self.lines.popleft()) + 1


class SessionLog(ABC):
    """Frames in order of time, each as its line in a log. Not thread-safe."""

    def __init__(self) -> None:
        self.times = array("d")
        self._ends = array("q", [0])
        #: The frame added or read last, with its number and line: it is not read or decoded again.
        self._loaded: tuple[int, Frame, bytes] | None = None

    def __len__(self) -> int:
        return len(self.times)

    @property
    def first(self) -> int:
        """The number of the first frame that can still be read."""
        return 0

    @property
    @abstractmethod
    def path(self) -> Path | None:
        """Where the log is; None while there is none."""
        ...

    @abstractmethod
    def append(self, frame: Frame) -> bytes:
        """Add a frame; return its line, without the newline."""
        ...

    @abstractmethod
    def lines(self, first: int, end: int) -> list[bytes]:
        """Return the lines of frames ``first`` to ``end`` (exclusive)."""
        ...

    @abstractmethod
    def close(self) -> None: ...

    def line(self, number: int) -> bytes:
        return self._load(number)[2]

    def frame(self, number: int) -> Frame:
        return self._load(number)[1]

    def history(
        self, end: int, max_frames: int | None = None, max_bytes: int | None = None
    ) -> list[bytes]:
        """Return the lines before frame ``end``, by default as many as a page is sent."""
        first = max(end - (HISTORY_FRAMES if max_frames is None else max_frames), self.first)
        max_bytes = HISTORY_BYTES if max_bytes is None else max_bytes
        while first < end - 1 and self._ends[end] - self._ends[first] > max_bytes:
            first += 1
        return self.lines(first, end)

    def index_at(self, time_s: float) -> int:
        """Return the number of the last frame that is not later; the first if all are."""
        return max(bisect.bisect_right(self.times, time_s + 1e-6) - 1, 0)

    def _add(self, frame: Frame, line: bytes) -> None:
        self._loaded = len(self), frame, line
        self._add_place(frame.time_s, len(line) + 1)

    def _add_place(self, time_s: float, size: int) -> None:
        self.times.append(time_s)
        self._ends.append(self._ends[-1] + size)

    def _load(self, number: int) -> tuple[int, Frame, bytes]:
        if self._loaded is None or self._loaded[0] != number:
            line = self.lines(number, number + 1)[0]
            self._loaded = number, _decoder.decode(line), line
        return self._loaded


class FileLog(SessionLog):
    """A log on disk: one that is written, or with ``fresh`` false one that exists and is read.

    A frame that cannot be written is not added (InputError).

    Args:
        path: The file; with ``fresh`` it must not exist yet.
        fresh: Begin a new log.
        progress: Called with the share of an existing log read so far.
    """

    def __init__(
        self, path: Path, fresh: bool, progress: Callable[[float], None] = lambda share: None
    ):
        super().__init__()
        self._path = path
        self._log: FrameLog | None = None
        if fresh:
            with hide_paths(path.name, path):
                self._log = FrameLog(path, fresh=True)
        try:
            self._file = open(path, "rb", buffering=0)  # noqa: SIM115
        except OSError as error:
            if self._log is not None:
                self._log.close()
            raise self._unreadable(error.strerror) from None
        if not fresh:
            self._scan(progress)

    @property
    def path(self) -> Path:
        return self._path

    def append(self, frame: Frame) -> bytes:
        assert self._log is not None, "this log is read only"
        with hide_paths(self.path.name, self.path):
            if self._log.replaced:
                self._log = self._restored()
            line = self._log.write(frame)
        self._add(frame, line)
        return line

    def lines(self, first: int, end: int) -> list[bytes]:
        start = self._ends[first]
        try:
            text = os.pread(self._file.fileno(), self._ends[end] - start, start)
        except OSError as error:
            raise self._unreadable(error.strerror) from None
        if len(text) < self._ends[end] - start:
            raise self._unreadable("it was cut off")
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

    def _unreadable(self, reason: str | None) -> InputError:
        return InputError(f"{self.path.name}: cannot read the log ({reason})")

    def _restored(self) -> FrameLog:
        """Write the log again where it was removed: the open file can still be read."""
        try:
            with atomic_write(self.path) as path, open(path, "wb") as file:
                self._file.seek(0)
                shutil.copyfileobj(self._file, file)
                file.truncate(self._ends[-1])
            restored = FrameLog(self.path)
            reading = open(self.path, "rb", buffering=0)  # noqa: SIM115
        except OSError as error:
            raise InputError(f"{self.path}: cannot write the log ({error.strerror})") from None
        self.close()
        self._file = reading
        return restored

    def _scan(self, progress: Callable[[float], None]) -> None:
        """Find the lines of an existing log; a torn last line is left out."""
        size, reported = max(os.fstat(self._file.fileno()).st_size, 1), 0
        with open(self.path, "rb") as file:
            for number, line in frame_log.lines(file, self.path.name):
                start = file.tell() - len(line)
                try:
                    time_s = _decoder.decode(line).time_s
                except DECODE_ERRORS as error:
                    if not line.endswith(b"\n"):
                        break
                    problem = f"line {number} is not a frame ({error})"
                    raise InputError(f"{self.path.name}: {problem}") from None
                if self.times and time_s <= self.times[-1]:
                    raise InputError(f"{self.path.name}: line {number} goes back in time")
                # Blank lines before it belong to the frame before.
                self._ends[-1] = start
                self._add_place(time_s, len(line))
                if start >= reported:
                    progress(start / size)
                    reported = start + _PROGRESS_BYTES
        if not self.times:
            raise InputError(f"{self.path.name}: no frame in it; it was cut off, or is not a log")
