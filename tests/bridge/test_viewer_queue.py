import asyncio

import pytest

from glasshelm.bridge.server.protocol import Outgoing
from glasshelm.bridge.server.viewer_queue import MAX_BYTES, MAX_FRAMES, MAX_OTHERS, ViewerQueue


def emptied(outbox: ViewerQueue) -> list[bytes]:
    async def take() -> list[bytes]:
        return [await outbox.get() for _ in range(len(outbox))]

    return asyncio.run(take())


def test_messages_come_in_order():
    outbox = ViewerQueue()
    for kind in ("hello", "session", "history", "frame", "alarms", "notice"):
        outbox.put(Outgoing(kind, kind.encode()))
    assert emptied(outbox) == [b"hello", b"session", b"history", b"frame", b"alarms", b"notice"]


def test_of_too_many_frames_the_newest_stay_and_the_others_are_counted():
    outbox = ViewerQueue()
    outbox.put(Outgoing("session", b"s"))
    for k in range(100):
        outbox.put(Outgoing("frame", b"%d" % k))
    assert outbox.dropped == 100 - MAX_FRAMES
    assert emptied(outbox) == [b"s", *(b"%d" % k for k in range(100 - MAX_FRAMES, 100))]


def test_a_history_replaces_what_came_before_it():
    outbox = ViewerQueue()
    for kind, text in (
        ("history", b"old"),
        ("frame", b"1"),
        ("band", b"of 1"),
        ("history", b"new"),
        ("frame", b"2"),
    ):
        outbox.put(Outgoing(kind, text))
    assert emptied(outbox) == [b"new", b"2"]


@pytest.mark.parametrize("kind", ["session", "alarms", "band"])
def test_only_the_newest_state_is_sent(kind):
    outbox = ViewerQueue()
    for k in range(50):
        outbox.put(Outgoing(kind, b"%d" % k))
    assert emptied(outbox) == [b"49"]


def test_nothing_grows_without_end():
    outbox = ViewerQueue()
    for k in range(1000):
        for kind in ("hello", "session", "history", "frame", "alarms", "error", "notice", "pong"):
            outbox.put(Outgoing(kind, b"%d" % k))
    assert len(outbox) <= MAX_FRAMES + MAX_OTHERS + 4


@pytest.mark.parametrize("kind", ["frame", "whatif", "notice"])
def test_bytes_are_bounded_and_the_newest_stays(kind):
    outbox = ViewerQueue()
    outbox.put(Outgoing("session", b"s"))
    for k in range(5):
        outbox.put(Outgoing(kind, b"%d" % k + bytes(MAX_BYTES // 3)))
        assert outbox.bytes <= MAX_BYTES
    outbox.put(Outgoing(kind, b"huge" + bytes(2 * MAX_BYTES)))
    assert [text[:4] for text in emptied(outbox)] == [b"s", b"huge"]
    assert outbox.dropped == (5 if kind == "frame" else 0)


def test_next_waits_for_a_message():
    async def wait() -> bytes:
        outbox = ViewerQueue()
        asyncio.get_running_loop().call_later(0.01, outbox.put, Outgoing("frame", b"late"))
        return await asyncio.wait_for(outbox.get(), 60)

    assert asyncio.run(wait()) == b"late"
