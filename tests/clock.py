"""Time that a test need not wait for: the same on any machine, however busy."""

import asyncio
import types
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

Result = TypeVar("Result")


class Clockwork(asyncio.SelectorEventLoop):
    """An event loop whose time passes only while all wait, and then at once.

    It has no threads: what would be given to one is a coroutine function, which may wait too.
    """

    def __init__(self) -> None:
        super().__init__()
        self._now_s = 0.0
        select = self._selector.select  # type: ignore[attr-defined]

        def skip(timeout: float | None = None) -> list[Any]:
            found = select(0.0 if timeout else timeout)
            if timeout and not found:
                self._now_s += timeout
            return found

        self._selector.select = skip  # type: ignore[attr-defined]

    def time(self) -> float:
        """Seconds since it began."""
        return self._now_s

    def run_in_executor(self, executor: Any, func: Callable[..., Any], *args: Any) -> Any:
        return self.create_task(func(*args))


def run(work: Coroutine[Any, Any, Result]) -> Result:
    """As ``asyncio.run``, in no time."""
    with asyncio.Runner(loop_factory=Clockwork) as runner:
        return runner.run(work)


def now_s() -> float:
    """The time of the loop that runs."""
    return asyncio.get_running_loop().time()


#: In place of the module ``time``.
clock = types.SimpleNamespace(monotonic=now_s)
