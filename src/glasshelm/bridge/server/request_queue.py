"""The unfinished requests of one viewer: bounded, and dropped when the viewer leaves."""

import asyncio
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any

from glasshelm.core.errors import InputError

#: Requests of one viewer that wait at once; beyond that the viewer is not read.
MAX_REQUESTS = 32
#: Of these, requests that need a session or a pilot to be prepared.
MAX_SLOW_REQUESTS = 4
#: Questions of one viewer that wait for an answer at once.
MAX_QUESTIONS = 2

Tasks = set[asyncio.Task[None]]


class RequestQueue:
    """Runs requests in order, and questions beside them.

    ``requests`` and ``questions`` are the unfinished ones of all viewers.
    """

    def __init__(self, requests: Tasks, questions: Tasks):
        self._requests, self._questions = requests, questions
        self._own: Tasks = set()
        self._turn = asyncio.Lock()  # first come, first served
        self._free = asyncio.Semaphore(MAX_REQUESTS)
        self._n_slow = self._n_questions = 0

    async def submit(self, request: Callable[[], Awaitable[None]], slow: bool = False) -> None:
        """Queue a request; waits only while too many wait. InputError for too many slow ones."""
        if slow and self._n_slow >= MAX_SLOW_REQUESTS:
            raise InputError(
                f"{MAX_SLOW_REQUESTS} of your requests are being prepared or wait for it: "
                "wait until one is done"
            )
        self._n_slow += slow
        await self._free.acquire()

        def finished(_: object) -> None:
            self._n_slow -= slow
            self._free.release()

        self._start(self._in_turn(request), self._requests).add_done_callback(finished)

    def submit_question(self, question: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Start to answer a question. InputError for too many."""
        if self._n_questions >= MAX_QUESTIONS:
            raise InputError("too many questions at once: wait for the answers")
        self._n_questions += 1

        def finished(_: object) -> None:
            self._n_questions -= 1

        self._start(question(), self._questions).add_done_callback(finished)

    def cancel(self) -> None:
        """Drop what is unfinished: the viewer has left."""
        for task in self._own:
            task.cancel()

    async def _in_turn(self, request: Callable[[], Awaitable[None]]) -> None:
        async with self._turn:
            await request()

    def _start(self, work: Coroutine[Any, Any, None], group: Tasks) -> asyncio.Task[None]:
        task = asyncio.create_task(work)
        for tasks in (group, self._own):
            tasks.add(task)
            task.add_done_callback(tasks.discard)
        return task
