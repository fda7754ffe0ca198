"""The log: frames as JSON lines, appended one by one; their schema; their Parquet form.

A line is one frame as msgspec writes it (glasshelm.frames). A log whose writer
was cut off ends in a torn line; reading leaves that line out.
``python -m glasshelm.logbook docs/frame.schema.json`` writes the schema.
"""

import inspect
import json
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import msgspec

from glasshelm.errors import NOT_JSON, InputError
from glasshelm.frames import Frame


class Logbook:
    """A log open for appending; a context manager.

    Every frame is handed to the system before ``write`` returns. The torn last
    line of a log that was cut off is removed before anything is appended;
    ``fresh`` begins an empty log in its place. InputError if the file cannot be
    opened.
    """

    def __init__(self, path: str | Path, fresh: bool = False):
        self.path = Path(path)
        self.frames = 0
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._file = open(self.path, "w+b" if fresh else "a+b")  # noqa: SIM115
        except FileExistsError:
            raise InputError(f"{path}: cannot write the log (its folder is a file)") from None
        except OSError as error:
            raise InputError(f"{path}: cannot write the log ({error.strerror})") from None
        self._cut_torn_line()
        self._encoder = msgspec.json.Encoder()

    def write(self, frame: Frame) -> bytes:
        """Append one frame; returns its line, without the end."""
        line = self._encoder.encode(frame)
        self._file.write(line + b"\n")
        self._file.flush()
        self.frames += 1
        return line

    def close(self) -> None:
        self._file.close()

    def __enter__(self) -> "Logbook":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _cut_torn_line(self) -> None:
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
            self._file.seek(0, os.SEEK_END)


def write(path: str | Path, frames: Iterable[Frame]) -> int:
    """Write a new log, replacing the file; returns the number of frames."""
    with Logbook(path, fresh=True) as log:
        for frame in frames:
            log.write(frame)
        return log.frames


def read(path: str | Path) -> Iterator[Frame]:
    """The frames of a log, one by one.

    A last line without its end is left out if it cannot be read. InputError if
    there is no such file, or names the first damaged line before it.
    """
    decoder = msgspec.json.Decoder(Frame)
    try:
        file = open(path, "rb")  # noqa: SIM115
    except OSError as error:
        raise InputError(f"{path}: cannot read the log ({error.strerror})") from None
    with file:
        for number, line in enumerate(file, start=1):
            if not line.strip():
                continue
            try:
                yield decoder.decode(line)
            except NOT_JSON as error:
                if not line.endswith(b"\n"):
                    return
                raise InputError(f"{path}: line {number} is not a frame ({error})") from None


def begins(frames: Sequence[Frame], k: int) -> bool:
    """Whether nothing was remembered before frame k: the one without a reward among others."""
    beside = frames[k + 1] if k + 1 < len(frames) else frames[k - 1]
    return frames[k].reward is None and beside.reward is not None


def schema() -> str:
    """The JSON schema of a frame, as text: the same for every version of Python."""
    return json.dumps(_clean(msgspec.json.schema(Frame)), indent=2, ensure_ascii=False) + "\n"


def _clean(part: Any) -> Any:
    """A schema whose descriptions are free of the indentation of docstrings."""
    if isinstance(part, dict):
        return {
            name: inspect.cleandoc(value)
            if name == "description" and isinstance(value, str)
            else _clean(value)
            for name, value in part.items()
        }
    return [_clean(value) for value in part] if isinstance(part, list) else part


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(schema(), encoding="utf-8")
