"""The folder of logs: every session writes one, and each can be shown again by its name."""

import os
import re
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from glasshelm.bridge.messages import LogCard
from glasshelm.errors import NOT_JSON, InputError

SUFFIX = ".jsonl"
#: At most so many logs are listed, the newest first.
MOST_LISTED = 50


def default_logs() -> Path:
    """The user's data folder for logs."""
    root = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share")
    return root / "glasshelm" / "logs"


def new_log(folder: Path, source: str, pilot: str) -> Path:
    """A path where no log is yet, named after the time (UTC), the source and the pilot."""
    time = datetime.now(UTC).strftime("%Y%m%dT%H%M%SZ")
    words = re.sub(r"[^a-z0-9]+", "-", f"{source}-{pilot}".lower()).strip("-")[:80]
    path, number = folder / f"{time}-{words}{SUFFIX}", 2
    while path.exists():
        path, number = folder / f"{time}-{words}-{number}{SUFFIX}", number + 1
    return path


def log_named(folder: Path, name: str) -> Path:
    """The log of that name. InputError if it is none of the folder's own."""
    if name not in (path.name for path in _newest(folder)):
        raise InputError(f"no log {name[:100]!r}: choose one of the catalogue")
    return folder / name


class Shelf:
    """Lists the logs of a folder; a log that has not changed is not counted again."""

    def __init__(self, folder: Path):
        self.folder = folder
        self._known: dict[tuple[str, int], LogCard] = {}

    def cards(self) -> list[LogCard]:
        """The newest logs that hold a frame."""
        known = {}
        for path in _newest(self.folder)[:MOST_LISTED]:
            try:
                key = (path.name, path.stat().st_size)
                known[key] = self._known.get(key) or _card(path)
            except OSError:  # removed meanwhile, or not ours to read
                continue
        self._known = known
        return [card for card in known.values() if card.frames]


def _newest(folder: Path) -> list[Path]:
    """The plain files of the folder that are called logs, by name from the newest."""
    try:
        found = [p for p in folder.iterdir() if p.suffix == SUFFIX and not p.is_symlink()]
    except OSError:
        return []
    return sorted(filter(Path.is_file, found), key=lambda path: path.name, reverse=True)


class _When(msgspec.Struct):
    time_utc: str | None = None


def _card(path: Path) -> LogCard:
    with open(path, "rb") as file:
        first = file.readline()
        frames = first.endswith(b"\n") + sum(line.endswith(b"\n") for line in file)
    try:
        time_utc = msgspec.json.decode(first, type=_When).time_utc if frames else None
    except NOT_JSON:
        return LogCard(path.name, 0)
    return LogCard(path.name, frames, time_utc)
