"""Requests of one viewer, done in the order in which she made them while she can go on speaking."""

import asyncio
from collections.abc import Awaitable, Callable

#: Requests of one viewer that wait at once; of more she is not read until there is room.
MOST_REQUESTS = 32


class Turns:
    """``take`` a request: it is done when those before it are, whether or not she stays.

    ``tasks`` holds what is not done yet, of all viewers.
    """

    def __init__(self, tasks: set[asyncio.Task[None]]):
        self._tasks = tasks
        self._turn = asyncio.Lock()  # first come, first served
        self._room = asyncio.Semaphore(MOST_REQUESTS)

    async def take(self, request: Callable[[], Awaitable[None]]) -> None:
        """Returns at once, unless too many wait already."""
        await self._room.acquire()
        task = asyncio.create_task(self._done(request))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _done(self, request: Callable[[], Awaitable[None]]) -> None:
        try:
            async with self._turn:
                await request()
        finally:
            self._room.release()
