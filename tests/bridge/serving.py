"""The server as it is served, in a thread of this process, and clients that speak raw bytes."""

import asyncio
import base64
import contextlib
import os
import socket
import struct
import threading
import time
from collections.abc import Iterator

import uvicorn
from starlette.applications import Starlette
from tests.bridge.process import PATIENCE_S

from glasshelm.bridge.server.connections import ConnectionLimits, ServerConfig

TEXT, BINARY, CLOSE, PING = 1, 2, 8, 9


@contextlib.contextmanager
def served(
    app: Starlette, room: ConnectionLimits | None = None
) -> Iterator[tuple[uvicorn.Server, int]]:
    """The application at a free port of this machine: the server, and the port."""
    bound = socket.create_server(("127.0.0.1", 0))
    server = uvicorn.Server(ServerConfig(app, room))
    thread = threading.Thread(target=lambda: asyncio.run(server.serve(sockets=[bound])))
    thread.start()
    try:
        until = time.monotonic() + PATIENCE_S
        while not server.started:
            assert time.monotonic() < until
            time.sleep(0.01)
        yield server, bound.getsockname()[1]
    finally:
        server.should_exit = True
        thread.join(timeout=PATIENCE_S)


def connected(port: int) -> socket.socket:
    return socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)


def upgraded(port: int, more: str = "", target: str = "/ws") -> socket.socket:
    """A raw WebSocket, opened, from which nothing has been read but the answer's beginning.

    ConnectionRefusedError if it is not opened.
    """
    one = connected(port)
    key = base64.b64encode(os.urandom(16)).decode()
    one.sendall(
        f"GET {target} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
        f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n"
        f"{more}\r\n".encode()
    )
    answer = one.recv(12)
    if answer != b"HTTP/1.1 101":
        one.close()
        raise ConnectionRefusedError(answer)
    return one


def ws_frame(opcode: int, data: bytes = b"", fin: bool = True) -> bytes:
    """One frame of a client (its mask is zero)."""
    size = len(data)
    if size < 126:
        head = struct.pack("!BB", 128 * fin + opcode, 128 + size)
    elif size < 65_536:
        head = struct.pack("!BBH", 128 * fin + opcode, 128 + 126, size)
    else:
        head = struct.pack("!BBQ", 128 * fin + opcode, 128 + 127, size)
    return head + bytes(4) + data


def closed_within(one: socket.socket, seconds: float) -> bool:
    """Whether the server closes it by then, whatever it says before."""
    until = time.monotonic() + seconds
    with contextlib.suppress(ConnectionError):
        while (left := until - time.monotonic()) > 0:
            one.settimeout(left)
            try:
                if not one.recv(65_536):
                    return True
            except TimeoutError:
                return False
        return False
    return True
