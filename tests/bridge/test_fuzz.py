"""Any bytes at all: the server answers or closes, says nothing of it, and serves the next one."""

import contextlib
import json
import logging
import socket
import threading
import urllib.request
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from tests.bridge.frames import frame
from tests.bridge.process import PATIENCE_S, viewing
from tests.bridge.serving import closed_within, connected, served, upgraded, ws_frame

from glasshelm.bridge.server.access_control import TOKEN_COOKIE, AccessControl
from glasshelm.bridge.server.app import create_app
from glasshelm.bridge.server.connections import ConnectionLimits
from glasshelm.bridge.server.session_hub import SessionHub
from glasshelm.bridge.sessions.log_index import LogIndex
from glasshelm.bridge.sessions.replay_session import ReplaySession
from glasshelm.bridge.sessions.session_log import FileLog
from glasshelm.bridge.sessions.source_list import SourceList

pytestmark = pytest.mark.slow

OWNER, VIEWER = "owner-0123456789", "viewer-0123456789"


class Served:
    """A server with tokens, and all that it says of its own."""

    def __init__(self, port: int):
        self.port = port
        self.said: list[str] = []

    def check(self) -> None:
        """It serves a viewer, and no line was written."""
        with viewing(f"ws://127.0.0.1:{self.port}/ws?token={VIEWER}") as viewer:
            assert json.loads(viewer.recv(timeout=PATIENCE_S))["type"] == "hello"
        assert self.said == []

    def answer(self, *pieces: bytes) -> bytes:
        """What it answers to these bytes, after which nothing more is said."""
        with connected(self.port) as one, contextlib.suppress(OSError):  # it may be closed
            for piece in pieces:
                one.sendall(piece)
            one.shutdown(socket.SHUT_WR)
            one.settimeout(PATIENCE_S)
            got = b""
            while piece := one.recv(65_536):
                got += piece
            return got
        return b""


@pytest.fixture(scope="module")
def bridge(tmp_path_factory) -> Iterator[Served]:
    folder = tmp_path_factory.mktemp("fuzz")
    static = folder / "static"
    static.mkdir()
    (static / "index.html").write_text("the page")
    record = FileLog(folder / "ten.jsonl", fresh=True)
    for k in range(20):
        record.append(frame(5 * k))
    record.close()
    hub = SessionHub(SourceList(LogIndex(folder)), folder)
    guard = AccessControl("127.0.0.1", OWNER, VIEWER)
    app = create_app(
        hub, guard, lambda: ReplaySession(FileLog(record.path, fresh=False)), static=static
    )
    with served(app, ConnectionLimits()) as (_, port):
        server = Served(port)

        class Listening(logging.Handler):
            def emit(self, record: logging.LogRecord) -> None:
                server.said.append(self.format(record))

        handler = Listening(logging.WARNING)
        loggers = [logging.getLogger(name) for name in (None, "uvicorn", "uvicorn.error")]
        for logger in loggers:
            logger.addHandler(handler)
        excepthook = threading.excepthook
        threading.excepthook = lambda args: server.said.append(str(args))
        try:
            yield server
        finally:
            threading.excepthook = excepthook
            for logger in loggers:
                logger.removeHandler(handler)


fuzzed = settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
#: Characters that mean something to who reads addresses, headers and cookies.
odd = st.text(st.sampled_from("[]:/@?#%&=;,\"'\\ \t.-0aZ\xe9\xff\x80\x01"), max_size=40)
value = st.one_of(
    odd,
    st.sampled_from(
        ["http://[::1", "http://[", "null", "http://127.0.0.1:1", "%ff%00", "[::1", "::1]", OWNER,
         VIEWER, f"{TOKEN_COOKIE}={OWNER}",
         f"{TOKEN_COOKIE}={VIEWER}", f"{TOKEN_COOKIE}=\xff\xfe", "\x80", "chunked",
         "websocket", "upgrade", "keep-alive, Upgrade", "999999999999999999999", "-1", "13", "0",
         "permessage-deflate; server_max_window_bits=99", "x" * 9000, "gzip", "bytes=0-,5-",
         "Mon, 99 Foo 2000", "W/\"x", "100-continue", "dGhlIHNhbXBsZSBub25jZQ=="]
    ),
)  # fmt: skip
NAMES = [
    "Host", "Origin", "Cookie", "Upgrade", "Connection", "Sec-WebSocket-Key", "Content-Length",
    "Sec-WebSocket-Version", "Sec-WebSocket-Protocol", "Sec-WebSocket-Extensions", "Expect",
    "Transfer-Encoding", "Range", "If-Modified-Since", "If-None-Match", "X-Forwarded-For",
    "X-Forwarded-Proto", "Authorization", "Content-Type", "Accept-Encoding",
]  # fmt: skip
header = st.tuples(st.sampled_from(NAMES), value)
target = st.one_of(
    st.sampled_from(["/", "/ws", "/api/health", "/index.html", "*", "//", "http://x/", "/%00"]),
    odd.map(lambda text: "/" + text),
)
query = st.one_of(st.just(""), value.map(lambda text: f"?token={text}"))
method = st.sampled_from(
    ["GET", "HEAD", "POST", "PUT", "OPTIONS", "CONNECT", "TRACE", "get", "G\x00"]
)


