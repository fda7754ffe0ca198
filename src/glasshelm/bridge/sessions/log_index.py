"""The folder of logs: every session writes one, and each can be shown again by its name."""

import os
import re
import threading
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from glasshelm.bridge.server.protocol import LogEntry
from glasshelm.core.errors import NOT_JSON, InputError
from glasshelm.frames.frame_log import LONGEST

SUFFIX = ".jsonl"
#: At most so many logs are listed, the newest first.
MAX_LISTED = 50
#: Bytes of logs that are read at most to list them.
MAX_READ_BYTES = 64_000_000
_PIECE = 1_000_000


def default_log_dir() -> Path:
    """The user's data folder for logs."""
    root = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share")
    return root / "glasshelm" / "logs"


def new_log_path(folder: Path, source: str, pilot: str) -> Path:
    """A path where no log is yet, named after the time (UTC), the source and the pilot."""
    time = datetime.now(UTC).strftime("%Y%m%dT%H%M%SZ")
    words = re.sub(r"[^a-z0-9]+", "-", f"{source}-{pilot}".lower()).strip("-")[:80]
    path, number = folder / f"{time}-{words}{SUFFIX}", 2
    while path.exists():
        path, number = folder / f"{time}-{words}-{number}{SUFFIX}", number + 1
    return path


def find_log(folder: Path, name: str) -> Path:
    """The log of that name. InputError if it is none of the folder's own."""
    if name not in (path.name for path in _newest(folder)):
        raise InputError(f"no log {name[:100]!r}: choose one of the catalogue")
    return folder / name


class _Counted:
    """How far a log was counted."""

    def __init__(self, inode: int):
        self.inode, self.read, self.frames = inode, 0, 0
        self.time_utc: str | None = None
        self.is_log = True

    def go_on(self, path: Path, size: int, most: int) -> int:
        """Count what has been added, at most so many bytes; how many were read."""
        begun = self.read
        with open(path, "rb") as file:
            if self.read == 0:
                first = file.readline(LONGEST + 1)
                if not first.endswith(b"\n"):  # not written to its end; or longer than a frame
                    self.is_log = len(first) <= LONGEST
                    return len(first)
                self.is_log, self.time_utc = _begins_with(first)
                self.read, self.frames = len(first), 1
            file.seek(self.read)
            while self.is_log and self.read < min(size, begun + most):
                piece = file.read(min(_PIECE, size - self.read))
                if not piece:
                    break
                self.read += len(piece)
                self.frames += piece.count(b"\n")
        return self.read - begun


class LogIndex:
    """Lists the logs of a folder. Of each only what was added is read, and no more than COUNTED
    bytes in all at a time: what is longer is counted on the next time.
    """

    def __init__(self, folder: Path):
        self.folder = folder
        self._known: dict[str, _Counted] = {}
        self._counting = threading.Lock()

    def entries(self) -> list[LogEntry]:
        """The newest logs that hold a frame; how many, where they have been counted to the end."""
        with self._counting:
            known, cards, left = {}, [], MAX_READ_BYTES
            for path in _newest(self.folder)[:MAX_LISTED]:
                try:
                    there = path.stat()
                    counted = self._known.get(path.name)
                    if (
                        counted is None
                        or counted.inode != there.st_ino
                        or counted.read > there.st_size
                    ):
                        counted = _Counted(there.st_ino)
                    if left > 0 and counted.is_log and counted.read < there.st_size:
                        left -= counted.go_on(path, there.st_size, left)
                except OSError:  # removed meanwhile, or not ours to read
                    continue
                known[path.name] = counted
                whole = counted.read >= there.st_size
                if counted.is_log and counted.frames:
                    frames = counted.frames if whole else None
                    cards.append(LogEntry(path.name, frames, counted.time_utc))
            self._known = known
        return cards


def _newest(folder: Path) -> list[Path]:
    """The plain files of the folder that are called logs, by name from the newest."""
    try:
        found = [p for p in folder.iterdir() if p.suffix == SUFFIX and not p.is_symlink()]
    except OSError:
        return []
    return sorted(filter(Path.is_file, found), key=lambda path: path.name, reverse=True)


class _When(msgspec.Struct):
    time_utc: str | None = None


def _begins_with(line: bytes) -> tuple[bool, str | None]:
    """Whether a log may begin so, and when it does."""
    try:
        return True, msgspec.json.decode(line, type=_When).time_utc
    except NOT_JSON:
        return False, None
