"""Everything that a live session does fails in turn: frames and alarms go on, and all heals."""

import asyncio
import concurrent.futures
import errno
import json
import os
import shutil
from collections.abc import Callable

import pytest
from tests.bridge.test_live_session import Clock, Made, report
from tests.broken_disk import BrokenDisk

from glasshelm.bridge.annotate import frame_annotator
from glasshelm.bridge.annotate.alarms import AlarmList
from glasshelm.bridge.annotate.band_worker import BandWorker
from glasshelm.bridge.server import fault_log
from glasshelm.bridge.server.fault_log import FaultLog, describe_error, supervise
from glasshelm.bridge.server.presenter import Presenter
from glasshelm.bridge.server.protocol import DEFAULT_ALARM_LIMITS
from glasshelm.bridge.server.session_hub import SessionHub
from glasshelm.bridge.server.viewer_queue import ViewerQueue
from glasshelm.bridge.sessions import live_log
from glasshelm.bridge.sessions.live_session import LiveSession
from glasshelm.bridge.sessions.log_index import LogIndex
from glasshelm.bridge.sessions.source_list import SourceList
from glasshelm.colregs.encounter_tracker import EncounterTracker
from glasshelm.core.errors import InputError
from glasshelm.feeds.connection import Backoff
from glasshelm.frames import frame_log
from glasshelm.live.signalk_writer import SignalKWriter
from glasshelm.pilots.straight import StraightPilot
from glasshelm.simulation.live_advisor import LiveAdvisor

CODES = [errno.ENOSPC, errno.EIO, errno.EACCES]


class Writer(SignalKWriter):
    """What stands on the server: the rudder and the alarms told last; None: withdrawn."""

    def __init__(self):
        self.stands = None
        self.last_error = None

    def publish(self, frame, alarms):
        rudder = None if frame.decision is None else frame.decision.rudder_rad
        self.stands = rudder, [alarm.target for alarm in alarms]

    def withdraw(self):
        self.stands = None


class Watched:
    """A live session, a collision course, and a viewer; one look after the other."""

    def __init__(self, folder):
        self.feed, self.picture, self.writer = Made(), Clock(), Writer()
        self.live = LiveSession(
            "tcp://made:1", self.feed, self.picture, StraightPilot(), "paper", folder
        )
        self.presenter = Presenter(self.live, DEFAULT_ALARM_LIMITS)
        self.hub = SessionHub(SourceList(LogIndex(folder)), folder, self.writer)
        self.hub.player.presenter, self.hub.player.playing = self.presenter, True
        self.viewer = ViewerQueue()
        self.hub.viewers.add(self.viewer)
        self.time_s = 0.0
        self.frames: list[dict] = []
        self.alarms: list[dict] = []
        self.notes: list[str] = []

    async def look(self) -> int:
        """How many frames one look has shown."""
        self.time_s += 5.0
        self.feed.given = [
            report("230000001", self.time_s, 0.0, 5.0, own=True),
            report("230000002", self.time_s, 2000.0, 1.0),
        ]
        await self.live.listen()
        self.picture.time_s = self.time_s
        await self.hub.player.advance()
        shown = 0
        while len(self.viewer):
            message = json.loads(await self.viewer.get())
            if message["type"] == "frame":
                shown += 1
                self.frames.append(message["frame"])
            elif message["type"] == "history":
                self.frames = message["frames"]
            elif message["type"] == "alarms":
                self.alarms = message["alarms"]
            elif message["type"] == "session":
                self.notes = message["notes"]
        return shown

    @property
    def faults(self) -> list[str]:
        return self.hub.player.faults

    def logged(self, folder) -> list[dict]:
        """The frames of all logs, which can be read."""
        frames = []
        for path in sorted(folder.glob("*.jsonl")):
            frames += [frame.time_s for frame in frame_log.read_log(path)]
        return frames

    def close(self) -> None:
        self.hub.close()


@pytest.fixture
def watched(tmp_path):
    made = []

    def begin(folder) -> Watched:
        made.append(Watched(folder))
        return made[-1]

    yield begin
    for one in made:
        one.close()


def shown_times(one: Watched) -> list[float]:
    return [frame["time_s"] for frame in one.frames]


