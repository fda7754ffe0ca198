"""The real process: killed without warning, and with viewers who do not read."""

import asyncio
import json
import os
import signal
import socket
import threading
import time

import pytest
import uvicorn
from tests.bridge.frames import Other, frame
from tests.bridge.process import PATIENCE_S, free_port, start, viewing

from glasshelm.bridge.server import connections
from glasshelm.bridge.server.access_control import AccessControl
from glasshelm.bridge.server.app import create_app
from glasshelm.bridge.server.connections import ServerConfig
from glasshelm.bridge.server.session_hub import SessionHub
from glasshelm.bridge.server.viewer_queue import MAX_FRAMES, MAX_OTHERS
from glasshelm.bridge.sessions.log_index import LogIndex
from glasshelm.bridge.sessions.replay_session import ReplaySession
from glasshelm.bridge.sessions.session_log import FileLog
from glasshelm.bridge.sessions.source_list import SourceList

pytestmark = pytest.mark.slow

#: Never ends by itself. A pilot is tried where the server begins, and got ready in a thread.
COMPILING = """
import itertools, pathlib, threading
import jax, jax.numpy as jnp

def steer(seen):
    if threading.current_thread() is not threading.main_thread():
        for k in itertools.count(2):
            def program(x):
                for _ in range(100):
                    x = jnp.sin(jnp.sort(x))
                return x
            lowered = jax.jit(program).lower(jax.ShapeDtypeStruct((k,), jnp.float32))
            pathlib.Path(__file__).with_name("begun").touch()
            lowered.compile()
    return 0.0 * seen.waypoint[0, 2]
"""


def test_what_was_seen_before_kill_9_can_be_seen_again(tmp_path):
    process, url = start("imazu:1", "--pilot", "straight", "--log-dir", str(tmp_path))
    seen: list[dict] = []
    try:
        with viewing(url) as viewer:
            viewer.send('{"type":"rate","rate":60}')
            while len(seen) < 12:
                message = json.loads(viewer.recv(timeout=PATIENCE_S))
                if message["type"] == "error":  # the source is still being opened
                    time.sleep(0.2)
                    viewer.send('{"type":"rate","rate":60}')
                if message["type"] == "history":  # who comes late has missed nothing
                    seen = message["frames"]
                if message["type"] == "frame":
                    seen.append(message["frame"])
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.wait(timeout=PATIENCE_S)
    (log,) = tmp_path.glob("*.jsonl")
    kept = [json.loads(line) for line in log.read_bytes().split(b"\n")[:-1]]
    assert kept[: len(seen)] == seen
    with open(log, "ab") as torn:  # as if killed in the middle of a line
        torn.write(log.read_bytes()[:100])
    process, url = start("--replay", str(log), "--log-dir", str(tmp_path))
    try:
        with viewing(url) as viewer:
            viewer.send(json.dumps({"type": "seek", "time_s": seen[-1]["time_s"]}))
            again: list[dict] = []
            while len(again) < len(seen):
                message = json.loads(viewer.recv(timeout=PATIENCE_S))
                if message["type"] == "error":
                    viewer.send(json.dumps({"type": "seek", "time_s": seen[-1]["time_s"]}))
                if message["type"] == "history":
                    again = message["frames"]
                if message["type"] == "frame" and again:
                    again.append(message["frame"])
            assert again[: len(seen)] == seen
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=PATIENCE_S) in (0, 130)
    finally:
        process.kill()
        process.wait(timeout=PATIENCE_S)


def test_ctrl_c_does_not_wait_for_a_compiler(tmp_path):
    """The first session of an installation, only that its programs are never done."""
    (tmp_path / "compiling.py").write_text(COMPILING)
    found_there = {"PYTHONPATH": str(tmp_path), "JAX_ENABLE_COMPILATION_CACHE": "false"}
    process, url = start(
        "random:35", "--pilot", "compiling:steer", "--log-dir", str(tmp_path), **found_there
    )
    try:
        with viewing(url) as viewer:
            while json.loads(viewer.recv(timeout=PATIENCE_S))["type"] != "preparing":
                pass
            until = time.monotonic() + PATIENCE_S
            while not (tmp_path / "begun").exists():
                assert time.monotonic() < until, "it does not compile"
                time.sleep(0.1)
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=PATIENCE_S) in (0, 130)
    finally:
        process.kill()
        process.wait(timeout=PATIENCE_S)


