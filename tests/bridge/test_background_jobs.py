"""While one thing is prepared, what is shown goes on: frames, alarms, late joiners, pongs."""

import asyncio
import contextlib
import json
import threading

import equinox as eqx
import pytest
from tests.bridge.test_live_session import Made

from glasshelm.ais.reports import Feed
from glasshelm.bridge.server import session_hub
from glasshelm.bridge.server.background_jobs import BackgroundJobs
from glasshelm.bridge.server.protocol import Open
from glasshelm.bridge.server.request_queue import MAX_REQUESTS
from glasshelm.bridge.server.session_hub import SessionHub
from glasshelm.bridge.server.viewer_queue import ViewerQueue
from glasshelm.bridge.sessions.live_session import LiveSession, _lone_ship
from glasshelm.bridge.sessions.log_index import LogIndex
from glasshelm.bridge.sessions.session_factory import prepare_session
from glasshelm.bridge.sessions.simulated_session import SimulatedSession
from glasshelm.bridge.sessions.source_list import SourceList
from glasshelm.core.errors import InputError
from glasshelm.encounters.scenario_factory import scenario_from
from glasshelm.live.traffic_picture import TrafficPicture
from glasshelm.pilots.straight import StraightPilot
from glasshelm.ship.nomoto import ship_named

#: What is not held up is done far sooner, on any machine [s].
SOON_S = 300.0


class Viewer:
    """A viewer without a socket."""

    def __init__(self, hub: SessionHub):
        self.outbox, self._conductor = ViewerQueue(), hub

    async def join(self) -> "Viewer":
        await asyncio.wait_for(self._conductor.join(self.outbox), SOON_S)
        return self

    async def ask(self, type: str, **fields) -> None:
        heard = self._conductor.handle_message(self.outbox, json.dumps({"type": type, **fields}))
        await asyncio.wait_for(heard, SOON_S)

    async def next(self, kind: str) -> dict:
        while True:
            message = json.loads(await asyncio.wait_for(self.outbox.get(), SOON_S))
            if message["type"] == kind:
                return message


@contextlib.asynccontextmanager
async def playing(folder, source="imazu:1"):
    """A hub that plays, its clock, and one viewer."""
    catalogue = SourceList(LogIndex(folder))
    hub = SessionHub(catalogue, folder)
    await hub.show(prepare_session(Open(source, "straight", "paper"), catalogue, folder))
    clock = asyncio.create_task(hub.player.play())
    try:
        yield hub, await Viewer(hub).join()
    finally:
        clock.cancel()
        hub.close()


@pytest.fixture
def held(monkeypatch):
    """Opening and getting a pilot ready take until this is set, as a compiler might."""
    begun, go_on = threading.Event(), threading.Event()
    opened = session_hub.open_session

    def slowly(*args):
        begun.set()
        assert go_on.wait(4 * SOON_S)
        return opened(*args)

    def ready(*args, **kwargs):
        begun.set()
        assert go_on.wait(4 * SOON_S)

    monkeypatch.setattr(session_hub, "open_session", slowly)
    monkeypatch.setattr(SimulatedSession, "warm_up", ready)
    yield begun, go_on
    go_on.set()


ASKED = [
    {"type": "open", "source": "imazu:2", "pilot": "straight"},
    {"type": "pilot", "name": "paper-cpa"},
    {"type": "compare", "name": "paper-cpa"},
]


@pytest.mark.parametrize("asked", ASKED, ids=lambda asked: asked["type"])
def test_what_is_shown_goes_on_while_something_is_prepared(tmp_path, held, asked):
    begun, go_on = held

    async def look_on():
        async with playing(tmp_path) as (hub, first):
            await first.ask("limits", dcpa_m=50_000, tcpa_s=3600)
            while not (alarms := (await first.next("alarms"))["alarms"]):
                pass
            await first.ask("rate", rate=10)
            second = await Viewer(hub).join()
            await second.ask(**asked)
            await asyncio.to_thread(begun.wait, SOON_S)
            try:
                # Frames come to both; she who asked is answered, and may act on an alarm.
                for viewer in (first, second):
                    assert (await viewer.next("preparing"))["task"]
                    times = [(await viewer.next("frame"))["frame"]["time_s"] for _ in range(3)]
                    assert times == sorted(set(times))
                await second.ask("ping")
                await second.next("pong")
                await second.ask("acknowledge", id=alarms[0]["id"])
                while (await first.next("alarms"))["alarms"][0]["state"] != "acknowledged":
                    pass
                late = await Viewer(hub).join()
                assert (await late.next("session"))["source"] == "imazu:1"
                assert (await late.next("frame"))["frame"]["pilot"] == "straight"
                # What she asks after it is done after it.
                await second.ask("rate", rate=7)
            finally:
                go_on.set()
            while (await first.next("preparing"))["task"]:
                pass
            while hub._requests:
                await asyncio.sleep(0.01)
            return json.loads(hub.player.session_message(hub.player.require_presenter()).data)

    session = asyncio.run(look_on())
    expected = {
        "open": ("imazu:2", "straight", None),
        "pilot": ("imazu:1", "paper-cpa", None),
        "compare": ("imazu:1", "straight", "paper-cpa"),
    }
    told = (session["source"], session["pilot"], session["compare"])
    assert told == expected[asked["type"]]
    assert session["rate"] == 7, "a new session begins at 1"


