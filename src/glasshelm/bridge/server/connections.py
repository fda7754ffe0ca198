"""Bounded connections: how many, for how long, and how much each may send.

uvicorn speaks HTTP and WebSocket, but keeps a connection that never asks for anything, answers
pings of a client that does not read, and reads whatever is sent. Here are its two protocols with
bounds; docs/reference/bridge.md lists them in a table.
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

#: A connection must send a whole request within so long, at first and after each response [s].
REQUEST_TIMEOUT_S = 10.0
#: It must take the response within so long [s].
RESPONSE_TIMEOUT_S = 120.0
#: Longer messages close the socket [bytes]; those above MAX_REQUEST_BYTES get an error message.
MAX_MESSAGE_BYTES = 16 * MAX_REQUEST_BYTES
#: So many bytes of a viewer are read at a time.
READ_BYTES = 4096
#: Fragments of one message at most.
MAX_FRAGMENTS = 64
#: WebSocket frames (pings, fragments) or reads of a viewer: at once, and sustained [1/s].
BURST_FRAMES, FRAMES_PER_S = 200, 50
#: A viewer that takes nothing of what waits for it for so long is dropped [s].
STALL_TIMEOUT_S = 30.0
#: How often that is checked [s].
STALL_CHECK_S = 5.0

#: Files that the rest of the program opens at most: logs, feeds, libraries.
_OTHER_FILES = 64


@dataclasses.dataclass(frozen=True)
class ConnectionLimits:
    """How many connections are served.

    Attributes:
        viewers: Viewers at once.
        pending: Connections that are no viewers yet: they ask for the page, or for nothing.
        backlog: Connections accepted at once, before any is looked at.
    """

    viewers: int = 100
    pending: int = 64
    backlog: int = 32

    @staticmethod
    def for_files(max_files: int) -> "ConnectionLimits":
        """Return what so many open files allow: a server out of files answers nobody."""
        share = max((max_files - _OTHER_FILES) // 16, 1)
        # As many as four times the backlog are open before the first of them is closed.
        return ConnectionLimits(min(100, 8 * share), min(64, 4 * share), min(32, share))


class PendingConnections:
    """Connections that are no viewers yet: each has a deadline, and there are at most so many.

    Of too many, the oldest connection of the address with the most is closed, so a flood crowds
    out itself. A browser is a viewer long before it is the oldest.
    """

    def __init__(self, limit: int):
        self._limit = limit
        self._hosts: dict[asyncio.Transport, str] = {}
        self._deadlines: dict[asyncio.Transport, asyncio.TimerHandle] = {}

    def __len__(self) -> int:
        return len(self._hosts)

    def add(self, transport: asyncio.Transport) -> None:
        """Add a new connection."""
        self._hosts[transport] = str((transport.get_extra_info("peername") or ("",))[0])
        self.set_deadline(transport, REQUEST_TIMEOUT_S)
        if len(self._hosts) > self._limit:
            counts = Counter(self._hosts.values())
            most = max(counts.values())
            oldest = next(each for each, host in self._hosts.items() if counts[host] == most)
            self.remove(oldest)
            oldest.abort()

    def set_deadline(self, transport: asyncio.Transport, seconds: float) -> None:
        """Close a pending connection after so long, unless it gets another deadline or leaves."""
        if transport in self._hosts:
            if transport in self._deadlines:
                self._deadlines[transport].cancel()
            loop = asyncio.get_running_loop()
            self._deadlines[transport] = loop.call_later(seconds, transport.abort)

    def remove(self, transport: asyncio.Transport) -> None:
        """Remove a connection that has become a viewer, or is closed."""
        self._hosts.pop(transport, None)
        deadline = self._deadlines.pop(transport, None)
        if deadline is not None:
            deadline.cancel()


class ServerConfig(uvicorn.Config):
    """The settings of uvicorn."""

    def __init__(self, app: Starlette, limits: ConnectionLimits = ConnectionLimits()):
        self.pending = PendingConnections(limits.pending)
        super().__init__(
            app,
            http=HttpConnection,
            ws=SocketConnection,
            # Errors of clients are sent to them; they would fill the terminal.
            log_config=None,
            log_level="error",
            access_log=False,
            lifespan="on",
            backlog=limits.backlog,
            ws_max_size=MAX_MESSAGE_BYTES,
            # Compressing for each viewer alone costs more than a local network does.
            ws_per_message_deflate=False,
            # A busy computer may take long to answer a ping; the page itself asks more often.
            ws_ping_timeout=60,
            timeout_graceful_shutdown=2,
            server_header=False,
        )


class HttpConnection(H11Protocol):
    """HTTP with deadlines."""

    @property
    def _pending(self) -> PendingConnections:
        return cast(ServerConfig, self.config).pending

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(cast(asyncio.Transport, transport))
        self._pending.add(self.transport)

    def connection_lost(self, exc: Exception | None) -> None:
        self._pending.remove(self.transport)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        before = self.cycle
        super().data_received(data)
        self._expect_answer(before)

    def on_response_complete(self) -> None:
        before = self.cycle
        self._pending.set_deadline(self.transport, REQUEST_TIMEOUT_S)
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
            self._pending.set_deadline(self.transport, RESPONSE_TIMEOUT_S)


class SocketConnection(WebSocketsSansIOProtocol, asyncio.BufferedProtocol):
    """A WebSocket that reads little at once, and nothing while what it has sent is not taken."""

    def __init__(self, *args: Any, **kwargs: Any):
        super().__init__(*args, **kwargs)
        self._buffer = bytearray(READ_BYTES)
        self._spent, self._tokens_at = 0.0, self.loop.time()
        self._throttle: asyncio.TimerHandle | None = None
        self._stall_timer: asyncio.TimerHandle | None = None
        self._unsent, self._stalled_s = 0, 0.0

    @property
    def _pending(self) -> PendingConnections:
        return cast(ServerConfig, self.config).pending

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self.transport.pause_reading()  # until it is accepted

    def connection_lost(self, exc: Exception | None) -> None:
        self._pending.remove(self.transport)
        for timer in (self._throttle, self._stall_timer):
            if timer is not None:
                timer.cancel()
        super().connection_lost(exc)

    def start_keepalive(self) -> None:
        """Called when the viewer has been accepted."""
        super().start_keepalive()
        self._pending.remove(self.transport)
        self._check_stall()
        self._read_or_wait()

    def get_buffer(self, sizehint: int) -> bytearray:
        return self._buffer

    def buffer_updated(self, nbytes: int) -> None:
        self.data_received(bytes(self._buffer[:nbytes]))

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
        self._spent = max(self._spent - FRAMES_PER_S * (now - self._tokens_at), 0.0) + frames
        self._tokens_at = now
        over = self._spent - BURST_FRAMES
        if over > 0:
            if self._throttle is not None:
                self._throttle.cancel()
            self._throttle = self.loop.call_later(over / FRAMES_PER_S, self._end_throttle)

    def _end_throttle(self) -> None:
        self._throttle = None
        self._read_or_wait()

    def _check_stall(self) -> None:
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
            self._stall_timer = self.loop.call_later(STALL_CHECK_S, self._check_stall)
