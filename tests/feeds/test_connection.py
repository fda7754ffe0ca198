"""Why a connection failed, as people read it."""

import asyncio
import errno
import os

import pytest
from tests.bridge.process import free_port
from tests.feeds.live import pictured, until

from glasshelm.feeds.connection import describe_error
from glasshelm.feeds.feed_factory import create_feed, signalk_server
from glasshelm.live.signalk_writer import SignalKWriter

NOBODY = OSError(errno.ECONNREFUSED, "Connect call failed ('127.0.0.1', 21110)")


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (NOBODY, "connection refused"),
        (OSError(f"Multiple exceptions: {NOBODY}, {NOBODY}"), "connection refused"),
        (OSError(errno.EADDRINUSE, os.strerror(errno.EADDRINUSE)), "address already in use"),
        (OSError(-2, "Name or service not known"), "name or service not known"),
        (TimeoutError(), "no answer"),
        (ConnectionResetError(), "ConnectionResetError"),
    ],
)
def test_reason(error, words):
    assert describe_error(error) == words


@pytest.mark.parametrize("scheme", ["tcp", "signalk"])
def test_nobody_at_the_port(scheme):
    address = f"127.0.0.1:{free_port()}"

    async def listen():
        feed = create_feed(f"{scheme}://{address}")
        async with pictured(feed):
            await until(lambda: feed.last_error)
        return feed.last_error

    trouble = asyncio.run(listen())
    assert address in trouble
    assert trouble.endswith(": connection refused")


def test_a_token_goes_nowhere_else_than_to_its_server():
    """The server sends its clients on to another; with their token they do not go."""

    async def write():
        asked = []

        async def other(reader, writer):
            asked.append(await reader.read(9999))
            writer.close()

        async def here(_, writer):
            at = elsewhere.sockets[0].getsockname()[1]
            answer = f"HTTP/1.1 302 Found\r\nLocation: ws://127.0.0.1:{at}/\r\n"
            writer.write(f"{answer}Content-Length: 0\r\n\r\n".encode())
            await writer.drain()
            writer.close()

        elsewhere = await asyncio.start_server(other, "127.0.0.1", 0)
        first = await asyncio.start_server(here, "127.0.0.1", 0)
        async with elsewhere, first:
            port = first.sockets[0].getsockname()[1]
            writer = SignalKWriter(signalk_server(f"signalk://127.0.0.1:{port}", "secret"))
            task = asyncio.create_task(writer.run())
            await until(lambda: writer.last_error)
            task.cancel()
        return asked, writer.last_error

    asked, trouble = asyncio.run(write())
    assert asked == []
    assert trouble.endswith("refused with HTTP status 302")