@pytest.mark.parametrize(
    ("code", "count"), [(errno.ENOSPC, 1_000), (errno.EACCES, 1_000), (errno.EIO, 1)]
)
def test_every_call_of_the_log_fails_in_turn(watched, tmp_path, monkeypatch, code, count):
    disk = BrokenDisk(monkeypatch, tmp_path, code)
    names: set[str] = set()
    for first in range(1, 200):
        folder = tmp_path / f"{first:03d}"

        async def voyage(folder=folder, first=first):
            one = watched(folder)
            for _ in range(2):
                assert await one.look() == 1
            disk.fail(first, count)
            for _ in range(3):
                assert await one.look() == 1, f"call {first}: no frame"
                assert one.alarms[0]["target"] == "230000002"
                assert one.writer.stands == (0.0, ["230000002"])
                if "write" in disk.failed and count > 1:
                    line = f"the log cannot be written ({os.strerror(code)}): frames are shown"
                    assert one.notes[0].startswith(line)
                    assert one.faults[0].startswith(line)
            some_failed = bool(disk.failed)
            names.update(disk.failed)
            disk.heal()
            for _ in range(2):
                assert await one.look() == 1
            assert one.faults == []
            assert not any("log" in note for note in one.notes)
            assert shown_times(one) == [5.0 * k for k in range(7)]
            return one.logged(folder), some_failed

        logged, some_failed = asyncio.run(voyage())
        assert logged == [5.0 * k for k in range(7)], f"call {first}"
        if not some_failed:
            break
    else:
        raise AssertionError("there was always one more call")
    assert first > 5
    assert {"write", "seek", "fstat"} <= names


@pytest.mark.parametrize("code", CODES, ids=os.strerror)
@pytest.mark.parametrize("count", [1, 1_000])
def test_a_session_opens_without_a_log(watched, tmp_path, monkeypatch, code, count):
    disk = BrokenDisk(monkeypatch, tmp_path, code)
    for first in range(1, 10):
        folder = tmp_path / f"{first:03d}"

        async def voyage(folder=folder, first=first):
            disk.fail(first, count)
            one = watched(folder)
            assert await one.look() == 1
            failed = bool(disk.failed)
            disk.heal()
            assert await one.look() == 1
            assert one.faults == []
            return failed, one.logged(folder)

        failed, logged = asyncio.run(voyage())
        assert logged == [0.0, 5.0]
        if not failed:
            break
    assert first > 3


def folder_removed(folder):
    shutil.rmtree(folder)


def file_removed(folder):
    next(folder.glob("*.jsonl")).unlink()


def file_in_place_of_the_folder(folder):
    shutil.rmtree(folder)
    folder.touch()


@pytest.mark.parametrize("harm", [folder_removed, file_removed, file_in_place_of_the_folder])
def test_what_was_removed_is_logged_again(watched, tmp_path, harm: Callable):
    folder = tmp_path / "logs"

    async def voyage():
        one = watched(folder)
        for _ in range(3):
            assert await one.look() == 1
        harm(folder)
        assert await one.look() == 1
        if folder.is_file():
            assert "its folder is a file" in one.notes[0]
            folder.unlink()
        assert await one.look() == 1
        assert one.faults == []
        return one.logged(folder)

    assert asyncio.run(voyage()) == [0.0, 5.0, 10.0, 15.0, 20.0]


def test_a_clock_that_jumps_back_while_no_log_can_be_begun(watched, tmp_path, monkeypatch):
    disk = BrokenDisk(monkeypatch, tmp_path)

    async def voyage():
        one = watched(tmp_path)
        one.time_s = 7200.0
        for _ in range(2):
            assert await one.look() == 1
        one.time_s = 0.0
        disk.fail(1, 10_000)
        shown = sum([await one.look() for _ in range(8)])
        disk.heal()
        assert await one.look() == 1
        assert one.faults == []
        return shown, shown_times(one)

    shown, times = asyncio.run(voyage())
    assert shown >= 5  # it takes some reports to believe another time
    assert times == [5.0 * k for k in range(len(times))]
    logs = [
        [frame.time_s for frame in frame_log.read_log(path)] for path in tmp_path.glob("*.jsonl")
    ]
    assert times in logs


