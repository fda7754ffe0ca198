"""Jobs that may take long (programs are compiled), one at a time in a thread of their own."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from glasshelm.bridge.server.protocol import Outgoing, Preparing, encode

Result = TypeVar("Result")


class BackgroundJobs:
    """Runs jobs beside the session; ``broadcast`` tells all viewers which one is running."""

    def __init__(self, broadcast: Callable[[list[Outgoing]], None]):
        self._broadcast = broadcast
        self._lock, self._name, self._shown = asyncio.Lock(), "", ""
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="prepare")

    @property
    def snapshot(self) -> list[Outgoing]:
        """What a viewer who joins now is sent."""
        return [encode(Preparing(self._shown))] if self._shown else []

    @contextlib.asynccontextmanager
    async def announce(self, name: str) -> AsyncIterator[None]:
        """Wait for other jobs, then show this name to all viewers until the block ends."""
        async with self._lock:
            self._loop, self._name = asyncio.get_running_loop(), name
            self._show(name)
            try:
                yield
            finally:
                self._name = ""
                self._show("")

    def report_progress(self, share: float) -> None:
        """Show which share of the job is done (0 to 1); called in the thread."""
        name = self._name
        if self._loop is not None and name:
            self._loop.call_soon_threadsafe(self._show_progress, name, share)

    def _show_progress(self, name: str, share: float) -> None:
        if name == self._name:  # it is still running
            self._show(f"{name} ({share:.0%})")

    def _show(self, text: str) -> None:
        self._shown = text
        self._broadcast([encode(Preparing(text or None))])

    async def run(
        self, job: Callable[[], Result], discard: Callable[[Result], object] | None = None
    ) -> Result:
        """Run a job in the thread and return its result.

        If the caller is cancelled a waiting job is not started, and the result of a running one is
        passed to ``discard``.
        """
        future = self._thread.submit(job)
        try:
            return await asyncio.wrap_future(future)
        except asyncio.CancelledError:
            if discard is not None:
                future.add_done_callback(lambda done: _discard(done, discard))
            raise

    async def wait_idle(self) -> None:
        """Wait until no job is running."""
        async with self._lock:
            pass

    def close(self) -> None:
        """Start nothing more. A compiler cannot be stopped, and is not waited for."""
        self._thread.shutdown(wait=False, cancel_futures=True)


def _discard(done: Future[Result], discard: Callable[[Result], object]) -> None:
    if not done.cancelled() and done.exception() is None:
        discard(done.result())
