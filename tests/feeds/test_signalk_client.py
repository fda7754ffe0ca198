"""The Signal K client against a small server of its protocol (real: test_signalk_server)."""

import asyncio
import contextlib
import json

import pytest
from benchmarks.feeds_fuzz import recording, signalk
from tests.feeds.frames import Alarm, frame_of, target_of
from tests.feeds.live import pictured, running, shown, until
from websockets.asyncio.server import serve

from glasshelm.ais.reports import RejectReason
from glasshelm.ais.signalk_deltas import MAX_MESSAGE_BYTES
from glasshelm.core.errors import InputError
from glasshelm.feeds.connection import Backoff
from glasshelm.feeds.feed_factory import create_feed, signalk_server
from glasshelm.live.signalk_writer import (
    CLOSEST_APPROACH,
    RUDDER,
    SELF,
    SignalKWriter,
    signalk_values,
)


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(Backoff, "FIRST_S", 0.05)


@contextlib.asynccontextmanager
async def server(port, *messages, hang_up=False):
    """Says some messages to each client; what clients say and ask is in the lists it gives."""
    got, asked = [], []

    async def talk(socket):
        asked.append(socket.request)
        for message in messages:
            await socket.send(message)
        if not hang_up:
            async for message in socket:
                got.append(json.loads(message))

    async with serve(talk, "127.0.0.1", port) as serving:
        yield serving.sockets[0].getsockname()[1], got, asked


@pytest.mark.slow
def test_traffic_and_a_server_that_comes_again():
    messages = list(signalk(recording()))[:600]

    async def watch():
        async with server(0, *messages) as (port, _, asked):
            feed = create_feed(f"signalk://127.0.0.1:{port}", token="secret")
            reports = pictured(feed)
            picture = await reports.__aenter__()
            await until(lambda: feed.counts.received == 600 and feed.connected)
            targets = shown(picture, picture.latest_time)
        await until(lambda: not feed.connected)
        trouble = feed.last_error
        async with server(port, *messages):
            await until(lambda: feed.counts.received == 1200)
        await reports.__aexit__(None, None, None)
        return feed, targets, trouble, asked[0]

    feed, targets, trouble, request = asyncio.run(watch())
    assert len(targets) > 30
    assert trouble.endswith("the server closed the connection")
    assert feed.counts.pending == 0
    assert request.path == "/signalk/v1/stream?subscribe=all"
    assert request.headers["Authorization"] == "Bearer secret"


def test_a_message_too_long_is_counted_and_the_feed_goes_on():
    async def watch():
        big = "x" * (MAX_MESSAGE_BYTES + 1)
        async with server(0, json.dumps({"self": "vessels.x"}), big) as (port, _, asked):
            feed = create_feed(f"signalk://127.0.0.1:{port}")
            async with pictured(feed):
                await until(lambda: len(asked) >= 2 and feed.counts.received >= 4)
        return feed.counts

    counts = asyncio.run(watch())
    assert counts.rejected[RejectReason.TOO_LONG] >= 2
    assert counts.pending == 0


@pytest.mark.parametrize("kind", ["signalk", "tcp"])
def test_a_message_that_comes_with_the_cancellation_does_not_take_it_back(kind):
    """A server that never pauses: the bridge must still end when it is told to."""

    class Line:
        def __init__(self):
            self.says = asyncio.get_running_loop().create_future()

        async def recv(self, decode):
            return await self.says

        async def read(self, most):
            return await self.says

    async def cancelled() -> bool:
        line = Line()
        feed = create_feed(f"{kind}://127.0.0.1:1")
        connection = line if kind == "signalk" else (line, None)
        hearing = asyncio.create_task(feed._receive_within_limit(connection))
        await asyncio.sleep(0.01)
        line.says.set_result(b"{}")
        hearing.cancel()
        await asyncio.wait([hearing])
        return hearing.cancelled()

    assert asyncio.run(cancelled())