def test_memory_is_bounded_and_what_it_could_not_hold_is_told(watched, tmp_path, monkeypatch):
    monkeypatch.setattr(live_log, "MAX_HELD_FRAMES", 4)
    disk = BrokenDisk(monkeypatch, tmp_path)

    async def voyage():
        one = watched(tmp_path)
        assert await one.look() == 1
        disk.fail(1, 10_000)
        for _ in range(6):
            assert await one.look() == 1
        disk.heal()
        assert await one.look() == 1
        assert one.faults == []
        joined = one.presenter.snapshot()
        return one, joined

    one, joined = asyncio.run(voyage())
    assert one.logged(tmp_path) == [0.0, 15.0, 20.0, 25.0, 30.0, 35.0]
    assert one.notes[-1:] == ["2 frames were shown without being logged"]
    assert len(one.live.log._held.lines) == 4
    history = json.loads(joined[0][1])["frames"]
    assert [frame["time_s"] for frame in history] == [5.0 * k for k in range(7)]


PARTS = {
    "the look": (Presenter, "advance"),
    "the picture": (Clock, "scenario"),
    "the pilot": (LiveAdvisor, "look"),
    "the predicted track": (LiveAdvisor, "predicted"),
    "the rules": (EncounterTracker, "see"),
    "the sentence": (frame_annotator.FrameAnnotator, "_sentence"),
    "the alarms": (AlarmList, "update"),
    "the bands": (BandWorker, "request"),
    "the session's message": (Presenter, "session_message"),
    "writing back": (Writer, "publish"),
    "the log": (live_log.FrameLog, "append_line"),
}
NO_FRAME = {"the look", "the picture"}
WITHDRAWN = NO_FRAME | {"the alarms", "writing back"}
ERRORS = [
    ZeroDivisionError("division by zero"),
    MemoryError(),
    OSError(errno.EIO, "Input/output error", "/home/somebody/secret"),
    InputError("one clear line"),
    RuntimeError("in /home/somebody/secret.py\nof two lines"),
]


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
@pytest.mark.parametrize("part", PARTS)
def test_every_part_of_a_look_fails_in_turn(watched, tmp_path, monkeypatch, part, error):
    where, name = PARTS[part]
    really = getattr(where, name)

    def fails(self, *args, **more):
        if part == "the pilot" and self is not one.live._main.advisor:
            return really(self, *args, **more)
        raise error

    one = watched(tmp_path)

    async def voyage():
        for _ in range(2):
            assert await one.look() == 1
        assert one.writer.stands == (0.0, ["230000002"])
        assert one.faults == []
        notes = one.notes
        with monkeypatch.context() as broken:
            broken.setattr(where, name, fails)
            one.presenter._predicted_at = -1e9
            for _ in range(2):
                shown = await one.look()
                assert shown == (0 if part in NO_FRAME else 1)
                (why,) = one.faults
                assert "\n" not in why
                assert "/home" not in why
                assert part == "the session's message" or why in one.notes
                rudder = None if part == "the pilot" else 0.0
                stands = None if part in WITHDRAWN else (rudder, ["230000002"])
                assert one.writer.stands == stands
                assert one.hub.player.playing
        one.presenter._predicted_at = -1e9
        for _ in range(2):
            assert await one.look() == 1
        assert one.faults == []
        assert one.notes == notes
        assert one.writer.stands == (0.0, ["230000002"])
        assert one.alarms[0]["target"] == "230000002"

    asyncio.run(voyage())
    assert one.logged(tmp_path) == shown_times(one)


@pytest.mark.parametrize(
    "error",
    [SystemExit(), StopIteration(), KeyboardInterrupt(), concurrent.futures.CancelledError(),
     asyncio.CancelledError(), GeneratorExit()],
    ids=lambda error: type(error).__name__,
)  # fmt: skip
def test_a_thread_cannot_end_the_loop(watched, tmp_path, monkeypatch, error):
    one = watched(tmp_path)

    def fails(self):
        raise error

    async def voyage():
        with monkeypatch.context() as broken:
            broken.setattr(Presenter, "advance", fails)
            assert await asyncio.wait_for(one.look(), 60) == 0
        assert await one.look() == 1

    asyncio.run(voyage())


