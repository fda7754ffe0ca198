"""The log: frames as JSON lines, appended one by one; their Parquet form.

A line is one frame as msgspec writes it (glasshelm.frames.schema). A log whose writer
was killed may end in a torn line; reading leaves that line out.
"""

import contextlib
import errno
import itertools
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import BinaryIO

import msgspec

from glasshelm.core.errors import DECODE_ERRORS, InputError, hide_paths
from glasshelm.core.output_dir import atomic_write
from glasshelm.frames.schema import Frame

#: Bytes of a frame's line at most; one of 200 ships has about 100,000.
MAX_LINE_BYTES = 32_000_000


class FrameLog:
    """A log open for appending; a context manager.

    Every frame is handed to the system before ``write`` returns; one that cannot be
    written whole leaves the log as it was. The torn last line of a log that was cut off
    is removed before anything is appended; ``fresh`` begins an empty log in its place.
    InputError if the file cannot be opened.
    """

    def __init__(self, path: str | Path, fresh: bool = False):
        self.path = Path(path)
        self.frames = 0
        self._encoder = msgspec.json.Encoder()
        with _log_errors(self.path):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            # Unbuffered: what is told as written is with the system, nothing waits in between.
            self._file = open(self.path, "w+b" if fresh else "a+b", buffering=0)  # noqa: SIM115
        try:
            with _log_errors(self.path):
                #: Where the last whole line ends, and whether anything lies behind it.
                self._end, self._torn = self._whole_lines(), False
        except BaseException:
            self._file.close()
            raise

    def write(self, frame: Frame) -> bytes:
        """Append one frame; returns its line, without the end. InputError if it cannot be."""
        line = self._encoder.encode(frame)
        self.append_line(line)
        return line

    def append_line(self, line: bytes) -> None:
        """Append the line of a frame, given without its end, whole or not at all."""
        rest = memoryview(line + b"\n")
        with _log_errors(self.path):
            if self._torn:
                self._cut_back()
            self._torn = True
            try:
                self._file.seek(self._end)
                while rest:
                    rest = rest[self._file.write(rest) :]
            except BaseException:
                with contextlib.suppress(OSError):  # then it is tried before the next line
                    self._cut_back()
                raise
        self._end += len(line) + 1
        self._torn = False
        self.frames += 1

    @property
    def replaced(self) -> bool:
        """Whether the file was removed or replaced: what is written now, nobody finds."""
        try:
            return not os.path.samestat(os.stat(self.path), os.fstat(self._file.fileno()))
        except (FileNotFoundError, NotADirectoryError):
            return True
        except OSError as error:
            return error.errno == errno.ESTALE  # otherwise nobody can tell at the moment

    def close(self) -> None:
        """InputError where only now the system says that something could not be written."""
        with _log_errors(self.path):
            self._file.close()

    def __enter__(self) -> "FrameLog":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _cut_back(self) -> None:
        self._file.truncate(self._end)
        self._torn = False

    def _whole_lines(self) -> int:
        """Cut off the torn last line; where the log ends now."""
        end = self._file.seek(0, os.SEEK_END)
        whole = end
        while whole > 0:
            start = max(whole - 65536, 0)
            self._file.seek(start)
            newline = self._file.read(whole - start).rfind(b"\n")
            if newline >= 0:
                whole = start + newline + 1
                break
            whole = start
        if whole < end:
            self._file.truncate(whole)
        return whole


@contextlib.contextmanager
def _log_errors(path: Path) -> Iterator[None]:
    """Why a log cannot be written, in one line."""
    try:
        yield
    except FileExistsError:
        raise InputError(f"{path}: cannot write the log (its folder is a file)") from None
    except OSError as error:
        raise InputError(f"{path}: cannot write the log ({error.strerror or error})") from None


def write_log(path: str | Path, frames: Iterable[Frame]) -> int:
    """Write a whole log, replacing the file.

    Args:
        path: The JSON Lines file.
        frames: The frames, in order.

    Returns:
        The number of frames.

    Raises:
        InputError: The file cannot be written.
    """
    with (
        atomic_write(path) as partial,
        hide_paths(str(path), partial),
        FrameLog(partial, fresh=True) as log,
    ):
        for frame in frames:
            log.write(frame)
        return log.frames


def read_log(path: str | Path) -> Iterator[Frame]:
    """The frames of a log, one by one.

    A last line without its end is left out if it cannot be read.

    Args:
        path: A JSON Lines file of frames.

    Returns:
        An iterator; the file is read as it goes.

    Raises:
        InputError: There is no such file, or a line before the last is damaged.
    """
    decoder = msgspec.json.Decoder(Frame)
    try:
        file = open(path, "rb")  # noqa: SIM115
    except OSError as error:
        raise InputError(f"{path}: cannot read the log ({error.strerror})") from None
    with file:
        for number, line in lines(file, str(path)):
            try:
                yield decoder.decode(line)
            except DECODE_ERRORS as error:
                if not line.endswith(b"\n"):
                    return
                raise InputError(f"{path}: line {number} is not a frame ({error})") from None


def lines(file: BinaryIO, name: str) -> Iterator[tuple[int, bytes]]:
    """The lines of a log with their numbers, without the blank ones; none is read beyond LONGEST.

    InputError, in the words of ``name``, for a longer one, and where the file cannot be read.
    """
    for number in itertools.count(1):
        try:
            line = file.readline(MAX_LINE_BYTES + 1)
        except OSError as error:
            raise InputError(f"{name}: cannot read the log ({error.strerror})") from None
        if not line:
            return
        if len(line) > MAX_LINE_BYTES:
            most = f"{MAX_LINE_BYTES // 10**6} MB"
            raise InputError(f"{name}: line {number} is longer than any frame ({most}): no log")
        if line.strip():
            yield number, line


def is_episode_start(frames: Sequence[Frame], k: int) -> bool:
    """Whether nothing was remembered before frame k: the one without a reward among others."""
    beside = frames[k + 1] if k + 1 < len(frames) else frames[k - 1]
    return frames[k].reward is None and beside.reward is not None
