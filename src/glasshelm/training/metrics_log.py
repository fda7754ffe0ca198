"""What a training writes to read: JSON lines, and TensorBoard where it is installed."""

import importlib.util
import json
import os
from pathlib import Path
from typing import Any

from glasshelm.core.errors import InputError
from glasshelm.core.output_dir import atomic_write, writable_folder

LOG_FILE = "log.jsonl"


class MetricsLog:
    """The log of one training. Lines written after the snapshot that is resumed are dropped.

    Args:
        folder: Where the training writes.
        resume_at: The ``number`` of the last line to keep; None for a new training.
        tensorboard: Whether to write for TensorBoard too, where it is installed.

    Raises:
        InputError: The folder cannot be written.
    """

    def __init__(self, folder: Path, resume_at: int | None, tensorboard: bool = True):
        self.path = folder / LOG_FILE
        writable_folder(folder)
        try:
            kept = []
            if resume_at is not None:
                kept = [line for line in read_metrics(folder) if line["number"] <= resume_at]
            with atomic_write(self.path) as partial:
                partial.write_text("".join(json.dumps(line) + "\n" for line in kept))
        except OSError as error:
            raise InputError(f"{folder}: cannot write there ({error.strerror})") from None
        self._board = None
        if tensorboard and importlib.util.find_spec("tensorboardX"):
            from tensorboardX import SummaryWriter

            self._board = SummaryWriter(str(folder / "tensorboard"), purge_step=resume_at)

    def add(self, line: dict[str, Any]) -> None:
        """Append one line; its numbers also go to TensorBoard at the line's ``number``.

        InputError if it cannot be written.
        """
        try:
            with self.path.open("a") as file:
                file.write(json.dumps(line) + "\n")
        except OSError as error:
            raise InputError(f"{self.path}: cannot write it ({error.strerror})") from None
        if self._board is not None:
            for name, value in line.items():
                if isinstance(value, int | float) and name not in ("number", "seconds"):
                    self._board.add_scalar(f"{line['stage']}/{name}", value, line["number"])

    def close(self) -> None:
        if self._board is not None:
            self._board.close()


def read_metrics(folder: Path) -> list[dict[str, Any]]:
    """The lines of a training's log; a line cut off by a crash is left out."""
    path = folder / LOG_FILE
    lines = []
    if not os.path.isfile(path):
        return lines
    for text in path.read_text(encoding="utf-8", errors="replace").splitlines():
        try:
            lines.append(json.loads(text))
        except (ValueError, RecursionError):
            break
    return lines