def test_somebody_else_at_the_port_is_told_in_one_line():
    async def watch():
        async def talk(_, writer):
            writer.write(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n")
            await writer.drain()
            writer.close()

        other = await asyncio.start_server(talk, "127.0.0.1", 0)
        async with other:
            feed = create_feed(f"signalk://127.0.0.1:{other.sockets[0].getsockname()[1]}")
            async with pictured(feed):
                await until(lambda: feed.last_error)
        return feed.last_error

    trouble = asyncio.run(watch())
    assert trouble.endswith("refused with HTTP status 404")


def test_only_what_changed_is_written_and_a_new_connection_gets_all():
    frame = frame_of(0.05, [target_of("1", 100.0, 60.0), target_of("urn:x", 200.0, 60.0)])
    alarm = Alarm("1", "A", "unacknowledged", "CPA 0.05 NM in 1:00")

    def paths(got):
        return [(d["context"], v["path"]) for d in got for v in d["updates"][0]["values"]]

    async def write():
        async with server(0) as (port, got, asked):
            writer = SignalKWriter(signalk_server(f"signalk://127.0.0.1:{port}", "secret"))
            task = running(writer.run())
            await task.__aenter__()
            writer.publish(frame, [alarm])
            await until(lambda: len(got) == 3)
            first = paths(got)
            writer.publish(frame_of(0.05), [])
            await until(lambda: len(got) == 6)
            second = paths(got[3:])
        await until(lambda: not writer.connected)
        writer.publish(frame, [])
        writer.publish(frame, [])
        async with server(port) as (_, again, _):
            await until(lambda: writer.n_written == 3)
            await until(lambda: len(again) == 3)
            await task.__aexit__(None, None, None)
            await until(lambda: len(again) == 6)
            values = {v["path"]: v["value"] for d in again[3:] for v in d["updates"][0]["values"]}
        return first, second, paths(again[:3]), values, asked[0], writer

    first, second, again, withdrawn, request, writer = asyncio.run(write())
    one, other = "vessels.urn:mrn:imo:mmsi:000000001", "vessels.urn:x"
    notice = "notifications.navigation.closestApproach.1"
    assert first == [
        (SELF, RUDDER),
        (SELF, notice),
        (one, CLOSEST_APPROACH),
        (other, CLOSEST_APPROACH),
    ]
    assert sorted(second) == sorted(
        [(SELF, notice), (one, CLOSEST_APPROACH), (other, CLOSEST_APPROACH)]
    )
    assert sorted(again) == sorted(
        [(SELF, RUDDER), (one, CLOSEST_APPROACH), (other, CLOSEST_APPROACH)]
    )
    assert withdrawn == {RUDDER: None, CLOSEST_APPROACH: None}
    assert request.path == "/signalk/v1/stream?subscribe=none"
    assert writer.n_published == 4


def test_who_falls_silent_leaves_nothing_standing():
    async def write():
        async with server(0) as (port, got, _):
            writer = SignalKWriter(signalk_server(f"signalk://127.0.0.1:{port}", "secret"))
            async with running(writer.run()):
                alarm = Alarm("1", "A", "unacknowledged", "CPA 0.05 NM in 1:00")
                writer.publish(frame_of(0.05, [target_of("1", 100.0, 60.0)]), [alarm])
                await until(lambda: len(got) == 2)
                writer.withdraw()
                await until(lambda: len(got) == 4)
                return {v["path"]: v["value"] for d in got[2:] for v in d["updates"][0]["values"]}

    values = asyncio.run(write())
    assert values.pop(RUDDER) is None
    assert values.pop(CLOSEST_APPROACH) is None
    assert [notice["state"] for notice in values.values()] == ["normal"]


def test_a_lost_ship_and_one_already_passed_have_no_closest_approach():
    frame = frame_of(None, [target_of("1", 100.0, 60.0, lost=True), target_of("2", 100.0, -1.0)])
    assert signalk_values(frame, []) == {}


@pytest.mark.parametrize(
    ("text", "token", "message"),
    [
        ("tcp://localhost:3000", "x", "only Signal K can be written back to"),
        ("signalk://localhost", None, "needs a token"),
        ("signalk://localhost", "", "needs a token"),
        ("signalk://localhost:0x1", "x", "must be signalk://HOST:PORT"),
    ],
)
def test_writing_back_needs_signal_k_and_a_token(text, token, message):
    with pytest.raises(InputError, match=message):
        signalk_server(text, token)
    assert signalk_server("signalks://[::1]", "x").address == "[::1]:3443"
