"""What one viewer has asked for and is not done: bounded, and begun only while she stays."""

import asyncio
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any

from glasshelm.core.errors import InputError

#: Requests of one viewer that wait at once; of more she is not read until there is room.
MAX_REQUESTS = 32
#: Those of them for which a session or a pilot is prepared.
MAX_SLOW_REQUESTS = 4
#: Questions of one viewer that wait for their answer at once.
MAX_QUESTIONS = 2


class RequestQueue:
    """``take`` a request: it is done when those before it are. ``ask`` a question beside them.

    ``requests`` and ``questions`` hold what is not done yet, of all viewers.
    """

    def __init__(self, requests: set[asyncio.Task[None]], questions: set[asyncio.Task[None]]):
        self._requests, self._questions = requests, questions
        self._own: set[asyncio.Task[None]] = set()
        self._turn = asyncio.Lock()  # first come, first served
        self._room = asyncio.Semaphore(MAX_REQUESTS)
        self._prepared = self._asked = 0

    async def submit(self, request: Callable[[], Awaitable[None]], prepared: bool = False) -> None:
        """Returns at once, unless too many wait already. InputError for too many ``prepared``."""
        if prepared and self._prepared >= MAX_SLOW_REQUESTS:
            raise InputError(
                f"{MAX_SLOW_REQUESTS} of your requests are being prepared or wait for it: "
                "wait until one is done"
            )
        self._prepared += prepared
        await self._room.acquire()
        task = self._begin(self._done(request), self._requests)
        task.add_done_callback(lambda _: self._over(prepared))

    def submit_question(self, question: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Begin to answer. InputError where too many of hers wait already."""
        if self._asked >= MAX_QUESTIONS:
            raise InputError("too many questions at once: wait for the answers")
        self._asked += 1
        self._begin(question(), self._questions).add_done_callback(lambda _: self._answered())

    def cancel(self) -> None:
        """She has left: what waits is not begun."""
        for task in self._own:
            task.cancel()

    async def _done(self, request: Callable[[], Awaitable[None]]) -> None:
        async with self._turn:
            await request()

    def _begin(
        self, work: Coroutine[Any, Any, None], among: set[asyncio.Task[None]]
    ) -> asyncio.Task[None]:
        task = asyncio.create_task(work)
        for tasks in (among, self._own):
            tasks.add(task)
            task.add_done_callback(tasks.discard)
        return task

    def _over(self, prepared: bool) -> None:
        self._prepared -= prepared
        self._room.release()

    def _answered(self) -> None:
        self._asked -= 1
