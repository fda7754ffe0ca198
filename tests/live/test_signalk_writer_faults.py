"""Every call of the write-back's connection fails in turn: nothing stays on the server."""

import asyncio
import json

import pytest
from tests.feeds.frames import Alarm, frame_of, target_of
from tests.feeds.live import running, until
from websockets.asyncio.server import serve

from glasshelm.feeds.connection import Backoff
from glasshelm.feeds.feed_factory import signalk_server
from glasshelm.live import signalk_writer
from glasshelm.live.signalk_writer import RUDDER, SELF, SignalKWriter

ALARM = Alarm("1", "A", "unacknowledged", "CPA 0.05 NM in 1:00")
FRAMES = [
    frame_of(0.05, [target_of("1", 100.0, 60.0), target_of("urn:x", 200.0, 60.0)]),
    frame_of(-0.02, [target_of("1", 90.0, 55.0)]),
    frame_of(0.08, [target_of("2", 90.0, 55.0)]),
]


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(Backoff, "FIRST_S", 0.01)
    monkeypatch.setattr(Backoff, "LONGEST_S", 0.02)


class Server:
    """Keeps what stands on it, and nothing that was withdrawn."""

    def __init__(self):
        self.stands: dict = {}
        self.connections = 0

    async def talk(self, socket):
        self.connections += 1
        await socket.send('{"self": "vessels.x"}')
        async for message in socket:
            delta = json.loads(message)
            for one in delta["updates"][0]["values"]:
                value = one["value"]
                gone = value is None or (isinstance(value, dict) and value.get("state") == "normal")
                if gone:
                    self.stands.pop((delta["context"], one["path"]), None)
                else:
                    self.stands[delta["context"], one["path"]] = value


class Broken:
    """A connection whose calls are counted, and fail from the ``first``-th on, ``count`` of them.

    ``late``: what a call that fails was to do, it has done.
    """

    def __init__(self, first: int, count: int, error: Exception, late: bool):
        self.calls, self.failed = 0, []
        self._first, self._count, self._error, self._late = first, count, error, late

    async def call(self, name, really):
        self.calls += 1
        if not self._first <= self.calls < self._first + self._count:
            return await really()
        self.failed.append(name)
        if self._late:
            await really()
        raise self._error

    def heal(self):
        self._count = 0

    def of(self, server):
        really, broken = server.connect, self

        async def connect(subscribe):
            socket = await broken.call("connect", lambda: really(subscribe))
            return _Socket(socket, broken)

        server.connect = connect
        return server


class _Socket:
    def __init__(self, socket, broken):
        self._socket, self._broken = socket, broken

    def __getattr__(self, name):
        really = getattr(self._socket, name)
        if name not in ("send", "recv", "ping", "close"):
            return really
        return lambda *args: self._broken.call(name, lambda: really(*args))


@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("error", [OSError("gone"), RuntimeError("odd")], ids=["gone", "odd"])
def test_every_call_fails_in_turn(error, count, late):
    names: set[str] = set()

    async def voyage(first: int) -> bool:
        server, broken = Server(), Broken(first, count, error, late)
        async with serve(server.talk, "127.0.0.1", 0) as serving:
            port = serving.sockets[0].getsockname()[1]
            writer = SignalKWriter(broken.of(signalk_server(f"signalk://127.0.0.1:{port}", "x")))
            async with running(writer.run()):
                for frame in FRAMES:
                    writer.publish(frame, [ALARM])
                    await asyncio.sleep(0.03)
                failed = bool(broken.failed)
                broken.heal()
                # What was told last is written, and nothing else stands.
                await until(lambda: server.stands.get((SELF, RUDDER)) == 0.08, 20)
                await until(lambda: len(server.stands) == 3, 20)
                await until(lambda: writer.last_error is None, 20)
                writer.withdraw()
                await until(lambda: not server.stands, 20)
                writer.publish(FRAMES[0], [ALARM])
                await until(lambda: len(server.stands) == 4, 20)
            names.update(broken.failed)
            assert server.stands == {}, f"call {first} left something"
        return failed

    first = 1
    while asyncio.run(voyage(first)):
        first += 1
    assert first > 5
    assert {"connect", "send", "recv", "ping"} <= names


