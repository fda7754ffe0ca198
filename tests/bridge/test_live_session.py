"""Live sessions on a feed made by hand: own ship and one target, at the stream's own time."""

import asyncio
import itertools
import json
from datetime import UTC, datetime, timedelta

import pytest

from glasshelm.ais.limits import LOST_AFTER_S, LOST_SHOWN_S
from glasshelm.ais.reports import Counts, Feed, RejectReason, Report
from glasshelm.bridge.server.presenter import Presenter
from glasshelm.bridge.server.protocol import DEFAULT_ALARM_LIMITS
from glasshelm.bridge.server.session_hub import SessionHub
from glasshelm.bridge.sessions.live_session import LiveSession
from glasshelm.bridge.sessions.log_index import LogIndex
from glasshelm.bridge.sessions.source_list import SourceList
from glasshelm.core.errors import InputError
from glasshelm.feeds.feed_factory import signalk_server
from glasshelm.live import vessel_store
from glasshelm.live.report_queue import MAX_OTHERS, MAX_OWN
from glasshelm.live.signalk_writer import SignalKWriter
from glasshelm.live.traffic_picture import TrafficPicture
from glasshelm.pilots.straight import StraightPilot

START = datetime(2014, 8, 15, 17, 0, tzinfo=UTC)
NORTH_M_DEG = 111_132.0
OWN_M_S, TARGET_M_S = 5.0, 7.0


def report(id: str, time_s: float, north_m: float, speed: float, own: bool = False) -> Report:
    latitude = (north_m + speed * time_s) / NORTH_M_DEG
    return Report(
        id=id,
        time=START + timedelta(seconds=time_s),
        latitude_deg=latitude,
        longitude_deg=25.0,
        course_rad=0.0,
        speed_m_s=speed,
        is_own=own,
    )


class Made(Feed):
    """A feed of reports given beforehand, that then stays silent."""

    title = "made"
    connected = True
    last_error = None

    def __init__(self):
        self.counts = Counts()
        self.given: list[Report] = []

    async def reports(self):
        for one in self.given:
            yield one


class Clock(TrafficPicture):
    """A picture whose stream's time the test sets."""

    time_s = 0.0

    def now(self):
        return None if self.latest_time is None else START + timedelta(seconds=self.time_s)


@pytest.fixture
def live(tmp_path):
    feed, picture = Made(), Clock()
    assert isinstance(feed, Feed)
    session = LiveSession("tcp://made:1", feed, picture, StraightPilot(), "paper", tmp_path)

    def at(time_s: float, own: bool = True, target: bool = True):
        feed.given = []
        if own:
            feed.given.append(report("230000001", time_s, 0.0, OWN_M_S, own=True))
        if target:
            feed.given.append(report("230000002", time_s, 3000.0, TARGET_M_S))
        asyncio.run(session.listen())
        picture.time_s = time_s
        return session.next_frame()

    yield session, at
    session.close()


def test_frames_follow_the_traffic_and_say_how_old_it_is(live):
    session, at = live
    assert session.next_frame() is None
    assert session.info.notes == ("nothing heard yet",)
    assert at(0.0, own=False) is None
    assert "no position of own ship" in session.info.notes[0]
    frames = [at(1.0 + 5.0 * k) for k in range(4)]
    assert [f.time_s for f in frames] == [0.0, 5.0, 10.0, 15.0]
    for k, one in enumerate(frames):
        (target,) = one.targets
        assert target.range_m == pytest.approx(3000.0 + 2.0 * (1 + 5 * k), rel=0.01)
        assert (target.age_s, target.lost) == (pytest.approx(0.0, abs=0.01), False)
        assert one.decision.applied is False
        assert one.time_utc == f"2014-08-15T17:00:{1 + 5 * k:02d}Z"
    assert [f.source for f in frames] == ["tcp://made:1"] * 4
    silent = [at(16.0 + 5.0 * k, target=False).targets[0] for k in range(1, 4)]
    assert [t.age_s for t in silent] == pytest.approx([5.0, 10.0, 15.0], abs=0.01)
    assert session.status().last_report_age_s == pytest.approx(0.0, abs=0.01)


