"""What is failing while the server runs: reported until it recovers, and never the end of it."""

import asyncio
import contextlib
import logging
import re
from collections.abc import Awaitable, Callable, Iterator
from concurrent.futures import CancelledError
from typing import TypeVar

from glasshelm.core.errors import InputError
from glasshelm.feeds.connection import Backoff

Result = TypeVar("Result")

#: A task that was restarted and has run for so long [s] has recovered.
RECOVERED_S = 5.0
#: So many characters of an unexpected error are shown.
_MAX_LENGTH = 200
_FOLDERS = re.compile(r"(?:[A-Za-z]:)?(?:[\\/][^\s\\/'\":]+)+[\\/]")
_log = logging.getLogger("glasshelm.bridge")


def describe_error(error: BaseException) -> str:
    """Describe an error in one short line that names no folder."""
    if isinstance(error, InputError):
        return str(error)
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    text = _FOLDERS.sub("", " ".join(str(error).split()))
    name = type(error).__name__
    return f"{name}: {text}"[:_MAX_LENGTH] if text else name


class FaultLog:
    """What is failing now, by part: the page and ``/api/health`` show it until it recovers.

    Thread-safe.
    """

    def __init__(self) -> None:
        self._faults: dict[str, str] = {}

    def __contains__(self, part: str) -> bool:
        return part in self._faults

    @property
    def messages(self) -> list[str]:
        """One line for each part that fails."""
        return list(self._faults.values())

    def record(self, part: str, error: BaseException, action: str = "retrying") -> str:
        """Record that a part failed and what is done about it; return the message.

        The traceback is logged once.
        """
        expected = isinstance(error, InputError)
        message = str(error) if expected else f"{part} failed ({describe_error(error)}): {action}"
        if self._faults.get(part) != message:
            if expected:
                _log.warning("%s", message)
            else:
                _log.error("%s", message, exc_info=error)
        self._faults[part] = message
        return message

    def clear(self, part: str) -> None:
        """Record that a part works."""
        if self._faults.pop(part, None) is not None:
            _log.warning("%s: recovered", part)

    @contextlib.contextmanager
    def contain(self, part: str) -> Iterator[None]:
        """Record a failure of the block instead of raising it."""
        try:
            yield
        except Exception as error:
            self.record(part, error)
        else:
            self.clear(part)


async def supervise(
    part: str,
    run: Callable[[], Awaitable[None]],
    faults: FaultLog,
    on_fault: Callable[[str], None] = lambda message: None,
) -> None:
    """Run a task that should run for ever; restart it where it fails, after ever longer waits.

    Returns when the task returns. ``on_fault`` is called with each new message.
    """
    loop, backoff, last_message = asyncio.get_running_loop(), Backoff(), ""
    while True:
        start = loop.time()
        recovery = loop.call_later(RECOVERED_S, faults.clear, part)
        try:
            await run()
            faults.clear(part)
            return
        except Exception as error:
            message = faults.record(part, error)
        finally:
            recovery.cancel()
        if message != last_message:
            on_fault(message)
        last_message = message
        if loop.time() - start > RECOVERED_S:
            backoff.succeeded()
        await backoff.wait()


def run_isolated(job: Callable[[], Result]) -> Result:
    """Run a job in a thread so that its failure neither ends nor cancels the task that waits."""
    try:
        return job()
    except Exception as error:
        if isinstance(error, StopIteration | CancelledError):
            raise RuntimeError(type(error).__name__) from error
        raise
    except BaseException as error:
        raise RuntimeError(type(error).__name__) from error