class _Stream(ReplaySession):
    """A log played a hundred times as fast as it can be read by anybody slow."""

    @property
    def step_s(self) -> float:
        return 0.005


#: Bytes of a connection that the system keeps each way: else it may keep half of the log.
BUFFER = 65_536


@pytest.fixture
def flood(tmp_path, monkeypatch):
    """A server of 400 frames of about 100 kB each, and its hub."""
    # However slow the machine, she who does not read is not dropped before the end.
    monkeypatch.setattr(connections, "STALL_TIMEOUT_S", 600.0)
    record = FileLog(tmp_path / "long.jsonl", fresh=True)
    others = [Other(str(k), east_m=5000.0 + 100 * k, selected=False) for k in range(330)]
    for k in range(400):
        record.append(frame(5 * k, *others))
    record.close()
    hub = SessionHub(SourceList(LogIndex(tmp_path)), tmp_path)
    app = create_app(
        hub,
        AccessControl("127.0.0.1", None),
        lambda: _Stream(FileLog(record.path, fresh=False)),
    )
    bound = socket.create_server(("127.0.0.1", 0))
    bound.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER)
    server = uvicorn.Server(ServerConfig(app))
    thread = threading.Thread(target=lambda: asyncio.run(server.serve(sockets=[bound])))
    thread.start()
    try:
        yield hub, bound.getsockname(), record.path.stat().st_size
    finally:
        server.should_exit = True
        thread.join(timeout=PATIENCE_S)


def test_a_viewer_who_does_not_read_loses_frames_and_costs_no_memory(flood):
    hub, (host, port), size = flood
    url = f"ws://{host}:{port}/ws"
    little = socket.socket()
    little.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
    little.connect((host, port))
    with viewing(url, max_queue=1, sock=little) as slow, viewing(url) as fast:
        for viewer in (slow, fast):
            assert json.loads(viewer.recv(timeout=PATIENCE_S))["type"] == "hello"
        held, last = 0, 0.0
        while last < 1995.0:  # the fast one reads to the end; the slow one reads nothing
            message = json.loads(fast.recv(timeout=PATIENCE_S))
            if message["type"] == "frame":
                last = message["frame"]["time_s"]
            for outbox in hub.viewers:
                assert len(outbox) <= MAX_FRAMES + MAX_OTHERS + 5
                now = tuple(outbox._waiting)  # at once: the server's thread goes on
                waiting = sum(len(text) for kind, text in now if kind == "frame")
                held = max(held, waiting)
        dropped = max(outbox.dropped for outbox in hub.viewers)
        assert dropped > 100
        assert held < size / 20
        # She who was slow gets the newest ones when she reads again.
        times = []
        while not times or times[-1] < 1995.0:
            message = json.loads(slow.recv(timeout=PATIENCE_S))
            if message["type"] == "frame":
                times.append(message["frame"]["time_s"])
        assert times == sorted(times)
        assert len(times) < 300


def test_live_traffic_is_watched_where_no_log_can_be_written(tmp_path):
    (tmp_path / "file").touch()
    logs = tmp_path / "file" / "logs"
    process, url = start(
        f"tcp://127.0.0.1:{free_port()}", "--log-dir", str(logs), "--pilot", "straight"
    )
    try:
        with viewing(url) as viewer:
            notes: list[str] = []
            while not any("log cannot be written" in note for note in notes):
                message = json.loads(viewer.recv(timeout=PATIENCE_S))
                notes = message["notes"] if message["type"] == "session" else notes
            assert str(tmp_path) not in "".join(notes)
    finally:
        process.kill()
        process.wait(timeout=PATIENCE_S)