def test_who_comes_before_the_first_session_is_answered_and_has_her_requests_done(tmp_path):
    go_on = threading.Event()

    async def come_early():
        catalogue = SourceList(LogIndex(tmp_path))
        hub = SessionHub(catalogue, tmp_path)
        begin = prepare_session(Open("imazu:1", "straight", "paper"), catalogue, tmp_path)

        def slowly():
            assert go_on.wait(4 * SOON_S)
            return begin()

        showing = asyncio.create_task(hub.show(slowly))
        try:
            viewer = await Viewer(hub).join()
            assert (await viewer.next("preparing"))["task"]
            await viewer.ask("limits", dcpa_m=100.0, tcpa_s=60.0)
            await viewer.ask("pause")
            await viewer.ask("ping")
            await viewer.next("pong")
            go_on.set()
            await viewer.next("frame")
            while hub._requests:
                await asyncio.sleep(0.01)
            await showing
            assert not hub.player.playing
            assert (hub.player.limits.dcpa_m, hub.n_failed) == (100.0, 0)
        finally:
            go_on.set()
            hub.close()

    asyncio.run(come_early())


def test_of_a_flood_of_requests_none_is_lost_and_few_wait(tmp_path, held):
    begun, go_on = held

    async def flood():
        async with playing(tmp_path) as (hub, viewer):
            await viewer.ask(**ASKED[0])
            for k in range(MAX_REQUESTS - 1):
                await viewer.ask("rate", rate=1 + k)
            text = json.dumps({"type": "rate", "rate": 60})
            one_more = asyncio.create_task(hub.handle_message(viewer.outbox, text))
            await asyncio.to_thread(begun.wait, SOON_S)
            await asyncio.sleep(0.1)
            assert not one_more.done(), "she is not read until there is room"
            assert len(hub._requests) == MAX_REQUESTS
            go_on.set()
            await asyncio.wait_for(one_more, SOON_S)
            while hub._requests:
                await asyncio.sleep(0.01)
            assert (hub.player.rate, hub.n_failed) == (60, 0)

    asyncio.run(flood())


class Counting(StraightPilot):
    """Counts in ``traced`` how often a program with it is made: only then is Python asked."""

    traced: list = eqx.field(static=True)

    def decide(self, observation, memory):
        self.traced.append("decide")
        return super().decide(observation, memory)

    def __hash__(self) -> int:
        return id(self.traced)


def test_a_pilot_that_is_ready_needs_no_compiler_when_it_takes_over(tmp_path):
    scenario = scenario_from("imazu:5", ship_named("paper"))
    session = SimulatedSession(scenario, StraightPilot(), "paper", False, tmp_path)
    session.next_frame()
    pilot = Counting([])
    session.warm_up(pilot)
    made = len(pilot.traced)
    assert made > 0
    session.set_pilot(pilot)
    session.next_frame()
    session.predicted_track()
    session.compare(pilot)
    session.next_frame()
    assert len(pilot.traced) == made
    session.close()


def test_live_traffic_needs_no_compiler_either(tmp_path):
    feed = Made()
    assert isinstance(feed, Feed)
    session = LiveSession(
        "tcp://made:1", feed, TrafficPicture("made"), StraightPilot(), "paper", tmp_path
    )
    pilot = Counting([])
    session.warm_up(pilot)
    made = len(pilot.traced)
    assert made > 0
    session.set_pilot(pilot)
    session._main.advisor.look(_lone_ship(ship_named("paper")), 0.0)
    session._main.advisor.look(_lone_ship(ship_named("paper")), 5.0)
    session.predicted_track()
    assert len(pilot.traced) == made
    session.close()


def test_minutes_cut_recorded_traffic_and_nothing_else(tmp_path):
    whole, part = (SourceList(LogIndex(tmp_path), minutes=m) for m in (None, 5.0))
    lasts = [c.scenario("new-york", "paper", None, None).duration_s for c in (whole, part)]
    assert lasts[0] > 1200
    assert 200 < lasts[1] <= 300
    assert part.scenario("imazu:1", "paper", None, None).targets
    for source in ("imazu:1", "tcp://127.0.0.1:1", "random:3"):
        with pytest.raises(InputError, match="minutes are of recorded traffic only"):
            SourceList(LogIndex(tmp_path), source, minutes=5.0)


def test_who_joins_waits_for_no_log_and_nobody_waits_for_her(tmp_path, monkeypatch):
    """Logs are read to list them while frames go on, and she who joins gets what is then."""
    reading, go_on = threading.Event(), threading.Event()
    really = LogIndex.entries

    def cards(shelf):
        reading.set()
        assert go_on.wait(SOON_S)
        return really(shelf)

    async def watch():
        async with playing(tmp_path) as (hub, viewer):
            await viewer.ask("rate", rate=60)
            with monkeypatch.context() as slow:
                slow.setattr(LogIndex, "entries", cards)
                joining = asyncio.create_task(Viewer(hub).join())
                await asyncio.to_thread(reading.wait, SOON_S)
                for _ in range(3):
                    await viewer.next("frame")
                assert not joining.done()
                await viewer.ask("limits", dcpa_m=1000.0, tcpa_s=60.0)
                assert (await viewer.next("hello"))["limits"]["dcpa_m"] == 1000.0
                go_on.set()
                later = await joining
            assert (await later.next("hello"))["limits"]["dcpa_m"] == 1000.0
            shown = (await later.next("history"))["frames"]
            assert len(shown) >= 2

    asyncio.run(watch())


def test_how_far_a_log_was_read_is_told_to_all(tmp_path, monkeypatch):
    told = []
    preparing = BackgroundJobs(told.extend)

    async def read():
        async with preparing.announce("a.jsonl"):
            await preparing.run(lambda: preparing.report_progress(0.25))
            await asyncio.sleep(0)
            assert json.loads(preparing.snapshot[0][1])["task"] == "a.jsonl (25%)"
        preparing.report_progress(0.5)  # too late
        await asyncio.sleep(0)

    asyncio.run(read())
    preparing.close()
    whats = [json.loads(message)["task"] for _, message in told]
    assert whats == ["a.jsonl", "a.jsonl (25%)", None]
