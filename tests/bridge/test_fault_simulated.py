"""Simulated and replayed voyages on a disk that fails: they pause, say why, and go on."""

import asyncio
import errno
import json
import os

import pytest
from tests.bridge.frames import Other, frame
from tests.broken_disk import BrokenDisk

from glasshelm.bridge.server.presenter import Presenter
from glasshelm.bridge.server.protocol import DEFAULT_ALARM_LIMITS, Compare, Play, Seek, SetPilot
from glasshelm.bridge.server.session_hub import SessionHub
from glasshelm.bridge.server.viewer_queue import ViewerQueue
from glasshelm.bridge.sessions import session_log
from glasshelm.bridge.sessions.log_index import LogIndex
from glasshelm.bridge.sessions.replay_session import ReplaySession
from glasshelm.bridge.sessions.session_log import FileLog, RecentLines
from glasshelm.bridge.sessions.simulated_session import SimulatedSession
from glasshelm.bridge.sessions.source_list import SourceList
from glasshelm.core.errors import InputError
from glasshelm.encounters.scenario_factory import scenario_from
from glasshelm.frames import frame_log
from glasshelm.pilots.straight import StraightPilot
from glasshelm.ship.nomoto import ship_named


def sailing(folder) -> SimulatedSession:
    ship = ship_named("paper")
    return SimulatedSession(scenario_from("imazu:1", ship), StraightPilot(), "paper", False, folder)


class Played:
    """A session whose steps are taken one by one."""

    def __init__(self, folder, session):
        self.session, self.presenter = session, Presenter(session, DEFAULT_ALARM_LIMITS)
        self.hub = SessionHub(SourceList(LogIndex(folder)), folder)
        self.hub.player.presenter, self.hub.player.playing = self.presenter, True
        self.viewer = ViewerQueue()
        self.hub.viewers.add(self.viewer)
        self.times: list[float] = []
        self.notices: list[str] = []

    async def step(self) -> None:
        await self.hub.player.advance()
        await self.hear()

    async def ask(self, asked) -> bool:
        """Whether it was done."""
        try:
            await self.hub.execute(asked)
        except InputError:
            return False
        await self.hear()
        return True

    async def hear(self) -> None:
        while len(self.viewer):
            message = json.loads(await self.viewer.get())
            if message["type"] == "frame":
                self.times.append(message["frame"]["time_s"])
            elif message["type"] == "history":
                self.times = [one["time_s"] for one in message["frames"]]
            elif message["type"] == "notice":
                self.notices.append(message["message"])


@pytest.mark.parametrize("compared", [False, True])
@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EIO], ids=os.strerror)
def test_play_goes_on_at_the_same_step_when_the_fault_is_gone(
    tmp_path, monkeypatch, code, compared
):
    disk = BrokenDisk(monkeypatch, tmp_path, code)

    async def voyage(first: int, folder):
        played = Played(folder, sailing(folder))
        await played.step()
        if compared:
            assert await played.ask(Compare("straight"))
        await played.step()
        disk.fail(first)
        for _ in range(2):
            await played.step()
        failed = bool(disk.failed)
        disk.heal()
        if not played.hub.player.playing:
            assert os.strerror(code) in played.notices[-1]
            assert played.hub.player.faults == [played.notices[-1]]
            await played.step()
            assert len(played.times) < 4, "paused is paused"
            assert await played.ask(Play())
        while len(played.times) < 5:
            await played.step()
        assert played.hub.player.faults == []
        assert played.times == [5.0 * k for k in range(5)]
        logs = [
            [f.time_s for f in frame_log.read_log(log)] for log in sorted(folder.glob("*.jsonl"))
        ]
        assert logs == [played.times] * (1 + compared)
        played.hub.close()
        return failed

    first = 1
    while asyncio.run(voyage(first, tmp_path / f"{first:03d}")):
        first += 1
    assert first > 3


