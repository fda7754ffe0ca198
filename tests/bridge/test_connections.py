"""Clients who cost more than they should: idle, slow, greedy, and those who never read."""

import asyncio
import contextlib
import json
import logging
import socket
import threading
import time
from collections.abc import Iterator

import pytest
import uvicorn
from tests.bridge.frames import frame
from tests.bridge.process import PATIENCE_S, start, viewing
from tests.bridge.serving import PING, TEXT, closed_within, connected, served, upgraded, ws_frame
from websockets.exceptions import ConnectionClosed, InvalidStatus

from glasshelm.bridge.server import connections, quiet_logging
from glasshelm.bridge.server.access_control import AccessControl
from glasshelm.bridge.server.app import create_app
from glasshelm.bridge.server.connections import ConnectionLimits, PendingConnections
from glasshelm.bridge.server.protocol import Outgoing
from glasshelm.bridge.server.session_hub import SessionHub
from glasshelm.bridge.sessions.log_index import LogIndex
from glasshelm.bridge.sessions.replay_session import ReplaySession
from glasshelm.bridge.sessions.session_log import FileLog
from glasshelm.bridge.sessions.source_list import SourceList

#: No client may hold the others up for longer [s]; without bounds it was seconds.
HELD_UP_S = 1.0
CONT = 0


@pytest.fixture
def small(tmp_path) -> Iterator[tuple[uvicorn.Server, int]]:
    """A server with room for few, which shows a log of ten minutes."""
    record = FileLog(tmp_path / "ten.jsonl", fresh=True)
    for k in range(120):
        record.append(frame(5 * k))
    record.close()
    hub = SessionHub(SourceList(LogIndex(tmp_path)), tmp_path)
    app = create_app(
        hub,
        AccessControl("127.0.0.1", None),
        lambda: ReplaySession(FileLog(record.path, fresh=False)),
        static=tmp_path / "static",
        max_viewers=5,
    )
    with served(app, ConnectionLimits(viewers=5, pending=8, backlog=4)) as server:
        yield server


@contextlib.contextmanager
def beating(port: int) -> Iterator[list[float]]:
    """How long a good viewer waits for each pong meanwhile [s]."""
    waits: list[float] = []
    over = threading.Event()

    def beat() -> None:
        with viewing(f"ws://127.0.0.1:{port}/ws") as viewer:
            while not over.is_set():
                asked = time.monotonic()
                viewer.send('{"type":"ping"}')
                while json.loads(viewer.recv(timeout=PATIENCE_S))["type"] != "pong":
                    pass
                waits.append(time.monotonic() - asked)
                time.sleep(0.03)

    thread = threading.Thread(target=beat)
    thread.start()
    try:
        until = time.monotonic() + PATIENCE_S
        while len(waits) < 3 and time.monotonic() < until:
            time.sleep(0.01)
        waits.clear()
        yield waits
    finally:
        over.set()
        thread.join(timeout=PATIENCE_S)


HOST = "Host: 127.0.0.1\r\n"
WITHOUT_A_REQUEST = {
    "nothing": b"",
    "half a line": b"GET / HT",
    "half a header": b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: y\r\n",
    "an answered request, then nothing": f"GET /api/health HTTP/1.1\r\n{HOST}\r\n".encode(),
    "an answered request, then half a one": f"GET /api/health HTTP/1.1\r\n{HOST}\r\nGET".encode(),
    "a body that never ends": f"POST / HTTP/1.1\r\n{HOST}Content-Length: 999999\r\n\r\n{{".encode(),
    "half a handshake": f"GET /ws HTTP/1.1\r\n{HOST}Upgrade: websocket\r\n".encode(),
    "an upgrade of another method": f"POST /ws HTTP/1.1\r\n{HOST}Upgrade: websocket\r\n"
    "Connection: Upgrade\r\n\r\n".encode(),
}


@pytest.mark.parametrize("sent", WITHOUT_A_REQUEST.values(), ids=WITHOUT_A_REQUEST)
def test_who_asks_for_nothing_is_closed(small, monkeypatch, sent):
    monkeypatch.setattr(connections, "REQUEST_TIMEOUT_S", 1.0)
    _, port = small
    with connected(port) as one:
        one.sendall(sent)
        assert closed_within(one, 20.0)


