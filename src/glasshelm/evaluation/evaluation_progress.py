"""What a person sees while pilots are examined: a bar on a terminal, lines elsewhere."""

import time

from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from glasshelm.core.terminal import TaskDescription, Terminal

#: Where there is no terminal, a line at most so often [s].
_LINE_S = 30.0


class Display:
    """Voyages sailed of all."""

    def __init__(self, console: Terminal):
        self.console = console
        self.done = self.total = 0
        self._said = time.monotonic()
        self._bar = Progress(
            TaskDescription(),
            BarColumn(bar_width=24),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=console,
            disable=not console.is_terminal,
            transient=True,
        )
        self._task = self._bar.add_task("sailing", total=None)

    def __enter__(self) -> "Display":
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def show(self, what: str, done: int, of: int) -> None:
        """``done`` voyages of ``of`` are finished, the last of ``what``."""
        self.done, self.total = done, of
        self._bar.update(self._task, description=what or "sailing", completed=done, total=of)
        now = time.monotonic()
        if not self.console.is_terminal and now - self._said > _LINE_S:
            self._said = now
            self.console.say(f"{done} of {of} voyages: {what}")
