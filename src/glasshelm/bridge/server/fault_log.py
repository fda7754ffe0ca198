"""What goes wrong while the server runs: told until it is over, and never the end of the watch."""

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

#: A task that was begun again and has run for so long [s] is well.
HEALED_S = 5.0
#: Of what an unexpected error says, so much is told.
_LONGEST = 200
_FOLDERS = re.compile(r"(?:[A-Za-z]:)?(?:[\\/][^\s\\/'\":]+)+[\\/]")
_log = logging.getLogger("glasshelm.bridge")


def one_line(error: BaseException) -> str:
    """An error as one short line that names no folder."""
    if isinstance(error, InputError):
        return str(error)
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    text = _FOLDERS.sub("", " ".join(str(error).split()))
    name = type(error).__name__
    return f"{name}: {text}"[:_LONGEST] if text else name


class Faults:
    """What is failing now, by its part: the notes and ``/api/health`` tell it until it heals.

    May be used by any thread.
    """

    def __init__(self) -> None:
        self._now: dict[str, str] = {}

    def __contains__(self, part: str) -> bool:
        return part in self._now

    @property
    def told(self) -> list[str]:
        """One line for each part that fails."""
        return list(self._now.values())

    def fails(self, part: str, error: BaseException, then: str = "it is tried again") -> str:
        """A part has failed; returns the message about it. Its traceback is logged once."""
        expected = isinstance(error, InputError)
        told = str(error) if expected else f"{part} failed ({one_line(error)}): {then}"
        if self._now.get(part) != told:
            if expected:
                _log.warning("%s", told)
            else:
                _log.error("%s", told, exc_info=error)
        self._now[part] = told
        return told

    def heals(self, part: str) -> None:
        """A part has done its work."""
        if self._now.pop(part, None) is not None:
            _log.warning("%s: well again", part)

    @contextlib.contextmanager
    def contained(self, part: str) -> Iterator[None]:
        """Failures within are reported, and go no further."""
        try:
            yield
        except Exception as error:
            self.fails(part, error)
        else:
            self.heals(part)


async def supervised(
    part: str,
    run: Callable[[], Awaitable[None]],
    faults: Faults,
    told: Callable[[str], None] = lambda text: None,
) -> None:
    """Run what is meant to run for ever; where it fails it is begun again, after longer waits.

    Ends when it ends by itself, or is cancelled. ``told`` is called with each new reason.
    """
    loop, backoff, before = asyncio.get_running_loop(), Backoff(), ""
    while True:
        begun = loop.time()
        healing = loop.call_later(HEALED_S, faults.heals, part)
        try:
            await run()
            faults.heals(part)
            return
        except Exception as error:
            text = faults.fails(part, error)
        finally:
            healing.cancel()
        if text != before:
            told(text)
        before = text
        if loop.time() - begun > HEALED_S:
            backoff.succeeded()
        await backoff.wait()


def bounded(job: Callable[[], Result]) -> Result:
    """A job for a thread, whose failure is only its own: it neither ends nor cancels a task."""
    try:
        return job()
    except Exception as error:
        if isinstance(error, StopIteration | CancelledError):
            raise RuntimeError(type(error).__name__) from error
        raise
    except BaseException as error:
        raise RuntimeError(type(error).__name__) from error
