"""The frames of a session: kept in its log on disk, with only their places in memory."""

import bisect
import itertools
from array import array
from pathlib import Path

import msgspec

from glasshelm.errors import NOT_JSON, InputError, told_as
from glasshelm.frames import Frame
from glasshelm.logbook import Logbook

#: A page is sent at most so many frames of what was ...
HISTORY_FRAMES = 720
#: ... and at most so many bytes of them.
HISTORY_BYTES = 8_000_000

_decoder = msgspec.json.Decoder(Frame)


class Record:
    """Frames in order of time, appended or read by number. Not for several threads at once.

    With ``fresh`` a new log is begun (the file must not be there yet);
    otherwise an existing one is read, and nothing can be appended.
    """

    def __init__(self, path: Path, fresh: bool):
        self.path = path
        with told_as(path.name, path):
            self._log = Logbook(path, fresh=True) if fresh else None
        try:
            self._file = open(path, "rb", buffering=0)  # noqa: SIM115
        except OSError as error:
            raise InputError(f"{path.name}: cannot read the log ({error.strerror})") from None
        self.times = array("d")
        self._ends = array("q", [0])
        if not fresh:
            self._scan()

    def __len__(self) -> int:
        return len(self.times)

    def append(self, frame: Frame) -> bytes:
        """Write one more frame; its line without the end."""
        assert self._log is not None, "a log that is being read is not written"
        line = self._log.write(frame)
        self._add(frame.time_s, len(line) + 1)
        return line

    def line(self, number: int) -> bytes:
        """A frame as it stands in the log."""
        return self.lines(number, number + 1)[0]

    def lines(self, first: int, end: int) -> list[bytes]:
        """Frames ``first`` to ``end`` (excluded) as they stand in the log."""
        start = self._ends[first]
        self._file.seek(start)
        text = self._file.read(self._ends[end] - start)
        marks = [place - start for place in self._ends[first : end + 1]]
        return [text[a:b].strip() for a, b in itertools.pairwise(marks)]

    def frame(self, number: int) -> Frame:
        return _decoder.decode(self.line(number))

    def history(self, end: int) -> list[bytes]:
        """The frames before ``end`` that a page is sent."""
        first = max(end - HISTORY_FRAMES, 0)
        while first < end - 1 and self._ends[end] - self._ends[first] > HISTORY_BYTES:
            first += 1
        return self.lines(first, end)

    def at(self, time_s: float) -> int:
        """The number of the last frame that is not later; the first if all are."""
        return max(bisect.bisect_right(self.times, time_s + 1e-6) - 1, 0)

    def close(self) -> None:
        if self._log is not None:
            self._log.close()
        self._file.close()

    def _add(self, time_s: float, size: int) -> None:
        self.times.append(time_s)
        self._ends.append(self._ends[-1] + size)

    def _scan(self) -> None:
        """Find the lines of a log; a torn last one is left out, as reading a log does."""
        with open(self.path, "rb") as file:
            for number, line in enumerate(file, start=1):
                if not line.strip():
                    self._ends[-1] += len(line)
                    continue
                try:
                    time_s = _decoder.decode(line).time_s
                except NOT_JSON as error:
                    if not line.endswith(b"\n"):
                        break
                    problem = f"line {number} is not a frame ({error})"
                    raise InputError(f"{self.path.name}: {problem}") from None
                if self.times and time_s <= self.times[-1]:
                    raise InputError(f"{self.path.name}: line {number} goes back in time")
                self._add(time_s, len(line))
        if not self.times:
            raise InputError(f"{self.path.name}: no frame in it; it was cut off, or is no log")
