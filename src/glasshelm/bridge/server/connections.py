"""The connections of the server, bounded: how many, how long, and how much for each.

uvicorn speaks HTTP and WebSocket, but lets a connection that never asks for anything stay, answers
pings of a client that does not read, and reads as much as is sent. Here are its two protocols with
these bounds; docs/bridge.md has them in a table.
"""

import asyncio
import dataclasses
from collections import Counter
from typing import Any, cast

import h11
import uvicorn
from starlette.applications import Starlette
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from glasshelm.bridge.server.protocol import MAX_REQUEST_BYTES

#: A connection brings a whole request within so long, at first and after each answer [s].
REQUEST_TIMEOUT_S = 10.0
#: It takes the answer to it within so long [s].
RESPONSE_TIMEOUT_S = 120.0
#: Longer messages close the socket [bytes]; those a little too long are answered in words.
MAX_MESSAGE_BYTES = 16 * MAX_REQUEST_BYTES
#: So many bytes of a viewer are read at once.
READ_BYTES = 4096
#: Fragments of one message at most.
MAX_FRAGMENTS = 64
#: WebSocket frames (pings, fragments) or pieces read of a viewer: at once, and lasting [1/s].
BURST_FRAMES, FRAMES_PER_S = 200, 50
#: A viewer for whom something waits, and who takes nothing of it for so long, is dropped [s].
STALL_TIMEOUT_S = 30.0
#: How often that is looked at [s].
STALL_CHECK_S = 5.0

#: Files that the rest of the program has open at most: logs, feeds, libraries.
_OTHER_FILES = 64


@dataclasses.dataclass(frozen=True)
class ConnectionLimits:
    """For how many connections there is room.

    ``viewers`` look on; ``waiting`` have not become viewers (they ask for the page, or
    for nothing); ``backlog`` are accepted at once, before any is looked at.
    """

    viewers: int = 100
    waiting: int = 64
    backlog: int = 32

    @staticmethod
    def for_files(most: int) -> "ConnectionLimits":
        """As much of it as so many open files allow: a server out of files answers nobody."""
        share = max((most - _OTHER_FILES) // 16, 1)
        # As many as four times the backlog are open before the first of them is closed.
        return ConnectionLimits(min(100, 8 * share), min(64, 4 * share), min(32, share))


class PendingConnections:
    """Those that are no viewers yet: each has a deadline, and of too many the oldest goes.

    It is the oldest of the address that has most of them, so that who floods the server crowds
    out himself. A browser is a viewer long before it is the oldest.
    """

    def __init__(self, most: int):
        self._most = most
        self._waiting: dict[asyncio.Transport, str] = {}
        self._deadlines: dict[asyncio.Transport, asyncio.TimerHandle] = {}

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, transport: asyncio.Transport) -> None:
        """A new connection."""
        self._waiting[transport] = str((transport.get_extra_info("peername") or ("",))[0])
        self.set_deadline(transport, REQUEST_TIMEOUT_S)
        if len(self._waiting) > self._most:
            crowd = Counter(self._waiting.values())
            most = max(crowd.values())
            oldest = next(one for one, host in self._waiting.items() if crowd[host] == most)
            self.remove(oldest)
            oldest.abort()

    def set_deadline(self, transport: asyncio.Transport, seconds: float) -> None:
        """It is closed if nothing else is expected of it, or it has not gone, within so long."""
        if transport in self._waiting:
            if transport in self._deadlines:
                self._deadlines[transport].cancel()
            loop = asyncio.get_running_loop()
            self._deadlines[transport] = loop.call_later(seconds, transport.abort)

    def remove(self, transport: asyncio.Transport) -> None:
        """It has become a viewer, or is closed."""
        self._waiting.pop(transport, None)
        deadline = self._deadlines.pop(transport, None)
        if deadline is not None:
            deadline.cancel()


class ServerConfig(uvicorn.Config):
    """How the bridge is served."""

    def __init__(self, app: Starlette, room: ConnectionLimits | None = None):
        room = ConnectionLimits() if room is None else room
        self.waiting = PendingConnections(room.waiting)
        super().__init__(
            app,
            http=HttpConnection,
            ws=SocketConnection,
            # What clients do wrong is told to them, and would fill the terminal.
            log_config=None,
            log_level="error",
            access_log=False,
            lifespan="on",
            backlog=room.backlog,
            ws_max_size=MAX_MESSAGE_BYTES,
            # Compressing for each viewer alone costs more than a local network does.
            ws_per_message_deflate=False,
            # A busy computer may take long to say that it is there; a page asks more often.
            ws_ping_timeout=60,
            timeout_graceful_shutdown=2,
            server_header=False,
        )


