"""The server's own lines on the terminal, of which strangers must not cause many."""

import asyncio
import logging
import time
from typing import Any

#: Lines of a logger that are written in a minute at most.
MAX_LINES_PER_MINUTE = 20
_MINUTE_S = 60.0
_LOGGERS = ("asyncio", "uvicorn.error", "glasshelm.bridge")
_log = logging.getLogger("glasshelm.bridge")


class RateLimitFilter(logging.Filter):
    """Leaves out what is beyond ``most`` lines a minute; the next one says how many that were."""

    def __init__(self, most: int = MAX_LINES_PER_MINUTE):
        super().__init__()
        self._most, self._written, self._left_out = most, 0, 0
        self._since = time.monotonic()

    def filter(self, record: logging.LogRecord) -> bool:
        now = time.monotonic()
        if now - self._since >= _MINUTE_S:
            self._since, self._written = now, 0
        if self._written >= self._most:
            self._left_out += 1
            return False
        self._written += 1
        if self._left_out:
            record.msg = f"{record.getMessage()} ({self._left_out} lines were left out before)"
            record.args = None
            self._left_out = 0
        return True


def install() -> None:
    """From now on, in the running event loop. What the system refuses (files, memory) is a line."""
    for name in _LOGGERS:
        logger = logging.getLogger(name)
        if not any(isinstance(one, RateLimitFilter) for one in logger.filters):
            logger.addFilter(RateLimitFilter())
    asyncio.get_running_loop().set_exception_handler(_one_line)


def _one_line(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    error = context.get("exception")
    if isinstance(error, OSError):
        _log.error("%s: %s", context.get("message", "the server"), error)
    else:
        loop.default_exception_handler(context)
