"""The folder of logs: every session writes one, and each can be replayed by its name."""

import os
import re
import threading
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from glasshelm.bridge.server.protocol import LogEntry
from glasshelm.core.errors import DECODE_ERRORS, InputError
from glasshelm.frames.frame_log import MAX_LINE_BYTES

SUFFIX = ".jsonl"
#: At most so many logs are listed, the newest first.
MAX_LISTED = 50
#: At most so many bytes of logs are read to list them.
MAX_READ_BYTES = 64_000_000
_CHUNK_BYTES = 1_000_000


def default_log_dir() -> Path:
    """The user's data folder for logs."""
    root = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share")
    return root / "glasshelm" / "logs"


def new_log_path(folder: Path, source: str, pilot: str) -> Path:
    """Return an unused path named after the time (UTC), the source and the pilot."""
    time = datetime.now(UTC).strftime("%Y%m%dT%H%M%SZ")
    words = re.sub(r"[^a-z0-9]+", "-", f"{source}-{pilot}".lower()).strip("-")[:80]
    path, number = folder / f"{time}-{words}{SUFFIX}", 2
    while path.exists():
        path, number = folder / f"{time}-{words}-{number}{SUFFIX}", number + 1
    return path


def find_log(folder: Path, name: str) -> Path:
    """Return the log of that name. InputError if the folder has none."""
    if name not in (path.name for path in _newest_first(folder)):
        raise InputError(f"no log {name[:100]!r}: choose one of the catalogue")
    return folder / name


class _Count:
    """How far a log has been counted."""

    def __init__(self, inode: int):
        self.inode, self.n_bytes, self.n_frames = inode, 0, 0
        self.time_utc: str | None = None
        self.is_log = True

    def advance(self, path: Path, size: int, max_bytes: int) -> int:
        """Count what was added, at most so many bytes; return how many were read."""
        before = self.n_bytes
        with open(path, "rb") as file:
            if before == 0:
                first = file.readline(MAX_LINE_BYTES + 1)
                if not first.endswith(b"\n"):  # not written to its end, or longer than a frame
                    self.is_log = len(first) <= MAX_LINE_BYTES
                    return len(first)
                try:
                    self.time_utc = msgspec.json.decode(first, type=_Start).time_utc
                except DECODE_ERRORS:
                    self.is_log = False
                self.n_bytes, self.n_frames = len(first), 1
            file.seek(self.n_bytes)
            while self.is_log and self.n_bytes < min(size, before + max_bytes):
                chunk = file.read(min(_CHUNK_BYTES, size - self.n_bytes))
                if not chunk:
                    break
                self.n_bytes += len(chunk)
                self.n_frames += chunk.count(b"\n")
        return self.n_bytes - before


class _Start(msgspec.Struct):
    time_utc: str | None = None


class LogIndex:
    """Lists the logs of a folder.

    Only what was added to a log is read, and no more than MAX_READ_BYTES in all at a time: the
    count of a longer log continues the next time.
    """

    def __init__(self, folder: Path):
        self.folder = folder
        self._counts: dict[str, _Count] = {}
        self._lock = threading.Lock()

    def entries(self) -> list[LogEntry]:
        """List the newest logs that hold a frame, with the number of frames once it is known."""
        with self._lock:
            counts, entries, left = {}, [], MAX_READ_BYTES
            for path in _newest_first(self.folder)[:MAX_LISTED]:
                try:
                    stat = path.stat()
                    count = self._counts.get(path.name)
                    if count is None or count.inode != stat.st_ino or count.n_bytes > stat.st_size:
                        count = _Count(stat.st_ino)
                    if left > 0 and count.is_log and count.n_bytes < stat.st_size:
                        left -= count.advance(path, stat.st_size, left)
                except OSError:  # removed meanwhile, or not ours to read
                    continue
                counts[path.name] = count
                if count.is_log and count.n_frames:
                    n_frames = count.n_frames if count.n_bytes >= stat.st_size else None
                    entries.append(LogEntry(path.name, n_frames, count.time_utc))
            self._counts = counts
        return entries


def _newest_first(folder: Path) -> list[Path]:
    """The log files of a folder, by name from the newest; no links."""
    try:
        paths = [p for p in folder.iterdir() if p.suffix == SUFFIX and not p.is_symlink()]
    except OSError:
        return []
    return sorted(filter(Path.is_file, paths), key=lambda path: path.name, reverse=True)