def test_who_drips_a_header_is_closed_at_the_deadline(small, monkeypatch):
    monkeypatch.setattr(connections, "REQUEST_TIMEOUT_S", 1.5)
    _, port = small
    with connected(port) as one:
        one.sendall(b"GET / HTTP/1.1\r\n")
        began = time.monotonic()
        with contextlib.suppress(ConnectionError):
            while time.monotonic() - began < 20.0:
                one.sendall(b"X: y\r\n")
                time.sleep(0.1)
        assert time.monotonic() - began < 20.0


def test_an_answer_that_is_not_taken_is_given_up(tmp_path, monkeypatch):
    monkeypatch.setattr(connections, "RESPONSE_TIMEOUT_S", 1.0)
    static = tmp_path / "static"
    static.mkdir()
    (static / "large.js").write_bytes(b"x" * 30_000_000)
    hub = SessionHub(SourceList(LogIndex(tmp_path)), tmp_path)
    app = create_app(hub, AccessControl("127.0.0.1", None), static=static)
    with served(app) as (server, port), connected(port) as one:
        one.sendall(f"GET /large.js HTTP/1.1\r\n{HOST}\r\n".encode())
        assert _becomes(lambda: len(server.server_state.connections), 1)
        assert _becomes(lambda: len(server.server_state.connections), 0)


def test_idle_connections_crowd_out_one_another_and_no_viewer(small):
    server, port = small
    with contextlib.ExitStack() as stack, beating(port) as waits:
        idle = [stack.enter_context(connected(port)) for _ in range(200)]
        with viewing(f"ws://127.0.0.1:{port}/ws") as viewer:
            assert json.loads(viewer.recv(timeout=PATIENCE_S))["type"] == "hello"
        assert len(server.server_state.connections) <= 8 + 5 + 4 * 4
        assert all(closed_within(one, 5.0) for one in idle[:150])
        assert waits
        assert max(waits) < HELD_UP_S


class _Transport(asyncio.Transport):
    def __init__(self, host: str):
        super().__init__({"peername": (host, 1)})
        self.aborted = False

    def abort(self) -> None:
        self.aborted = True


def test_who_floods_crowds_out_himself():
    async def come() -> tuple[list[_Transport], list[_Transport]]:
        waiting = PendingConnections(10)
        others = [_Transport(f"10.0.0.{k}") for k in range(5)]
        flood = [_Transport("10.9.9.9") for _ in range(100)]
        for one in (*others, *flood):
            waiting.add(one)
        assert len(waiting) == 10
        for one in (*others, *flood):
            waiting.remove(one)
        return others, flood

    others, flood = asyncio.run(come())
    assert not any(one.aborted for one in others)
    assert [one.aborted for one in flood] == 95 * [True] + 5 * [False]


def test_there_is_room_only_for_so_many_as_files_can_be_opened():
    for files in (*range(2000), 65_536, 2**31):
        room = ConnectionLimits.for_files(files)
        assert min(room.viewers, room.pending, room.backlog) >= 1
        if files >= 128:
            assert 64 + room.viewers + room.pending + 4 * room.backlog <= files
        if files >= 512:
            assert room.viewers == 100


FLOODS = {
    "pings": ws_frame(PING, b"x" * 125),
    "empty pings": ws_frame(PING),
    "messages": ws_frame(TEXT, b'{"type":"ping"}'),
    "no messages": ws_frame(TEXT),
    "long messages": ws_frame(TEXT, b"x" * 100_000),
    "empty fragments": ws_frame(TEXT, fin=False) + 1000 * ws_frame(CONT, fin=False),
    "tiny fragments": ws_frame(TEXT, b"x", fin=False) + 1000 * ws_frame(CONT, b"x", fin=False),
    "messages in two empty fragments": ws_frame(TEXT, fin=False) + ws_frame(CONT),
}


