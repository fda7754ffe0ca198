"""Against a real Signal K server: targets appear, it may restart, what is written is read back."""

import asyncio
import contextlib
import dataclasses
import json
import signal
import time

import pytest
from tests.bridge.process import PATIENCE_S, start, viewing
from tests.feeds.frames import Alarm, frame_of, target_of
from tests.feeds.live import SHIP, pictured, running, shown, until
from tests.feeds.signalk_server import SignalKServer, why_not
from tests.missing import missing

from glasshelm.feeds.feed_factory import create_feed, signalk_server
from glasshelm.live.signalk_writer import SignalKWriter

pytestmark = pytest.mark.slow

#: AIS number under which the sample's own ship hears herself.
ECHO = "230035780"


@pytest.fixture(scope="module", autouse=True)
def server(tmp_path_factory):
    if why := why_not():
        missing(why)
    server = SignalKServer(tmp_path_factory.mktemp("signalk"))
    server.start()
    yield server
    server.stop()


def test_targets_appear_and_come_back_after_a_restart(server):
    async def watch():
        feed = create_feed(server.address)
        async with pictured(feed) as picture:
            await until(lambda: len(shown(picture)) >= 20 and ECHO not in shown(picture))
            first = picture.scenario(picture.now(), SHIP)
            await until(lambda: any(one.length_m for one in shown(picture).values()))
            await asyncio.to_thread(server.stop)
            await until(lambda: not feed.connected and feed.last_error)
            trouble = feed.last_error
            heard = feed.counts.received
            await asyncio.to_thread(server.start)
            await until(lambda: feed.connected and feed.counts.received > heard + 50)
            await until(lambda: len(shown(picture)) >= 20)
        return feed, picture, first, trouble

    feed, picture, first, trouble = asyncio.run(watch())
    assert first.start.year == 2014
    assert first.origin == pytest.approx((59.72, 24.74), abs=0.02)
    assert 2.0 < float(first.encounter.own.speed_m_s) < 5.0
    assert feed.title in trouble
    assert "\n" not in trouble
    assert feed.counts.pending == 0
    assert picture.counts.pending == 0
    assert not any(one.startswith("00") for one in picture._others.ships)


def test_what_is_written_is_read_back_and_withdrawn(server):
    other, notice = (
        "urn:mrn:imo:mmsi:276780000",
        "notifications.navigation.closestApproach.276780000",
    )

    async def read(path, number="self"):
        found = await asyncio.to_thread(server.vessel, path, number)
        return (found or {}).get("value")

    async def read_until(wanted, path, number="self"):
        end = time.monotonic() + PATIENCE_S
        while not wanted(value := await read(path, number)):
            assert time.monotonic() < end, f"{path} is {value}"
            await asyncio.sleep(0.1)
        return value

    async def write():
        writer = SignalKWriter(signalk_server(server.address, server.token()))
        async with running(writer.run()):
            frame = frame_of(rudder_rad=-0.05, targets=[target_of("276780000", 350.0, 240.0)])
            alarm = Alarm("276780000", "MSC X", "unacknowledged", "CPA 0.19 NM in 4:00")
            writer.publish(frame, [alarm])
            await read_until(lambda v: v == -0.05, "steering.rudderAngleTarget")
            cpa = {"distance": 350.0, "timeTo": 240.0}
            await read_until(lambda v: v == cpa, "navigation.closestApproach", other)
            told = await read_until(lambda v: v, notice)
            writer.publish(frame, [dataclasses.replace(alarm, state="acknowledged")])
            silent = await read_until(lambda v: v["method"] == ["visual"], notice)
            writer.publish(frame, [])
            await read_until(lambda v: v["state"] == "normal", notice)
            assert writer.n_written == 3
        await read_until(lambda v: v is None, "steering.rudderAngleTarget")
        await read_until(lambda v: v is None, "navigation.closestApproach", other)
        return told, silent

    told, silent = asyncio.run(write())
    assert told["state"] == silent["state"] == "alarm"
    assert told["method"] == ["visual", "sound"]
    assert told["message"] == "MSC X: CPA 0.19 NM in 4:00"


def test_a_bridge_that_follows_it_writes_back_what_it_shows(server, tmp_path):
    """The command itself: traffic in, frames shown, and what they say read back over REST."""
    asked = ("--write-back", "--signalk-token", server.token(), "--pilot", "paper-waypoint")
    process, url = start(server.address, *asked, "--log-dir", str(tmp_path))
    frames, alarms = [], []
    try:
        with viewing(url) as viewer:
            viewer.send(json.dumps({"type": "limits", "dcpa_m": 50_000, "tcpa_s": 3600}))

            def read_until(wanted, path, number="self"):
                end = time.monotonic() + PATIENCE_S
                while time.monotonic() < end:
                    with contextlib.suppress(TimeoutError):
                        while message := json.loads(viewer.recv(timeout=0.2)):
                            if message["type"] == "frame":
                                frames.append(message["frame"])
                            if message["type"] == "alarms":
                                alarms[:] = message["alarms"]
                    value = (server.vessel(path, number) or {}).get("value")
                    if wanted(value):
                        return value
                raise AssertionError(f"{path} is {value}")

            def shown(value):
                return value in [f["decision"]["rudder_rad"] for f in frames]

            read_until(shown, "steering.rudderAngleTarget")
            read_until(lambda _: any(a["state"] == "unacknowledged" for a in alarms), "name")
            alarm = alarms[-1]  # whose CPA is the last to be past
            notice = f"notifications.navigation.closestApproach.{alarm['target']}"
            told = read_until(lambda v: v and v["state"] == "alarm", notice)
            assert told["method"] == ["visual", "sound"]
            assert alarm["name"] in told["message"]

            def approach(value):
                ships = [t for f in frames for t in f["targets"] if t["id"] == alarm["target"]]
                said = [{"distance": t["dcpa_m"], "timeTo": t["tcpa_s"]} for t in ships]
                return value in said

            hers = f"urn:mrn:imo:mmsi:{int(alarm['target']):09d}"
            read_until(approach, "navigation.closestApproach", hers)
            viewer.send(json.dumps({"type": "acknowledge", "id": alarm["id"]}))
            read_until(lambda v: v["method"] == ["visual"], notice)
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=PATIENCE_S) in (0, 130)
        assert server.vessel("steering.rudderAngleTarget")["value"] is None
        assert server.vessel("navigation.closestApproach", hers)["value"] is None
        assert server.vessel(notice)["value"]["state"] == "normal"
    finally:
        process.kill()
        process.wait(timeout=PATIENCE_S)


def test_a_wrong_token_is_refused_in_one_line(server):
    async def write():
        writer = SignalKWriter(signalk_server(server.address, "no.such.token"))
        async with running(writer.run()):
            writer.publish(frame_of(rudder_rad=0.02), [])
            await until(lambda: writer.last_error)
        return writer

    writer = asyncio.run(write())
    assert "token" in writer.last_error
    assert "\n" not in writer.last_error
    assert writer.n_written == 0
