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
import websockets.sync.client as ws
from tests.bridge.frames import Other, frame
from tests.bridge.process import free_port, start

from glasshelm.bridge.again import Again
from glasshelm.bridge.app import application
from glasshelm.bridge.catalogue import Catalogue
from glasshelm.bridge.conductor import Conductor
from glasshelm.bridge.guard import Guard
from glasshelm.bridge.logs import Shelf
from glasshelm.bridge.outbox import MOST_FRAMES, MOST_OTHERS
from glasshelm.bridge.record import Record

WAIT_S = 180.0


def test_what_was_seen_before_kill_9_can_be_seen_again(tmp_path):
    options = ("--log", str(tmp_path), "--port", str(free_port()))
    process, url = start("imazu:1", "--pilot", "straight", *options)
    seen = []
    try:
        with ws.connect(url, max_size=None) as viewer:
            viewer.send('{"type":"rate","rate":60}')
            while len(seen) < 12:
                message = json.loads(viewer.recv(timeout=WAIT_S))
                if message["type"] == "failure":  # the source is still being opened
                    time.sleep(0.2)
                    viewer.send('{"type":"rate","rate":60}')
                if message["type"] == "frame":
                    seen.append(message["frame"])
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.wait(timeout=30)
    (log,) = tmp_path.glob("*.jsonl")
    kept = [json.loads(line) for line in log.read_bytes().split(b"\n")[:-1]]
    assert kept[: len(seen)] == seen
    with open(log, "ab") as torn:  # as if killed in the middle of a line
        torn.write(log.read_bytes()[:100])
    process, url = start("--replay", str(log), *options)
    try:
        with ws.connect(url, max_size=None) as viewer:
            viewer.send(json.dumps({"type": "seek", "time_s": seen[-1]["time_s"]}))
            again: list[dict] = []
            while len(again) < len(seen):
                message = json.loads(viewer.recv(timeout=WAIT_S))
                if message["type"] == "failure":
                    viewer.send(json.dumps({"type": "seek", "time_s": seen[-1]["time_s"]}))
                if message["type"] == "history":
                    again = message["frames"]
                if message["type"] == "frame" and again:
                    again.append(message["frame"])
            assert again[: len(seen)] == seen
    finally:
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=30) in (0, 130)


def test_ctrl_c_does_not_wait_for_a_compiler(tmp_path):
    """The first session of an installation: its programs take longer than this to compile."""
    nothing_compiled = {"XDG_CACHE_HOME": str(tmp_path), "JAX_ENABLE_COMPILATION_CACHE": "false"}
    process, url = start(
        "random:35", "--log", str(tmp_path), "--port", str(free_port()), **nothing_compiled
    )
    try:
        with ws.connect(url, max_size=None) as viewer:
            while json.loads(viewer.recv(timeout=WAIT_S))["type"] != "preparing":
                pass
            time.sleep(3)
            began = time.monotonic()
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=60) in (0, 130)
            took_s = time.monotonic() - began
    finally:
        process.kill()
        process.wait(timeout=30)
    assert took_s < 10


class _Stream(Again):
    """A log played a hundred times as fast as it can be read by anybody slow."""

    @property
    def step_s(self) -> float:
        return 0.005


@pytest.fixture
def flood(tmp_path):
    """A server of 400 frames of about 100 kB each, and its conductor."""
    record = Record(tmp_path / "long.jsonl", fresh=True)
    others = [Other(str(k), east_m=5000.0 + 100 * k, fed=False) for k in range(330)]
    for k in range(400):
        record.append(frame(5 * k, *others))
    record.close()
    conductor = Conductor(Catalogue(Shelf(tmp_path)), tmp_path)
    app = application(
        conductor, Guard("127.0.0.1", None), lambda: _Stream(Record(record.path, fresh=False))
    )
    bound = socket.create_server(("127.0.0.1", 0))
    config = uvicorn.Config(app, log_level="error", ws_per_message_deflate=False)
    server = uvicorn.Server(config)
    thread = threading.Thread(target=lambda: asyncio.run(server.serve(sockets=[bound])))
    thread.start()
    try:
        yield conductor, f"ws://127.0.0.1:{bound.getsockname()[1]}/ws", record.path.stat().st_size
    finally:
        server.should_exit = True
        thread.join(timeout=60)


def test_a_viewer_who_does_not_read_loses_frames_and_costs_no_memory(flood):
    conductor, url, size = flood
    with (
        ws.connect(url, max_size=None, max_queue=1) as slow,
        ws.connect(url, max_size=None) as fast,
    ):
        for viewer in (slow, fast):
            assert json.loads(viewer.recv(timeout=60))["type"] == "hello"
        held, last = 0, 0.0
        while last < 1995.0:  # the fast one reads to the end; the slow one reads nothing
            message = json.loads(fast.recv(timeout=60))
            if message["type"] == "frame":
                last = message["frame"]["time_s"]
            for outbox in conductor.viewers:
                assert len(outbox) <= MOST_FRAMES + MOST_OTHERS + 5
                waiting = sum(len(text) for kind, text in outbox._waiting if kind == "frame")
                held = max(held, waiting)
        dropped = max(outbox.dropped for outbox in conductor.viewers)
        assert dropped > 100
        assert held < size / 20
        # She who was slow gets the newest ones when she reads again.
        times = []
        while not times or times[-1] < 1995.0:
            message = json.loads(slow.recv(timeout=60))
            if message["type"] == "frame":
                times.append(message["frame"]["time_s"])
        assert times == sorted(times)
        assert len(times) < 300
