"""What a viewer asked for ends when she leaves; a change that has begun is done whole."""

import asyncio
import threading

import pytest
from tests.bridge.test_background_jobs import ASKED, SOON_S, Viewer, held, playing

from glasshelm.bridge.server import session_hub
from glasshelm.bridge.server.presenter import Presenter
from glasshelm.bridge.server.request_queue import MAX_QUESTIONS, MAX_SLOW_REQUESTS
from glasshelm.bridge.server.session_hub import SessionHub

__all__ = ["held"]


async def becomes(so) -> None:
    async with asyncio.timeout(SOON_S):
        while not so():
            await asyncio.sleep(0.01)


def shown(hub: SessionHub) -> str:
    return hub.player.require_presenter().session.info.source


def test_nothing_is_opened_for_who_has_left(tmp_path, held, monkeypatch):
    """Neither what waits, nor what is being prepared; that is closed again."""
    begun, go_on = held
    opened, closed = [], []
    slowly, close = session_hub.open_session, Presenter.close

    def counted(*args):
        opened.append(args)
        return slowly(*args)

    monkeypatch.setattr(session_hub, "open_session", counted)
    monkeypatch.setattr(Presenter, "close", lambda self: (closed.append(self), close(self)))

    async def leave():
        async with playing(tmp_path) as (hub, first):
            others = [await Viewer(hub).join() for _ in range(3)]
            for viewer in others:
                for _ in range(MAX_SLOW_REQUESTS):
                    await viewer.ask("open", source="imazu:2", pilot="straight")
            await asyncio.to_thread(begun.wait, SOON_S)
            for viewer in others:
                hub.leave(viewer.outbox)
            await becomes(lambda: not hub._requests)
            go_on.set()
            await becomes(lambda: closed)
            assert (await first.next("preparing"))["task"] is None
            assert len(opened) == 1
            assert shown(hub) == "imazu:1"
            # And the next who asks is served.
            await first.ask("open", source="imazu:3", pilot="straight")
            await becomes(lambda: shown(hub) == "imazu:3")
            await becomes(lambda: len(closed) == 2)  # the old session, and the unwanted one

    asyncio.run(leave())
    assert len(list(tmp_path.glob("*.jsonl"))) <= 3


def test_what_is_prepared_is_not_shown_if_she_leaves_before_its_turn(tmp_path, monkeypatch):
    closed = []
    close = Presenter.close
    monkeypatch.setattr(Presenter, "close", lambda self: (closed.append(self), close(self)))

    async def leave():
        async with playing(tmp_path) as (hub, _):
            other = await Viewer(hub).join()
            async with hub.player.lock:  # somebody uses the session shown
                await other.ask("open", source="imazu:2", pilot="straight")
                await becomes(lambda: len(list(tmp_path.glob("*.jsonl"))) == 2)
                await becomes(lambda: hub.player.lock._waiters)
                hub.leave(other.outbox)
                await becomes(lambda: closed)
            assert shown(hub) == "imazu:1"

    asyncio.run(leave())


def test_a_change_that_has_begun_is_done_whole(tmp_path, monkeypatch):
    """The others are told of it, and the clock goes on."""
    begun, go_on = threading.Event(), threading.Event()
    seek = Presenter.seek

    def slowly(self, time_s):
        begun.set()
        assert go_on.wait(SOON_S)
        return seek(self, time_s)

    monkeypatch.setattr(Presenter, "seek", slowly)

    async def leave():
        async with playing(tmp_path) as (hub, first):
            other = await Viewer(hub).join()
            await other.ask("seek", time_s=100.0)
            await asyncio.to_thread(begun.wait, SOON_S)
            hub.leave(other.outbox)
            await becomes(lambda: not hub._requests)
            go_on.set()
            while (await first.next("frame"))["frame"]["time_s"] < 100.0:
                pass
            await first.ask("rate", rate=60)
            assert (await first.next("frame"))["frame"]["time_s"] > 100.0

    asyncio.run(leave())


@pytest.mark.parametrize("asked", ASKED, ids=lambda asked: asked["type"])
def test_only_so_much_is_prepared_for_one_viewer(tmp_path, held, asked):
    _, go_on = held

    async def ask():
        async with playing(tmp_path) as (hub, viewer):
            for _ in range(MAX_SLOW_REQUESTS + 1):
                await viewer.ask(**asked)
            said = (await viewer.next("error"))["message"]
            assert said.startswith(f"{MAX_SLOW_REQUESTS} of your requests are being prepared")
            other = await Viewer(hub).join()
            await other.ask("rate", rate=5)  # she is held up by nobody
            await becomes(lambda: hub.player.rate == 5)
            go_on.set()
            await becomes(lambda: not hub._requests)
            await viewer.ask("rate", rate=6)
            await viewer.ask(**asked)
            await becomes(lambda: not hub._requests)
            assert hub.n_failed == 1

    asyncio.run(ask())


def test_questions_end_with_who_asked_them(tmp_path):
    async def ask():
        async with playing(tmp_path) as (hub, first):
            gone = await Viewer(hub).join()
            async with hub.player.lock:
                for _ in range(MAX_QUESTIONS + 1):
                    await gone.ask("whatif", change="keep_course")
                assert "too many questions" in (await gone.next("error"))["message"]
                hub.leave(gone.outbox)
                await becomes(lambda: not hub._questions)
            await first.ask("whatif", change="keep_course")
            assert (await first.next("whatif"))["change"] == "keep_course"
            assert not any(kind == "whatif" for kind, _ in gone.outbox._waiting)

    asyncio.run(ask())