@fuzzed
@given(method, target, query, st.lists(header, max_size=8), st.binary(max_size=200), st.booleans())
@example("GET", "/ws", f"?token={OWNER}", [("Origin", "http://[::1")], b"", True)
@example("GET", "/", "?token=%ff%fe", [("Cookie", f"{TOKEN_COOKIE}=\xff\xfe")], b"", True)
@example("GET", "/", f"?token={OWNER}", [("Origin", "null"), ("Origin", "http://[")], b"", True)
@example("POST", "/", "", [("Transfer-Encoding", "chunked")], b"zz\r\n\r\n", True)
def test_any_request_is_answered_or_closed(bridge, method, target, query, headers, body, host):
    lines = [f"{method} {target}{query} HTTP/1.1", "Connection: close"]
    lines += [f"Host: 127.0.0.1:{bridge.port}"] * host
    lines += [f"{name}: {value}" for name, value in headers]
    bridge.answer("\r\n".join([*lines, "", ""]).encode("latin-1") + body)
    bridge.check()


WORDS = [
    b"GET / HTTP/1.1\r\n", b"POST /ws HTTP/1.1\r\n", b"Host: 127.0.0.1\r\n", b"\r\n", b"\r\n\r\n",
    b"Transfer-Encoding: chunked\r\n", b"Content-Length: 5\r\n", b"5\r\n", b"0\r\n\r\n",
    b"ffffff\r\n", b"Upgrade: websocket\r\n", b"Connection: upgrade\r\n",
    b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
    b"\x16\x03\x01\x02\x00", b"GET http://[::1 HTTP/1.1\r\n", b"Expect: 100-continue\r\n",
    b"GET /ws?token=owner-0123456789 HTTP/1.1\r\n", b"Sec-WebSocket-Version: 13\r\n",
    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n", b" folded\r\n", b"x" * 20_000,
]  # fmt: skip


@fuzzed
@given(st.lists(st.one_of(st.sampled_from(WORDS), st.binary(max_size=30)), max_size=12))
@example([b"POST / HTTP/1.1\r\n", WORDS[2], WORDS[5], b"\r\n", b"ffffff\r\n", b"x", b"zz\r\n"])
def test_any_bytes_are_answered_or_closed(bridge, pieces):
    bridge.answer(*pieces)
    bridge.check()


part = st.tuples(st.integers(0, 15), st.binary(max_size=200), st.booleans())
spoken = st.sampled_from(
    [b'{"type":"ping"}', b'{"type":"seek","time_s":1e999}', b"[" * 5000, b'{"type":' * 3000,
     b'{"type":"open","source":"\\ud800"}', b'{"type":"whatif","change":"keep_course"}', b"\xff",
     b'{"type":"play"}', b'{"type":"limits"}', b'{"type":"replay","log":"../x"}', b"\x03\xe8bye",
     b"\x00", b"x" * 70_000, b'{"type":"compare","name":"\\u0000"}', b'{"type":"rate","rate":5}',
     b"y" * 1_100_000]
)  # fmt: skip
said = st.tuples(st.sampled_from([1, 1, 1, 2, 8, 9]), spoken, st.just(True))


@fuzzed
@given(st.lists(st.one_of(part, said), max_size=8), st.binary(max_size=20), st.booleans())
@example([(1, b"\xff", True), (1, b'{"type":"ping"}', True), (8, b"", True)], b"", False)
@example([(1, b"a", False), (8, b"", True)], b"", True)
@example([(0, b"a", True)], b"", True)
def test_any_frames_are_answered_or_close_the_socket(bridge, frames, rest, owner):
    """As the owner too: nothing that he says is worth a line on the terminal either."""
    token = OWNER if owner else VIEWER
    with upgraded(bridge.port, target=f"/ws?token={token}") as one:
        with contextlib.suppress(OSError):
            for opcode, data, fin in frames:
                one.sendall(ws_frame(opcode, data, fin))
            one.sendall(rest)
            one.shutdown(socket.SHUT_WR)
        assert closed_within(one, PATIENCE_S)
    bridge.check()


def test_the_page_is_served_after_all_that(bridge):
    with urllib.request.urlopen(f"http://127.0.0.1:{bridge.port}/?token={OWNER}") as answer:
        assert answer.read() == b"the page"
