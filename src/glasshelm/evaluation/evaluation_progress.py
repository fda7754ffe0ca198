"""What a user sees while pilots are evaluated: a bar on a terminal, lines elsewhere."""

import time

from rich.progress import MofNCompleteColumn, TimeElapsedColumn

from glasshelm.core.terminal import Terminal, progress

#: Where there is no terminal, a line at most so often [s].
_LINE_S = 30.0


class EvaluationProgress:
    """How many voyages are done."""

    def __init__(self, console: Terminal):
        self.console = console
        self.done = self.total = 0
        self._last_line_s = time.monotonic()
        self._bar = progress(console, MofNCompleteColumn(), TimeElapsedColumn())
        self._task = self._bar.add_task("simulating", total=None)

    def __enter__(self) -> "EvaluationProgress":
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def show(self, what: str, done: int, of: int) -> None:
        """``done`` voyages of ``of`` are finished, the last of ``what``."""
        self.done, self.total = done, of
        self._bar.update(self._task, description=what or "simulating", completed=done, total=of)
        now = time.monotonic()
        if not self.console.is_terminal and now - self._last_line_s > _LINE_S:
            self._last_line_s = now
            self.console.say(f"{done} of {of}: {what}")