@pytest.mark.parametrize("late", [False, True])
def test_what_fails_while_it_ends_is_tried_again_once_more(late):
    async def voyage(first: int) -> bool:
        server, broken = Server(), Broken(10**9, 0, OSError("gone"), late)
        async with serve(server.talk, "127.0.0.1", 0) as serving:
            port = serving.sockets[0].getsockname()[1]
            writer = SignalKWriter(broken.of(signalk_server(f"signalk://127.0.0.1:{port}", "x")))
            async with running(writer.run()):
                writer.publish(FRAMES[0], [ALARM])
                await until(lambda: len(server.stands) == 4)
                broken._first, broken._count = broken.calls + first, 1
                await writer.close()
            assert server.stands == {}, f"call {first} left something"
            await writer.close()  # twice does no harm
        return bool(broken.failed)

    first = 1
    while asyncio.run(voyage(first)):
        first += 1
    assert first > 3


def test_who_tells_no_more_is_withdrawn(monkeypatch):
    monkeypatch.setattr(signalk_writer, "STALE_S", 0.3)

    async def voyage():
        server = Server()
        async with serve(server.talk, "127.0.0.1", 0) as serving:
            port = serving.sockets[0].getsockname()[1]
            writer = SignalKWriter(signalk_server(f"signalk://127.0.0.1:{port}", "x"))
            async with running(writer.run()):
                for _ in range(10):
                    writer.publish(FRAMES[0], [])
                    await asyncio.sleep(0.05)
                assert (SELF, RUDDER) in server.stands
                await until(lambda: not server.stands, 20)
                await asyncio.sleep(0.4)
                writer.publish(FRAMES[0], [])
                await until(lambda: len(server.stands) == 3, 20)

    asyncio.run(voyage())


def test_what_one_who_was_killed_has_left_goes_with_the_first_word():
    async def voyage():
        server = Server()
        server.stands[SELF, RUDDER] = 0.1
        async with serve(server.talk, "127.0.0.1", 0) as serving:
            port = serving.sockets[0].getsockname()[1]
            writer = SignalKWriter(signalk_server(f"signalk://127.0.0.1:{port}", "x"))
            async with running(writer.run()):
                writer.withdraw()
                await until(lambda: not server.stands, 20)

    asyncio.run(voyage())


def test_a_line_that_breaks_while_it_ends_is_opened_once_more():
    """The server's end of the line is gone, and is there again when the bridge ends."""

    async def voyage():
        server, sockets = Server(), []

        async def talk(socket):
            sockets.append(socket)
            await server.talk(socket)

        async with serve(talk, "127.0.0.1", 0) as serving:
            port = serving.sockets[0].getsockname()[1]
            writer = SignalKWriter(signalk_server(f"signalk://127.0.0.1:{port}", "x"))
            async with running(writer.run()):
                writer.publish(FRAMES[0], [ALARM])
                await until(lambda: len(server.stands) == 4)
                sockets[0].transport.abort()
                await writer.close()
            assert server.stands == {}
            assert server.connections == 2

    asyncio.run(voyage())


def test_what_cannot_be_told_is_withdrawn_and_raised(monkeypatch):
    async def voyage():
        server = Server()
        async with serve(server.talk, "127.0.0.1", 0) as serving:
            port = serving.sockets[0].getsockname()[1]
            writer = SignalKWriter(signalk_server(f"signalk://127.0.0.1:{port}", "x"))
            async with running(writer.run()):
                writer.publish(FRAMES[0], [ALARM])
                await until(lambda: len(server.stands) == 4)
                monkeypatch.setattr(signalk_writer, "signalk_values", lambda frame, alarms: 1 / 0)
                with pytest.raises(ZeroDivisionError):
                    writer.publish(FRAMES[1], [])
                await until(lambda: not server.stands, 20)

    asyncio.run(voyage())