@pytest.mark.parametrize("asked", [SetPilot("straight"), Compare("straight"), Seek(40.0)])
def test_what_is_asked_on_a_failing_disk_is_refused_and_can_be_asked_again(
    tmp_path, monkeypatch, asked
):
    disk = BrokenDisk(monkeypatch, tmp_path)

    async def voyage(first: int, folder):
        played = Played(folder, sailing(folder))
        for _ in range(4):
            await played.step()
        disk.fail(first)
        done = await played.ask(asked)
        failed = bool(disk.failed)
        disk.heal()
        if not done:
            assert await played.ask(asked)
        at = played.times[-1]
        assert at == (40.0 if isinstance(asked, Seek) else 15.0)
        assert await played.ask(Play())
        await played.step()
        assert played.times == [5.0 * k for k in range(int(at) // 5 + 2)]
        assert played.hub.player.faults == []
        read = [f.time_s for f in frame_log.read_log(played.session.log.path)]
        assert read == played.times
        played.hub.close()
        return failed

    first = 1
    while asyncio.run(voyage(first, tmp_path / f"{first:03d}")):
        first += 1
    assert first > 3


def test_a_log_removed_under_a_voyage_is_there_again_whole(tmp_path):
    async def voyage():
        played = Played(tmp_path, sailing(tmp_path))
        for _ in range(3):
            await played.step()
        played.session.log.path.unlink()
        await played.step()
        return played

    played = asyncio.run(voyage())
    assert played.times == [0.0, 5.0, 10.0, 15.0]
    (log,) = tmp_path.glob("*.jsonl")
    assert [f.time_s for f in frame_log.read_log(log)] == played.times
    played.hub.close()


def test_a_replay_that_cannot_be_read_pauses_and_goes_on(tmp_path, monkeypatch):
    frame_log.write_log(tmp_path / "a.jsonl", [frame(5 * k, Other()) for k in range(6)])
    disk = BrokenDisk(monkeypatch, tmp_path, errno.EIO)

    async def voyage():
        played = Played(tmp_path, ReplaySession(FileLog(tmp_path / "a.jsonl", fresh=False)))
        await played.step()
        disk.fail(1)
        await played.step()
        disk.heal()
        assert not played.hub.player.playing
        assert played.notices == ["a.jsonl: cannot read the log (Input/output error)"]
        assert await played.ask(Play())
        for _ in range(5):
            await played.step()
        played.hub.close()
        return played.times

    assert asyncio.run(voyage()) == [5.0 * k for k in range(6)]


def test_a_log_that_shrank_is_told(tmp_path):
    frame_log.write_log(tmp_path / "a.jsonl", [frame(5 * k, Other()) for k in range(6)])
    record = FileLog(tmp_path / "a.jsonl", fresh=False)
    os.truncate(tmp_path / "a.jsonl", 100)
    with pytest.raises(InputError, match=r"a\.jsonl: cannot read the log \(it was cut off\)"):
        record.line(4)


@pytest.mark.parametrize("end", [b"", b"\n"])
def test_no_line_is_read_beyond_what_a_frame_may_have(tmp_path, monkeypatch, end):
    monkeypatch.setattr(frame_log, "MAX_LINE_BYTES", 10_000)
    path = tmp_path / "a.jsonl"
    frame_log.write_log(path, [frame(0.0)])
    with open(path, "ab") as file:
        file.write(b"x" * 20_000 + end)
    for read in (lambda: FileLog(path, fresh=False), lambda: list(frame_log.read_log(path))):
        with pytest.raises(InputError, match="line 2 is longer than any frame"):
            read()


def test_how_far_a_log_was_read_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(session_log, "_PROGRESS_BYTES", 1000)
    path = tmp_path / "a.jsonl"
    frame_log.write_log(path, [frame(5 * k, Other()) for k in range(20)])
    shares: list[float] = []
    FileLog(path, False, shares.append)
    assert shares == sorted(shares)
    assert len(shares) > 5
    assert 0.0 <= shares[0] < shares[-1] <= 1.0


def test_the_lines_in_memory_are_bounded_in_number_and_bytes():
    recent = RecentLines([b"%d" % k for k in range(5)], max_lines=3)
    assert list(recent.lines) == [b"2", b"3", b"4"]
    recent = RecentLines(recent.lines, max_bytes=5)
    assert list(recent.lines) == [b"3", b"4"]
    recent.append(b"5")
    recent.trim()
    assert list(recent.lines) == [b"4", b"5"]
    assert list(RecentLines([b"a", b"b" * 100], max_bytes=5).lines) == [b"b" * 100]
