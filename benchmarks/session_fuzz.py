"""A whole live session under mangled traffic: bytes in at a socket, frames and alarms out.

    python -m benchmarks.session_fuzz [--count 1000000] [--seed 0]

A server of this machine sends NMEA 0183 over TCP, then one sends Signal K, two lines or messages of
three mangled (as in feeds_fuzz.py), in pieces of any size. The session of the bridge hears them
and is looked at all the while: every message to a viewer must be JSON without NaN, frames must go
on in time. At the end sound traffic is sent: own ship and the ships around her must be shown
where they are again. Exits with 1 if anything is raised, is not counted, or does not heal.
"""

import argparse
import asyncio
import contextlib
import dataclasses
import itertools
import json
import math
import os
import platform
import random
import sys
import tempfile
import time
import traceback
from collections.abc import AsyncIterator, Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

os.environ.setdefault("JAX_PLATFORMS", "cpu")

from benchmarks.feeds_fuzz import lines, messages, nmea, recording, signalk
from websockets.asyncio.server import serve
from websockets.exceptions import ConnectionClosed

from glasshelm.ais.table import OWN_SENSORS, ReportTable
from glasshelm.bridge.server.presenter import Presenter
from glasshelm.bridge.server.protocol import DEFAULT_ALARM_LIMITS
from glasshelm.bridge.sessions.live_session import LiveSession
from glasshelm.feeds.feed_factory import create_feed
from glasshelm.live.traffic_picture import TrafficPicture
from glasshelm.pilots.straight import StraightPilot
from glasshelm.ship.nomoto import NAUTICAL_MILE_M

#: Seconds between two looks at the session.
LOOK_S = 0.02
#: After so many bytes, or messages, the server rests so long [s]: there are looks meanwhile.
BYTES, MESSAGES, REST_S = 8192, 50, 0.01
#: One pass of the recording begins so long [s] after the one before it.
PASS_S = 1800.0
#: The sound traffic at the end is heard by then [s].
PATIENCE_S = 60.0
#: So many lines are sound at the beginning; what is mangled comes when they are shown.
SOUND = 500


@dataclasses.dataclass
class Outcome:
    """What a session came to."""

    looks: int = 0
    frames: int = 0
    faults: list[str] = dataclasses.field(default_factory=list)
    last: dict[str, Any] | None = None
    healed: bool = False
    heard: int = 0
    uncounted: int = 0

    @property
    def sound(self) -> bool:
        return self.healed and not self.faults and self.uncounted == 0 and self.frames > 0


def shifted(reports: ReportTable, seconds: float) -> ReportTable:
    """The same reports so much later."""
    return dataclasses.replace(reports, time_s=reports.time_s + seconds)


def given(count: int, seed: int, of_nmea: bool) -> tuple[Iterator[bytes], list[bytes], ReportTable]:
    """``count`` lines or messages of which the first ``SOUND`` are sound and two of three of the
    others mangled; the sound ones for the end, and what those report."""
    reports = recording()
    passes = max(1, math.ceil(count / len(reports)))
    good = shifted(reports, passes * PASS_S)

    def all_of() -> Iterator[bytes]:
        chance, left = random.Random(seed), count
        for k in range(passes):
            later = shifted(reports, k * PASS_S)
            sound: Any = list(nmea(later) if of_nmea else signalk(later))
            n = min(left, len(sound))
            left -= n
            if k == 0:
                first = min(SOUND, n)
                yield from (x if isinstance(x, bytes) else x.encode() for x in sound[:first])
                n -= first
            yield from lines(n, chance, sound) if of_nmea else messages(n, chance, sound)

    end = list(nmea(good)) if of_nmea else [text.encode() for text in signalk(good)]
    return all_of(), end, good