def test_own_ship_s_rudder_is_in_the_frame_while_a_sensor_tells_it(live):
    session, at = live
    assert at(0.0).own.rudder_rad is None
    sensor = Report(
        id="230000001", time=START + timedelta(seconds=5), rudder_rad=-0.07, is_own=True
    )
    session._picture.update(sensor)
    assert at(5.0).own.rudder_rad == pytest.approx(-0.07)
    assert at(10.0).decision.rudder_rad == 0.0, "the advice is another thing"
    assert at(20.0).own.rudder_rad is None, "what was said 15 s ago is not shown as of now"


def test_a_ship_not_heard_is_lost_then_gone(live):
    _, at = live
    at(0.0)
    found = {t: at(float(t), target=False).targets for t in range(60, 860, 100)}
    gone = 260.0 + LOST_SHOWN_S  # at 260 s she was there for the last time
    assert {t: [s.lost for s in ships] for t, ships in found.items()} == {
        t: [] if t > gone else [t >= LOST_AFTER_S] for t in found
    }
    stayed = [s.north_m for t, ships in found.items() if t >= LOST_AFTER_S for s in ships]
    assert len(set(stayed)) == 1  # shown where she was last, not where she might be


def test_everything_is_logged_and_a_clock_that_jumps_back_begins_a_new_log(live, tmp_path):
    session, at = live
    for k in range(3):
        at(7200.0 + 5.0 * k)
    first = session.log.path
    assert len(first.read_text().splitlines()) == 3
    for k in range(5):  # it takes more than one report to believe another time
        at(5.0 * k)
    assert session.log.path != first
    times = list(session.log.times)
    assert times == [5.0 * k for k in range(len(times))]
    assert session.index == len(times) - 1 >= 2


class Writer(SignalKWriter):
    """Notes what it is asked to write: how many targets, None for nothing at all."""

    def __init__(self):
        self.asked: list[int | None] = []

    def publish(self, frame, alarms):
        self.asked.append(len(frame.targets))

    def withdraw(self):
        self.asked.append(None)


def test_only_what_is_of_now_is_written_back(live, tmp_path):
    session, at = live
    writer = Writer()
    hub = SessionHub(SourceList(LogIndex(tmp_path)), tmp_path, writer)
    presenter = Presenter(session, DEFAULT_ALARM_LIMITS)
    at(0.0)
    presenter.advance()
    hub.player.write_back(presenter)
    session._picture.time_s = 31.0  # nothing was heard for so long
    hub.player.write_back(presenter)
    at(35.0)
    presenter.advance()
    hub.player.write_back(presenter)
    session._feed.connected = False
    hub.player.write_back(presenter)
    hub.player.write_back(None)
    hub.close()
    assert writer.asked == [1, None, 1, None, None]


def test_own_ship_s_own_position_is_what_makes_it_live(live, tmp_path):
    """Her receiver fails; the others go on, and she is dead-reckoned."""
    session, at = live
    writer = Writer()
    hub = SessionHub(SourceList(LogIndex(tmp_path)), tmp_path, writer)
    presenter = Presenter(session, DEFAULT_ALARM_LIMITS)
    assert session.status().own_position_age_s is None
    at(0.0)
    at(30.0, own=False)
    presenter.advance()
    hub.player.write_back(presenter)
    at(41.0, own=False)
    presenter.advance()
    hub.player.write_back(presenter)
    hub.close()
    said = json.loads(presenter.session_message(True, 1.0).data)
    assert (said["last_report_age_s"], said["own_position_age_s"]) == (0.0, 41.0)
    assert "own ship's position is 41 s old: dead-reckoned since" in said["notes"]
    assert writer.asked == [1, None]


def test_a_feed_that_ended_stays_in_the_notes(live):
    session, _ = live

    async def taken():
        raise InputError("port 10110: cannot listen: address already in use")
        yield

    session._feed.reports = taken
    with pytest.raises(InputError):
        asyncio.run(session.listen())
    for _ in range(2):
        session.next_frame()
        assert session.info.notes[0] == "port 10110: cannot listen: address already in use"


