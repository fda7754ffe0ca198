"""The messages one viewer has yet to be sent: bounded, however slowly it reads."""

import asyncio
from collections import deque

from glasshelm.bridge.server.protocol import Outgoing, Role

#: Frames that wait for one viewer at most; the oldest are dropped.
MAX_FRAMES = 8
#: Other messages that wait at most.
MAX_OTHERS = 32
#: Bytes that wait at most, beside the newest of each kind; the oldest are dropped.
MAX_BYTES = 16_000_000
#: Of these only the newest counts.
_LATEST_ONLY = ("hello", "preparing", "session", "alarms", "band")
#: Each of these counts.
_OTHERS = ("error", "notice", "whatif", "pong")


class ViewerQueue:
    """Messages in order for one viewer; ``dropped`` counts the frames that were dropped.

    A new history replaces the frames that wait and their band; a new session, list of alarms or
    band replaces the old one.
    """

    def __init__(self, role: Role = "owner") -> None:
        self.role: Role = role
        self.dropped = 0
        self._waiting: deque[Outgoing] = deque()
        self._not_empty = asyncio.Event()

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, message: Outgoing) -> None:
        """Add a message; called in the event loop."""
        if message.kind == "history":
            self._drop("history", "frame", "band")
        elif message.kind in _LATEST_ONLY:
            self._drop(message.kind)
        elif message.kind == "frame":
            self.dropped += self._make_room(("frame",), MAX_FRAMES)
        else:
            self._make_room(_OTHERS, MAX_OTHERS)
        self._waiting.append(message)
        self._limit_bytes()
        self._not_empty.set()

    async def get(self) -> bytes:
        """Return the next message, as soon as there is one."""
        while not self._waiting:
            self._not_empty.clear()
            await self._not_empty.wait()
        return self._waiting.popleft().data

    @property
    def bytes(self) -> int:
        """The size of what waits."""
        return sum(len(message.data) for message in self._waiting)

    def _limit_bytes(self) -> None:
        """Drop the oldest frames first, then other messages; the newest of each stays."""
        for kinds in (("frame",), _OTHERS):
            for message in self._of(kinds)[:-1]:
                if self.bytes <= MAX_BYTES:
                    return
                self._waiting.remove(message)
                self.dropped += message.kind == "frame"

    def _drop(self, *kinds: str) -> None:
        self._waiting = deque(message for message in self._waiting if message.kind not in kinds)

    def _make_room(self, kinds: tuple[str, ...], limit: int) -> int:
        """Make room for one more of these kinds; return how many were dropped."""
        waiting = self._of(kinds)
        excess = waiting[: max(len(waiting) - limit + 1, 0)]
        for message in excess:
            self._waiting.remove(message)
        return len(excess)

    def _of(self, kinds: tuple[str, ...]) -> list[Outgoing]:
        return [message for message in self._waiting if message.kind in kinds]