class HttpConnection(H11Protocol):
    """HTTP with deadlines."""

    @property
    def _waiting(self) -> PendingConnections:
        return cast(ServerConfig, self.config).waiting

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(cast(asyncio.Transport, transport))
        self._waiting.add(self.transport)

    def connection_lost(self, exc: Exception | None) -> None:
        self._waiting.remove(self.transport)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        before = self.cycle
        super().data_received(data)
        self._expect_answer(before)

    def on_response_complete(self) -> None:
        before = self.cycle
        self._waiting.set_deadline(self.transport, REQUEST_TIMEOUT_S)
        super().on_response_complete()
        self._expect_answer(before)

    def send_400_response(self, msg: str) -> None:
        if self.cycle is not None:
            self.cycle.disconnected = True  # a request whose body is none is not answered twice
        try:
            super().send_400_response(msg)
        except h11.LocalProtocolError:  # another answer has begun
            self.transport.abort()

    def _expect_answer(self, before: object) -> None:
        if self.cycle is not before:  # a request has come
            self._waiting.set_deadline(self.transport, RESPONSE_TIMEOUT_S)


class SocketConnection(WebSocketsSansIOProtocol, asyncio.BufferedProtocol):
    """A WebSocket that reads little at once, and nothing while what it has sent is not taken."""

    def __init__(self, *args: Any, **kwargs: Any):
        super().__init__(*args, **kwargs)
        self._piece = bytearray(READ_BYTES)
        self._spent, self._spent_at = 0.0, self.loop.time()
        self._throttle: asyncio.TimerHandle | None = None
        self._look: asyncio.TimerHandle | None = None
        self._unsent, self._stalled_s = 0, 0.0

    @property
    def _waiting(self) -> PendingConnections:
        return cast(ServerConfig, self.config).waiting

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self.transport.pause_reading()  # until it is accepted

    def connection_lost(self, exc: Exception | None) -> None:
        self._waiting.remove(self.transport)
        for timer in (self._throttle, self._look):
            if timer is not None:
                timer.cancel()
        super().connection_lost(exc)

    def start_keepalive(self) -> None:
        """Called when the viewer has been accepted."""
        super().start_keepalive()
        self._waiting.remove(self.transport)
        self._look_again()
        self._read_or_wait()

    def get_buffer(self, sizehint: int) -> bytearray:
        return self._piece

    def buffer_updated(self, nbytes: int) -> None:
        self.data_received(bytes(self._piece[:nbytes]))

    def data_received(self, data: bytes) -> None:
        self._spend(1)
        super().data_received(data)
        if len(self.frames) > MAX_FRAGMENTS:
            self._fail(1008, f"a message in more than {MAX_FRAGMENTS} fragments")
        self._read_or_wait()

    def handle_events(self) -> None:
        self._spend(len(self.conn.events))
        super().handle_events()

    def send_receive_event_to_app(self) -> None:
        if self.curr_msg_data_type == "text":
            try:
                b"".join(self.frames).decode()
            except UnicodeDecodeError:
                self._fail(1007, "a text that is not UTF-8")
                return
        super().send_receive_event_to_app()

    def pause_writing(self) -> None:
        super().pause_writing()
        self._read_or_wait()

    def resume_writing(self) -> None:
        super().resume_writing()
        self._read_or_wait()

    async def receive(self) -> Any:
        message = await self.queue.get()
        if self.queue.empty():
            self.read_paused = False
            self._read_or_wait()
        return message

    async def send(self, message: Any) -> None:
        await self.writable.wait()
        if self.close_sent and message["type"] == "websocket.send":
            raise ClientDisconnected
        await super().send(message)

    def _fail(self, code: int, reason: str) -> None:
        self.frames = []
        if not self.transport.is_closing():
            self.conn.fail(code, reason)
            self.handle_parser_exception()

    def _read_or_wait(self) -> None:
        """Read on unless a message waits for the server, or what was sent for the viewer."""
        held = self.read_paused or self._throttle is not None or not self.writable.is_set()
        if held or not self.handshake_complete:
            self.transport.pause_reading()
        else:
            self.transport.resume_reading()

    def _spend(self, frames: int) -> None:
        """Read nothing more for a while if there were too many."""
        now = self.loop.time()
        self._spent = max(self._spent - FRAMES_PER_S * (now - self._spent_at), 0.0) + frames
        self._spent_at = now
        over = self._spent - BURST_FRAMES
        if over > 0:
            if self._throttle is not None:
                self._throttle.cancel()
            self._throttle = self.loop.call_later(over / FRAMES_PER_S, self._go_on)

    def _go_on(self) -> None:
        self._throttle = None
        self._read_or_wait()

    def _look_again(self) -> None:
        """Drop the viewer if for long nothing of what waits for her has been taken."""
        unsent = self.transport.get_write_buffer_size()
        waits = unsent > 0 and (self.transport.is_closing() or not self.writable.is_set())
        self._stalled_s = (
            self._stalled_s + STALL_CHECK_S if waits and unsent >= self._unsent else 0.0
        )
        self._unsent = unsent
        if self._stalled_s >= STALL_TIMEOUT_S:
            self.transport.abort()
        else:
            self._look = self.loop.call_later(STALL_CHECK_S, self._look_again)
