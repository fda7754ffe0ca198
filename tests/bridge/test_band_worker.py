"""Bands beside frames: of the frame shown or not at all, and never much work."""

import asyncio
import itertools
import json
import math

import msgspec
import pytest
from tests.bridge.frames import Other, frame
from tests.bridge.test_server import Page, page
from tests.clock import clock, now_s, run

from glasshelm.bridge.annotate import band_worker
from glasshelm.bridge.annotate.band_worker import CPU_SHARE, BandWorker, band_message
from glasshelm.bridge.server.protocol import BandMessage, Open
from glasshelm.bridge.sessions.log_index import LogIndex
from glasshelm.bridge.sessions.source_list import SourceList
from glasshelm.certify.logged_measurements import MAX_CELLS
from glasshelm.certify.sensor_error_bounds import parse_error_bounds
from glasshelm.frames import schema as f
from glasshelm.pilots.registry import pilot_named

ERRORS = parse_error_bounds("10,0.5,0.1")
BAND = f.Band(0.01, 0.02, 10.0, 0.01, 0.05, "starboard")


class Computing:
    """In place of the real thing and its thread: takes so long, and keeps what it was asked for."""

    def __init__(self, takes_s: float):
        self.takes_s, self.asked, self.busy_s = takes_s, [], 0.0
        self._busy = False

    async def __call__(self, frames, named, errors, cells) -> BandMessage:
        assert not self._busy, "one at a time"
        self._busy = True
        self.asked.append((frames[-1].time_s, cells))
        begun_s = now_s()
        await asyncio.sleep(self.takes_s * (1 + (cells - 1) // 4) if cells else 0.0)
        self.busy_s += now_s() - begun_s
        self._busy = False
        band = BAND if cells else None
        return BandMessage(frames[-1].time_s, frames[-1].pilot, 0.0, band, "", "")


@pytest.fixture
def computing(monkeypatch):
    def begin(takes_s: float) -> Computing:
        one = Computing(takes_s)
        monkeypatch.setattr(band_worker, "band_message", one)
        monkeypatch.setattr(band_worker, "time", clock)
        return one

    return begin


def shown(every_s: float, count: int, then_s: float = 0.0, stands_s: float | None = None):
    """What is told while frames follow each other, and at the time of which frame."""
    heard: list[tuple[float, dict]] = []

    async def play() -> None:
        now = 0.0
        beside = BandWorker(
            ERRORS,
            pilot_named,
            lambda told: heard.extend((now, json.loads(message)) for _, message in told),
        )
        task = asyncio.create_task(beside.run())
        for k in range(count):
            now = 5.0 * k
            beside.request([frame(now)], every_s if stands_s is None else stands_s)
            await asyncio.sleep(every_s)
        await asyncio.sleep(then_s)
        task.cancel()
        beside.close()

    run(play())
    return heard


def test_a_frame_that_stands_gets_the_narrowest_band_once(computing):
    work = computing(0.001)
    heard = shown(0.3, 1, stands_s=math.inf)
    assert [(now, told["time_s"]) for now, told in heard] == [(0.0, 0.0)]
    assert work.asked == [(0.0, MAX_CELLS)]


def test_a_band_that_came_too_late_is_not_told(computing):
    computing(0.1)
    heard = shown(0.1, 10, then_s=4.0, stands_s=math.inf)
    assert heard
    assert all(now == told["time_s"] for now, told in heard)
    assert heard[-1][0] == 45.0, "the last frame stays, and has its own"


def test_work_is_bounded_however_fast_frames_come(computing):
    """The first bands, while their speed is not known yet, may be more than their share."""
    work = computing(0.02)
    shown(0.01, 200, stands_s=math.inf)
    assert len(work.asked) < 20
    assert 0 < work.busy_s < 1.6 * CPU_SHARE * 200 * 0.01


@pytest.mark.parametrize(
    ("stands_s", "cells"), [(math.inf, MAX_CELLS), (0.81, 5), (0.41, 1), (0.1, 0)]
)
def test_as_many_bounds_as_there_is_time_for(computing, stands_s, cells):
    work = computing(0.1)
    heard = shown(0.35, 1, then_s=0.6, stands_s=stands_s)
    assert work.asked == [(0.0, cells)]
    assert (heard[0][1]["band"] is not None) == (cells > 0)


def test_a_machine_that_was_busy_is_tried_again(computing):
    work = computing(0.001)

    async def play() -> None:
        beside = BandWorker(ERRORS, pilot_named, lambda told: None)
        beside._batch_times_s.extend([1.5] * 5)  # too long for frames of 5 s
        task = asyncio.create_task(beside.run())
        for k in range(100):
            beside.request([frame(5.0 * k)], 5.0)
            await asyncio.sleep(0.01)
        task.cancel()
        beside.close()

    run(play())
    assert work.asked[0][1] == 0
    assert any(cells > 0 for _, cells in work.asked)


def test_without_errors_nothing_is_told(computing):
    work = computing(0.0)

    async def play() -> None:
        beside = BandWorker(None, pilot_named, lambda told: None)
        task = asyncio.create_task(beside.run())
        beside.request([frame(0)], math.inf)
        await asyncio.sleep(60)
        task.cancel()
        beside.close()

    run(play())
    assert work.asked == []


def test_a_logged_band_is_told_as_it_was_logged():
    logged = msgspec.structs.replace(
        frame(0, Other()), decision=f.Decision(0.015), band=BAND, pilot="nobody-knows"
    )
    message = band_message([logged], pilot_named, parse_error_bounds("99,9,9"), MAX_CELLS)
    assert message.band == BAND
    assert message.short == "certain: to starboard"
    assert "within 10 m" in message.full


@pytest.mark.parametrize(
    ("pilot", "why"),
    [("straight", "has no network"), ("paper-attention", "attention actor")],
)
def test_who_cannot_be_certified_has_no_band_and_the_reason_is_told(pilot, why):
    named = pilot_named(pilot)
    weights = getattr(named, "weights_sha256", None)
    one = msgspec.structs.replace(frame(0), pilot=pilot, weights_sha256=weights)
    message = band_message([one], pilot_named, ERRORS, MAX_CELLS)
    assert message.band is None
    assert message.short == ""
    assert message.full.startswith("no certified band: ")
    assert why in message.full


def _until_band(viewer: Page) -> dict:
    """The next band, and that it is of the frame that was told last."""
    while True:
        message = viewer._socket.receive_json()
        if message["type"] == "frame":
            viewer.now = message
        if message["type"] == "band":
            shown = viewer.now["frame"]
            assert message["time_s"] == shown["time_s"]
            assert message["rudder_rad"] == shown["decision"]["rudder_rad"]
            return message


def test_the_bridge_tells_the_band_of_the_frame_shown(tmp_path):
    from starlette.testclient import TestClient

    from glasshelm.bridge.server.access_control import AccessControl
    from glasshelm.bridge.server.app import create_app
    from glasshelm.bridge.server.session_hub import SessionHub
    from glasshelm.bridge.sessions.session_factory import prepare_session

    catalogue = SourceList(LogIndex(tmp_path))
    first = prepare_session(Open("random:35", "paper-sum", "paper"), catalogue, tmp_path)
    hub = SessionHub(catalogue, tmp_path, errors=ERRORS)
    app = create_app(hub, AccessControl("127.0.0.1", None), first)
    with TestClient(app, base_url="http://127.0.0.1") as client, page(client) as viewer:
        viewer.until("alarms").ask("pause").until("session")
        for time_s in (0.0, 300.0, 60.0):
            viewer.ask("seek", time_s=time_s).until("history", "frame")
            message = _until_band(viewer)
            band = message["band"]
            assert band["low_rad"] <= message["rudder_rad"] <= band["high_rad"]
            assert band["position_m"] == 10.0
        with page(client) as late:
            assert _until_band(late) == message
        viewer.ask("rate", rate=10).ask("play").until("frame", "frame", "frame")
        viewer.ask("pause").until("session")
        last = _until_band(viewer)
        while last["band"] is None:
            last = _until_band(viewer)
        viewer.ask("pilot", name="paper-attention").until("history", "frame")
        assert "attention actor" in _until_band(viewer)["full"]
        log = (tmp_path / viewer.session["log"]).read_text().splitlines()
    times = [json.loads(line)["time_s"] for line in log]
    assert all(b > a for a, b in itertools.pairwise(times))
    assert not any('"band"' in line for line in log), "it is told beside the frames"


def test_a_band_that_fails_is_told_and_the_next_one_is_computed(monkeypatch):
    failing, made = [True], []

    def computed(frames, named, errors, cells):
        if failing:
            raise ZeroDivisionError("/home/somebody/band.py")
        return band_worker.to_message(frames[-1])

    monkeypatch.setattr(band_worker, "band_message", computed)
    frames = [frame(0.0), frame(5.0)]

    async def watch():
        computer = BandWorker(ERRORS, pilot_named, made.extend)
        task = asyncio.create_task(computer.run())
        computer.request(frames[:1], 100.0)
        while not made:
            await asyncio.sleep(0.01)
        failing.clear()
        computer.request(frames, 100.0)
        while len(made) < 2:
            await asyncio.sleep(0.01)
        task.cancel()
        computer.close()

    asyncio.run(watch())
    first, second = [json.loads(message) for _, message in made]
    assert first["full"] == "no certified band: it failed (ZeroDivisionError: band.py)"
    assert (second["time_s"], "failed" in second["full"]) == (5.0, False)