def test_what_was_of_no_use_is_told_in_one_sentence(live):
    session, at = live
    counts = session._feed.counts
    counts.received, counts.rejected[RejectReason.CHECKSUM] = 12, 12
    session.next_frame()
    told = "heard 12 sentences: 0 used, 12 with a wrong checksum"
    assert session.info.notes == ("no position heard yet", told)
    counts.received, counts.accepted, counts.rejected[RejectReason.CHECKSUM] = 12, 9, 0
    counts.rejected[RejectReason.UNUSED_KIND] = 3
    at(0.0)
    assert not any(note.startswith("heard") for note in session.info.notes), "a sound feed"
    session._picture.update(report("230000002", -7200.0, 0.0, TARGET_M_S))
    assert session.status().feed_counts == {
        "sentences": {"heard": 12, "used": 9, "refused": {RejectReason.UNUSED_KIND: 3}},
        "reports": {"heard": 3, "used": 2, "refused": {RejectReason.LATE: 1}},
    }


def test_what_keeps_it_from_writing_back_is_in_the_notes_until_it_works(live, tmp_path):
    session, at = live
    writer = SignalKWriter(signalk_server("signalk://127.0.0.1:9", "secret"))
    hub = SessionHub(SourceList(LogIndex(tmp_path)), tmp_path, writer)
    presenter = Presenter(session, DEFAULT_ALARM_LIMITS)
    at(0.0)

    def notes():
        return json.loads(hub.player.session_message(presenter).data)["notes"]

    before = notes()
    writer.last_error = f"{writer.title}: refused with HTTP status 401"
    assert notes() == [writer.last_error, *before]
    writer.last_error = None
    assert notes() == before
    hub.close()


class Flood(Made):
    """A hundred thousand ships at full speed, own ship and twenty near her among them."""

    near = frozenset(str(230_000_100 + k) for k in range(20))

    async def reports(self):
        for i in itertools.count():
            time_s, k = i / 5000, i % 100_000
            self.counts.received += 1
            if i % 500 == 0:
                yield report("230000001", time_s, 0.0, OWN_M_S, own=True)
            elif i % 500 <= 20:
                yield report(str(230_000_099 + i % 500), time_s, 500.0 * (i % 500), OWN_M_S)
            else:
                yield report(str(240_000_000 + k), time_s, 50_000.0 + 50.0 * k, 0.1)
            if i % 200 == 199:
                await asyncio.sleep(0)


def test_a_flood_of_ships_starves_neither_the_picture_nor_the_event_loop(tmp_path, monkeypatch):
    monkeypatch.setattr(vessel_store, "MAX_SHIPS", 300)
    picture = TrafficPicture()
    live = LiveSession("tcp://flood:1", Flood(), picture, StraightPilot(), "paper", tmp_path)

    async def watch():
        listening = asyncio.create_task(live.listen())
        frames, turns = [], []
        await asyncio.sleep(0.3)
        for _ in range(8):
            looking = asyncio.create_task(asyncio.to_thread(live.next_frame))
            while not looking.done():
                begun = asyncio.get_running_loop().time()
                await asyncio.sleep(0.01)
                turns.append(asyncio.get_running_loop().time() - begun)
            frames.append(await looking)
            assert len(live._reports) <= MAX_OWN + MAX_OTHERS
        listening.cancel()
        await asyncio.wait([listening])
        return frames, turns

    try:
        frames, turns = asyncio.run(watch())
    finally:
        live.close()
    assert all(frame is not None for frame in frames)
    assert Flood.near <= {target.id for target in frames[-1].targets}
    assert len(picture) <= 330
    assert sorted(turns)[len(turns) // 2] < 1.0
    assert picture.own_age_s() < 10.0


def test_another_pilot_beside_and_what_cannot_be_done(live):
    session, at = live
    at(0.0)
    with pytest.raises(InputError, match="as it is now"):
        session.seek(0.0)
    session.compare(StraightPilot())
    assert session.compared_line() is None
    at(5.0)
    assert b'"time_s":5.0' in session.compared_line()
    session.compare(None)
    assert session.compared_line() is None
    session.set_pilot(StraightPilot())
    assert at(10.0).time_s == 10.0
    ahead = session.predicted_track()
    assert ahead.rows[-1, 1] - ahead.rows[0, 1] == pytest.approx(1200 * OWN_M_S, rel=0.01)
