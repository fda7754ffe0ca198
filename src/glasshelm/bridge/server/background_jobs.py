"""What may take long (programs are compiled) is done apart, one thing at a time."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from glasshelm.bridge.server import protocol as m

Result = TypeVar("Result")
Told = tuple[str, bytes]


class BackgroundJobs:
    """A second thread beside the voyage's; ``tell`` lets all viewers know what it is busy with."""

    def __init__(self, tell: Callable[[list[Told]], None]):
        self._tell = tell
        self._lock, self._name, self._what = asyncio.Lock(), "", ""
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="prepare")

    @property
    def snapshot(self) -> list[Told]:
        """What a viewer who comes now has to be told."""
        return [_message(self._what)] if self._what else []

    @contextlib.asynccontextmanager
    async def announce(self, what: str) -> AsyncIterator[None]:
        """One at a time; all viewers are told of it."""
        async with self._lock:
            self._loop, self._name = asyncio.get_running_loop(), what
            self._say(what)
            try:
                yield
            finally:
                self._name = ""
                self._say("")

    def report_progress(self, done: float) -> None:
        """Tell how much of it is done (0 to 1); called in the thread."""
        name = self._name
        if self._loop is not None and name:
            self._loop.call_soon_threadsafe(self._progress, name, done)

    def _progress(self, name: str, done: float) -> None:
        if name == self._name:  # not over by now
            self._say(f"{name} ({done:.0%})")

    def _say(self, what: str) -> None:
        self._what = what
        self._tell([_message(what or None)])

    async def run(
        self, job: Callable[[], Result], unwanted: Callable[[Result], object] | None = None
    ) -> Result:
        """The result of a job in the thread.

        If nobody waits for it any more it is not begun; of one begun the result is ``unwanted``.
        """
        future = self._thread.submit(job)
        try:
            return await asyncio.wrap_future(future)
        except asyncio.CancelledError:
            if unwanted is not None:
                future.add_done_callback(lambda done: _dispose(done, unwanted))
            raise

    async def wait_idle(self) -> None:
        """Wait until nothing is being prepared."""
        async with self._lock:
            pass

    def close(self) -> None:
        """Begin nothing more. A compiler cannot be stopped, and is not waited for."""
        self._thread.shutdown(wait=False, cancel_futures=True)


def _dispose(done: Future[Result], unwanted: Callable[[Result], object]) -> None:
    if not done.cancelled() and done.exception() is None:
        unwanted(done.result())


def _message(what: str | None) -> Told:
    return "preparing", m.encode(m.Preparing(what))