@pytest.mark.parametrize("flood", FLOODS.values(), ids=FLOODS)
def test_a_flood_of_who_does_not_read_waits_with_him_and_holds_nobody_up(small, flood):
    """He comes again as often as he is closed."""
    server, port = small
    piece = flood * max(200_000 // len(flood), 1)
    held = sent = 0
    with beating(port) as waits:
        until = time.monotonic() + 4.0
        while time.monotonic() < until:
            with contextlib.suppress(ConnectionError), upgraded(port) as greedy:
                greedy.settimeout(0.1)
                while time.monotonic() < until:
                    with contextlib.suppress(TimeoutError):
                        sent += greedy.send(piece)
                    for one in tuple(server.server_state.connections):
                        held = max(held, one.transport.get_write_buffer_size())
                        assert len(getattr(one, "frames", ())) <= 1000
                        assert not hasattr(one, "queue") or one.queue.qsize() < 1000
    assert sent > 0
    assert held < 500_000
    assert waits
    assert max(waits) < HELD_UP_S


def test_a_message_in_many_fragments_closes_the_socket_with_words(small):
    _, port = small
    with viewing(f"ws://127.0.0.1:{port}/ws") as viewer:
        viewer.send(iter(['{"type":', '"ping"', "}"]))
        while json.loads(viewer.recv(timeout=PATIENCE_S))["type"] != "pong":
            pass
        with contextlib.suppress(ConnectionClosed):
            viewer.send("x" for _ in range(1000))
        with pytest.raises(ConnectionClosed, match="more than 64 fragments"):
            _frames(viewer, 1_000_000)


def test_a_viewer_who_takes_nothing_is_dropped(tmp_path, monkeypatch):
    monkeypatch.setattr(connections, "STALL_TIMEOUT_S", 1.0)
    monkeypatch.setattr(connections, "STALL_CHECK_S", 0.2)
    hub = SessionHub(SourceList(LogIndex(tmp_path)), tmp_path)
    app = create_app(hub, AccessControl("127.0.0.1", None), static=tmp_path)
    with served(app) as (server, port), upgraded(port):
        assert _becomes(lambda: len(hub.viewers), 1)
        (viewer,) = hub.viewers
        (one,) = server.server_state.connections
        loop = one.loop

        def fill() -> None:
            for _ in range(8):
                viewer.put(Outgoing("frame", b"x" * 2_000_000))

        loop.call_soon_threadsafe(fill)
        assert _becomes(lambda: len(hub.viewers), 0)
        assert _becomes(lambda: len(server.server_state.connections), 0)


def test_viewers_are_counted_before_they_have_joined(small):
    _, port = small
    with contextlib.ExitStack() as stack:
        for _ in range(5):
            stack.enter_context(upgraded(port))
        with pytest.raises(InvalidStatus):
            stack.enter_context(viewing(f"ws://127.0.0.1:{port}/ws"))


FILES = 128


def test_a_server_of_few_files_is_not_locked_by_hundreds_of_idle_connections(tmp_path):
    """Nor does its terminal fill; frames go on to who is there, and who comes gets in."""
    heard: list[str] = []
    voyage = ("imazu:1", "--pilot", "straight", "--log-dir", str(tmp_path))
    process, url = start(*voyage, heard=heard, files=FILES)
    host, port = url.removeprefix("ws://").removesuffix("/ws").split(":")
    over = threading.Event()
    idle: list[socket.socket] = []

    def storm() -> None:
        while not over.is_set():
            with contextlib.suppress(OSError):
                idle.append(socket.create_connection((host, int(port)), timeout=1.0))
            if len(idle) > 600:
                idle.pop(0).close()

    try:
        with viewing(url) as first:
            _frames(first, 1)
            first.send('{"type":"rate","rate":20}')
            storming = threading.Thread(target=storm)
            storming.start()
            try:
                until = time.monotonic() + PATIENCE_S
                while len(idle) < 500 and time.monotonic() < until:
                    time.sleep(0.05)
                _frames(first, 5)
                for _ in range(3):
                    with viewing(url) as late:
                        _frames(late, 3)
            finally:
                over.set()
                storming.join(timeout=PATIENCE_S)
        assert sum(map(len, heard)) < 20_000, "the terminal fills"
    finally:
        process.kill()
        process.wait(timeout=PATIENCE_S)
        for one in idle:
            one.close()


def test_lines_beyond_so_many_a_minute_are_left_out_and_counted(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(quiet_logging.time, "monotonic", lambda: now[0])
    few = quiet_logging.RateLimitFilter(3)

    def said() -> list[str]:
        lines = []
        for k in range(1000):
            record = logging.LogRecord("x", logging.ERROR, "", 0, "line %d", (k,), None)
            if few.filter(record):
                lines.append(record.getMessage())
        return lines

    assert said() == ["line 0", "line 1", "line 2"]
    assert said() == []
    now[0] = 61.0
    assert said() == ["line 0 (1997 lines were left out before)", "line 1", "line 2"]


def _frames(viewer, count: int) -> None:
    """Until so many frames have come."""
    until = time.monotonic() + PATIENCE_S
    while count and time.monotonic() < until:
        count -= json.loads(viewer.recv(timeout=PATIENCE_S))["type"] == "frame"
    assert not count


def _becomes(get, wanted, seconds: float = 30.0) -> bool:
    until = time.monotonic() + seconds
    while get() != wanted:
        if time.monotonic() > until:
            return False
        time.sleep(0.02)
    return True
