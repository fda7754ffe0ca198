"""Limits how much strangers can make the server write to the terminal."""

import asyncio
import logging
import time
from typing import Any

#: Lines of a logger that are written in a minute at most.
MAX_LINES_PER_MINUTE = 20
_LOGGERS = ("asyncio", "uvicorn.error", "glasshelm.bridge")
_log = logging.getLogger("glasshelm.bridge")


class RateLimitFilter(logging.Filter):
    """Drops lines beyond a number a minute; the next line says how many were dropped."""

    def __init__(self, max_lines: int = MAX_LINES_PER_MINUTE):
        super().__init__()
        self._max_lines, self._n_written, self._n_dropped = max_lines, 0, 0
        self._since = time.monotonic()

    def filter(self, record: logging.LogRecord) -> bool:
        now = time.monotonic()
        if now - self._since >= 60.0:
            self._since, self._n_written = now, 0
        if self._n_written >= self._max_lines:
            self._n_dropped += 1
            return False
        self._n_written += 1
        if self._n_dropped:
            record.msg = f"{record.getMessage()} ({self._n_dropped} lines were left out before)"
            record.args = None
            self._n_dropped = 0
        return True


def install() -> None:
    """Limit the server's loggers, and log what the system refuses (files, memory) as one line.

    Call it in the running event loop.
    """
    for name in _LOGGERS:
        logger = logging.getLogger(name)
        if not any(isinstance(each, RateLimitFilter) for each in logger.filters):
            logger.addFilter(RateLimitFilter())
    asyncio.get_running_loop().set_exception_handler(_log_os_error)


def _log_os_error(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    error = context.get("exception")
    if isinstance(error, OSError):
        _log.error("%s: %s", context.get("message", "the server"), error)
    else:
        loop.default_exception_handler(context)