def test_who_joins_while_the_disk_fails_gets_everything(watched, tmp_path, monkeypatch):
    disk = BrokenDisk(monkeypatch, tmp_path, errno.EIO)

    async def voyage():
        one = watched(tmp_path)
        for _ in range(3):
            await one.look()
        disk.fail(1, 100_000)
        viewer = ViewerQueue()
        await one.hub.join(viewer)
        messages = [json.loads(await viewer.get()) for _ in range(len(viewer))]
        return {message["type"]: message for message in messages}

    told = asyncio.run(voyage())
    assert set(told) == {"hello", "session", "history", "frame", "alarms"}
    assert [frame["time_s"] for frame in told["history"]["frames"]] == [0.0, 5.0]
    assert told["frame"]["frame"]["time_s"] == 10.0


@pytest.fixture
def impatient(monkeypatch):
    monkeypatch.setattr(Backoff, "FIRST_S", 0.01)
    monkeypatch.setattr(fault_log, "RECOVERED_S", 0.1)


def test_what_runs_for_ever_is_begun_again_and_told_until_it_is_well(impatient):
    faults, begun, told = FaultLog(), [], []

    async def run():
        begun.append(1)
        if len(begun) < 4:
            raise ZeroDivisionError("/somewhere/else.py")
        await asyncio.sleep(3600)

    async def watch():
        task = asyncio.create_task(supervise("keeping time", run, faults, told.append))
        while len(begun) < 4:
            await asyncio.sleep(0.01)
            assert len(begun) in (0, 4) or faults.messages
        await asyncio.sleep(0.3)
        assert faults.messages == []
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        assert task.cancelled()

    asyncio.run(watch())
    assert told == ["keeping time failed (ZeroDivisionError: else.py): retrying"]


@pytest.mark.parametrize("what", ["play", "bands", "writer"])
def test_the_server_s_own_tasks_are_begun_again(impatient, tmp_path, monkeypatch, what):
    hub = SessionHub(SourceList(LogIndex(tmp_path)), tmp_path, Writer())
    where = {"play": hub.player, "bands": hub.player.bands, "writer": hub.player.writer}[what]
    begun = []

    async def run():
        begun.append(1)
        if len(begun) < 3:
            raise ValueError("no reason")
        await asyncio.sleep(3600)

    async def idle():
        await asyncio.sleep(3600)

    async def nothing():
        pass

    monkeypatch.setattr(hub.player.writer, "run", idle)
    monkeypatch.setattr(hub.player.writer, "close", nothing)
    monkeypatch.setattr(where, what if what == "play" else "run", run)

    async def watch():
        task = asyncio.create_task(hub.run())
        while len(begun) < 3:
            await asyncio.sleep(0.01)
        assert not task.done()
        assert hub.player.faults
        await asyncio.sleep(0.3)
        assert hub.player.faults == []
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)

    asyncio.run(watch())
    hub.close()


@pytest.mark.parametrize("error", [ValueError("odd"), InputError("the port is taken")])
def test_a_feed_that_fails_is_heard_again(impatient, watched, tmp_path, error):
    one = watched(tmp_path)
    heard = []

    async def reports():
        heard.append(1)
        if len(heard) < 3:
            raise error
        yield report("230000001", 5.0, 0.0, 5.0, own=True)
        await asyncio.sleep(3600)

    one.feed.reports = reports

    async def watch():
        task = asyncio.create_task(one.hub.player.listen(one.live))
        while not one.live._reports:
            await asyncio.sleep(0.01)
            assert len(heard) in (0, 3) or one.faults
        await asyncio.sleep(0.3)
        one.live.next_frame()
        assert one.faults == []
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)

    asyncio.run(watch())
    assert len(heard) == 3


def test_an_error_is_one_short_line_without_a_folder():
    assert describe_error(ValueError("a\n  b")) == "ValueError: a b"
    assert describe_error(OSError(errno.ENOSPC, "No space left on device", "/a/b")) == (
        "No space left on device"
    )
    assert describe_error(ValueError("C:\\Users\\me\\x.py")) == "ValueError: x.py"
    assert len(describe_error(ValueError("x" * 10_000))) == 200
    assert describe_error(MemoryError()) == "MemoryError"
