"""What a command says to people: the terminal gets text, and never an order hidden in a name.

With ``GLASSHELM_DEBUG`` set, tracebacks and the warnings of libraries are shown as well.
"""

import io
import logging
import os
import sys
import threading
import warnings
from typing import Any

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    Task,
    TaskProgressColumn,
    TextColumn,
)
from rich.progress import TimeRemainingColumn as TimeLeft
from rich.text import Text

from glasshelm.core.text import printable, printable_lines


class Terminal(Console):
    """Writes text as it is: no markup, no colours of its own, no control characters."""

    def __init__(self, stderr: bool = True, **options: Any):
        super().__init__(stderr=stderr, markup=False, emoji=False, highlight=False, **options)

    def render_str(self, text: str, **options: Any) -> Text:
        return super().render_str(printable_lines(text), **options)

    def say(self, text: str) -> None:
        """A message, not broken into lines: paths in it can be copied."""
        self.print(text, soft_wrap=True)


class TaskDescription(TextColumn):
    """What a task of a progress bar is doing."""

    def __init__(self) -> None:
        super().__init__("", markup=False)

    def render(self, task: Task) -> Text:
        return Text(printable(task.description))


def progress(console: Console, *figures: ProgressColumn) -> Progress:
    """A bar that disappears when its work is done; ``figures`` (a percentage) stand beside it."""
    columns = (
        TaskDescription(),
        BarColumn(bar_width=24),
        *(figures or (TaskProgressColumn(),)),
        TimeLeft(),
    )
    shown = console.is_terminal
    return Progress(*columns, console=console, transient=True, disable=not shown)


def print_result(text: str) -> None:
    """The result of a command, on standard output."""
    print(printable_lines(text))


def print_error(text: str) -> None:
    """What is wrong, in one line on standard error."""
    print(f"glasshelm: {printable(text)}", file=sys.stderr)


def debugging() -> bool:
    """Whether whoever started the command wants to see tracebacks."""
    return bool(os.environ.get("GLASSHELM_DEBUG"))


def as_program() -> None:
    """Set this process up as a command: libraries are quiet, a logged failure is one line.

    For a process of our own only: warnings and logging are the caller's where we are a library.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    if debugging():
        return
    if not sys.warnoptions:
        warnings.simplefilter("ignore")
    handler = logging.StreamHandler()
    handler.setFormatter(_OneLine())
    handler.addFilter(_ours_or_failed)
    logging.basicConfig(handlers=[handler], level=logging.WARNING)
    threading.excepthook = _failed


def _failed(args: threading.ExceptHookArgs) -> None:
    if args.exc_value is not None:
        logging.getLogger(__name__).error("a thread failed", exc_info=args.exc_value)


class _OneLine(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        text = record.getMessage()
        if record.exc_info and (error := record.exc_info[1]) is not None:
            text += f" ({type(error).__name__}: {error}; GLASSHELM_DEBUG=1 shows where)"
        return f"glasshelm: {printable(text)}"


def _ours_or_failed(record: logging.LogRecord) -> bool:
    return record.name.partition(".")[0] == "glasshelm" or record.levelno >= logging.ERROR
