"""What one viewer is still to be sent: bounded, however slow she reads."""

import asyncio
from collections import deque

from glasshelm.bridge.server.protocol import Role

#: Frames that wait for one viewer at most; of more, the oldest are left out.
MAX_FRAMES = 8
#: Other messages that wait at most.
MAX_OTHERS = 32
#: Bytes that wait at most, beside the newest of each kind; of more, the oldest are left out.
MAX_BYTES = 16_000_000
#: Of these only the newest means anything.
_NEWEST = ("hello", "preparing", "session", "alarms", "band")
#: Each of these means something.
_OTHERS = ("failure", "notice", "whatif", "pong")


class ViewerQueue:
    """Messages in order, each of a kind, for somebody of a ``role``; ``dropped`` counts the frames
    left out.

    A new history replaces the frames that wait, and the band of one of them; a new session, list
    of alarms or band the old one.
    """

    def __init__(self, role: Role = "owner") -> None:
        self.role: Role = role
        self.dropped = 0
        self._waiting: deque[tuple[str, bytes]] = deque()
        self._some = asyncio.Event()

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, kind: str, message: bytes) -> None:
        """Add a message; called in the event loop."""
        if kind == "history":
            self._leave_out("history", "frame", "band")
        elif kind in _NEWEST:
            self._leave_out(kind)
        elif kind == "frame":
            self.dropped += self._leave_out_oldest(("frame",), MAX_FRAMES)
        else:
            self._leave_out_oldest(_OTHERS, MAX_OTHERS)
        self._waiting.append((kind, message))
        self._leave_out_bytes()
        self._some.set()

    async def get(self) -> bytes:
        """The next message, as soon as there is one."""
        while not self._waiting:
            self._some.clear()
            await self._some.wait()
        return self._waiting.popleft()[1]

    @property
    def bytes(self) -> int:
        """How much waits."""
        return sum(len(message) for _, message in self._waiting)

    def _leave_out_bytes(self) -> None:
        """The oldest frames go first, then other messages; the newest of each stays."""
        for kinds in (("frame",), _OTHERS):
            here = [item for item in self._waiting if item[0] in kinds]
            for item in here[:-1]:
                if self.bytes <= MAX_BYTES:
                    return
                self._waiting.remove(item)
                self.dropped += item[0] == "frame"

    def _leave_out(self, *kinds: str) -> None:
        self._waiting = deque(item for item in self._waiting if item[0] not in kinds)

    def _leave_out_oldest(self, kinds: tuple[str, ...], most: int) -> int:
        """Make room for one more of these kinds; how many were left out."""
        here = [item for item in self._waiting if item[0] in kinds]
        over = here[: max(len(here) - most + 1, 0)]
        for item in over:
            self._waiting.remove(item)
        return len(over)