@contextlib.asynccontextmanager
async def nmea_server(
    pieces: Iterable[bytes], end: list[bytes], shown: asyncio.Event
) -> AsyncIterator[str]:
    """Sends lines over TCP, in pieces of any size; then those of the end."""
    chance = random.Random(1)

    async def send(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(ConnectionError, asyncio.CancelledError):
            waiting = b""
            for number, line in enumerate(itertools.chain(pieces, end)):
                if number == SOUND:
                    writer.write(waiting)
                    waiting = b""
                    await shown.wait()
                waiting += line + chance.choice((b"\r\n", b"\n", b"\r"))
                if len(waiting) > chance.randrange(1, 2 * BYTES):
                    writer.write(waiting)
                    await writer.drain()
                    await asyncio.sleep(REST_S)
                    waiting = b""
            writer.write(waiting + b"\n")
            await writer.drain()
            await reader.read()  # until the session closes

    server = await asyncio.start_server(send, "127.0.0.1", 0)
    async with server:
        yield f"tcp://127.0.0.1:{server.sockets[0].getsockname()[1]}"


@contextlib.asynccontextmanager
async def signalk_server(
    pieces: Iterable[bytes], end: list[bytes], shown: asyncio.Event
) -> AsyncIterator[str]:
    """Sends messages over a WebSocket; then those of the end."""
    left = itertools.chain(pieces, end)

    async def send(socket: Any) -> None:
        with contextlib.suppress(ConnectionClosed):
            await socket.send(end[0].decode())  # the hello
            for number, message in enumerate(left):
                if number == SOUND:
                    await shown.wait()
                if number % MESSAGES == 0:
                    await asyncio.sleep(REST_S)
                try:
                    await socket.send(message.decode())
                except UnicodeDecodeError:
                    await socket.send(message)
            await socket.wait_closed()

    async with serve(send, "127.0.0.1", 0) as server:
        yield f"signalk://127.0.0.1:{next(iter(server.sockets)).getsockname()[1]}"


async def watched(address: str, good: ReportTable, logs: Path, shown: asyncio.Event) -> Outcome:
    """A session that hears an address, looked at until it has healed or patience is at an end."""
    outcome = Outcome()
    feed = create_feed(address)
    picture = TrafficPicture("fuzz")
    pilot = StraightPilot()
    live = LiveSession("fuzz", feed, picture, pilot, "paper", logs)
    live.warm_up(pilot)
    presenter = Presenter(live, DEFAULT_ALARM_LIMITS)
    listening = asyncio.create_task(presenter.session.listen())
    quiet_since, heard = time.monotonic(), -1
    try:
        while not outcome.healed and time.monotonic() - quiet_since < PATIENCE_S:
            await asyncio.sleep(LOOK_S)
            if feed.counts.received != heard:
                quiet_since, heard = time.monotonic(), feed.counts.received
            await asyncio.to_thread(_look, presenter, outcome)
            if outcome.frames > 1:
                shown.set()
            outcome.healed = _is_healed(outcome.last, good)
            if listening.done() or len(outcome.faults) > 10:
                break
    finally:
        if listening.done() and listening.exception() is not None:
            outcome.faults.append(f"the feed ended: {listening.exception()!r}")
        listening.cancel()
        await asyncio.gather(listening, return_exceptions=True)
        presenter.close()
    outcome.heard = feed.counts.received
    outcome.uncounted = abs(picture.counts.pending) + abs(feed.counts.pending)
    return outcome


def _look(presenter: Presenter, outcome: Outcome) -> None:
    """One look as the bridge has it: what is told must be JSON, and in order."""
    outcome.looks += 1
    try:
        told = presenter.advance() or []
        told.append(presenter.session_message(True, 1.0))
        for kind, message in told:
            content = json.loads(message, parse_constant=_no_number)
            if kind != "frame":
                continue
            frame = content["frame"]
            outcome.frames += 1
            last = outcome.last
            if last and frame["time_s"] <= last["time_s"] and frame["time_s"] > 0:
                outcome.faults.append(f"frames go back: {last['time_s']} to {frame['time_s']}")
            outcome.last = frame
    except Exception:
        outcome.faults.append(traceback.format_exc())


def _no_number(text: str) -> None:
    raise ValueError(f"{text} in a message")


def _is_healed(frame: dict[str, Any] | None, good: ReportTable) -> bool:
    """Whether own ship and most of the ships are where the sound traffic has them last."""
    if frame is None or _away_m(frame["own"], good, OWN_SENSORS) > 500.0:
        return False
    there = {t["id"]: t for t in frame["targets"] if not t.get("lost")}
    numbers = {int(n) for n in good.mmsi} - {OWN_SENSORS}
    right = sum(str(n) in there and _away_m(there[str(n)], good, n) < 1000.0 for n in numbers)
    return right >= 0.8 * len(numbers)


def _away_m(place: dict[str, Any], reports: ReportTable, number: int) -> float:
    """How far a place of a frame is from where a ship was reported last."""
    hers = reports.take(reports.mmsi == number)
    last = int(hers.time_s.argmax())
    north = place["latitude_deg"] - float(hers.latitude_deg[last])
    east = place["longitude_deg"] - float(hers.longitude_deg[last])
    return (
        60
        * NAUTICAL_MILE_M
        * math.hypot(north, east * math.cos(math.radians(place["latitude_deg"])))
    )


def trial(of_nmea: bool, count: int, seed: int) -> Outcome:
    """A session under ``count`` mangled lines of NMEA 0183, or messages of Signal K."""
    pieces, end, good = given(count, seed, of_nmea)
    server: Callable[..., Any] = nmea_server if of_nmea else signalk_server

    async def run() -> Outcome:
        shown = asyncio.Event()
        with tempfile.TemporaryDirectory() as logs:
            async with server(pieces, end, shown) as address:
                return await watched(address, good, Path(logs), shown)

    return asyncio.run(run())


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=1_000_000, help="of both together")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    machine = f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"
    sound = True
    for of_nmea, what in ((True, "NMEA 0183 lines"), (False, "Signal K messages")):
        begun = time.perf_counter()
        outcome = trial(of_nmea, options.count // 2, options.seed)
        spent = time.perf_counter() - begun
        print(
            f"{what}: {outcome.heard:,} heard in {spent:.0f} s ({machine}); {outcome.looks:,} "
            f"looks, {outcome.frames:,} frames, {outcome.uncounted} not counted, "
            f"{'healed' if outcome.healed else 'NOT healed'}, {len(outcome.faults)} faults"
        )
        for fault in outcome.faults[:3]:
            print(fault)
        sound &= outcome.sound
    return int(not sound)


if __name__ == "__main__":
    sys.exit(main())
