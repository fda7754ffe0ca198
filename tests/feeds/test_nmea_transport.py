"""NMEA over real sockets on loopback, and from files, made of the bundled recording."""

import asyncio
import contextlib
import gzip
import math
import socket

import pytest
from benchmarks.feeds_fuzz import nmea, recording
from pyais.encode import encode_dict
from pyais.messages import TagBlock
from tests.bridge.process import free_port
from tests.clock import now_s, run
from tests.feeds.live import pictured, shown, until

from glasshelm.ais.nmea_sentence import MAX_SENTENCE_BYTES, nmea_checksum
from glasshelm.ais.reports import RejectReason
from glasshelm.core.errors import InputError
from glasshelm.feeds.connection import Backoff
from glasshelm.feeds.feed_factory import create_feed
from glasshelm.feeds.nmea_transport import MAX_DATAGRAMS, MAX_QUEUED_BYTES, FileFeed

ECHO = "230035780"
POSITION = {"type": 1, "lat": 59.5, "lon": 24.5, "speed": 10.0, "course": 45.0, "heading": 44}


@pytest.fixture(scope="module")
def traffic():
    """Ten minutes of the Gulf of Finland, in lines."""
    return list(nmea(recording()))


def free_udp_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.asynccontextmanager
async def nmea_server(port, lines, cut_at=None):
    """Sends all lines to every client, in pieces that end anywhere, then waits (or hangs up)."""
    served = []

    async def serve(_, writer):
        served.append(writer)
        data = b"\r\n".join(lines) + b"\r\n"
        data = data[:cut_at]
        for start in range(0, len(data), 4999):
            writer.write(data[start : start + 4999])
            await writer.drain()
        if cut_at is not None:
            writer.close()

    server = await asyncio.start_server(serve, "127.0.0.1", port)
    try:
        yield server
    finally:
        server.close()
        for writer in served:
            writer.close()


@pytest.mark.slow
def test_traffic_over_tcp(traffic):
    async def watch():
        port = free_port()
        feed = create_feed(f"tcp://127.0.0.1:{port}")
        async with nmea_server(port, traffic), pictured(feed) as picture:
            await until(lambda: feed.counts.received == len(traffic))
            return feed, picture, shown(picture, picture.latest_time)

    feed, picture, targets = asyncio.run(watch())
    assert len(targets) == 94
    assert ECHO not in targets
    assert targets["276780000"].name == "SHIP 276780000"
    assert targets["276780000"].length_m == 150.0
    assert picture.latest_time.year == 2014
    assert feed.counts.pending == 0
    assert feed.counts.accepted > 0.99 * feed.counts.received
    assert not feed.connected


def test_a_tcp_server_may_come_late_hang_up_and_come_again(traffic, monkeypatch):
    monkeypatch.setattr(Backoff, "FIRST_S", 0.05)
    lines = traffic[:500]

    async def watch():
        port = free_port()
        feed = create_feed(f"tcp://127.0.0.1:{port}")
        async with pictured(feed) as picture:
            await until(lambda: feed.last_error)
            early = feed.last_error
            async with nmea_server(port, lines):
                await until(lambda: feed.counts.received == 500)
                assert feed.connected
                assert feed.last_error is None
            await until(lambda: not feed.connected)
            late = feed.last_error
            async with nmea_server(port, lines):
                await until(lambda: feed.counts.received == 1000)
                assert feed.connected
        return picture, early, late

    picture, early, late = asyncio.run(watch())
    assert "Connect" in early or "refused" in early
    assert "closed the connection" in late or "reset" in late
    # The second time tells nothing new: every position is a repeat or older.
    assert picture.counts.received == picture.counts.accepted + sum(
        picture.counts.rejected.values()
    )


def test_what_is_cut_off_by_a_broken_connection_is_counted(traffic):
    part = [line for line in traffic if b"AIVDM,2," in line][:2]

    async def watch():
        port = free_port()
        feed = create_feed(f"tcp://127.0.0.1:{port}")
        cut = len(part[0]) + 2 + len(part[1]) // 2
        async with nmea_server(port, part, cut_at=cut), pictured(feed):
            await until(lambda: feed.counts.received == 2 and not feed.connected)
        return feed.counts

    counts = asyncio.run(watch())
    assert counts.pending == 0
    assert counts.rejected[RejectReason.INCOMPLETE] == 1
    assert counts.accepted == 0


def test_a_line_without_end_is_refused_and_takes_no_memory(traffic):
    lines = [traffic[0], b"$" + b"A" * 300 * MAX_SENTENCE_BYTES, traffic[3]]

    async def watch():
        port = free_port()
        feed = create_feed(f"tcp://127.0.0.1:{port}")
        async with nmea_server(port, lines), pictured(feed):
            await until(lambda: feed.counts.accepted == 2)
        return feed.counts

    counts = asyncio.run(watch())
    assert counts.received == 3
    assert counts.rejected[RejectReason.TOO_LONG] == 1


def test_traffic_over_udp(traffic):
    async def watch():
        port = free_udp_port()
        feed = create_feed(f"udp://127.0.0.1:{port}")
        async with pictured(feed) as picture:
            await until(lambda: feed.connected)
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
                for start in range(0, 900, 9):
                    datagram = b"\r\n".join(traffic[start : start + 9])
                    sender.sendto(datagram, ("127.0.0.1", port))
                    if start % 90 == 81:  # before the system has too many to keep them all
                        await until(lambda sent=start + 9: feed.counts.received == sent)
            return feed, shown(picture, picture.latest_time)

    feed, targets = asyncio.run(watch())
    assert len(targets) > 10
    assert feed.counts.pending == 0


@pytest.mark.parametrize("padding", [0, 10_000])
def test_datagrams_that_come_faster_than_read_are_counted(padding):
    """Too many, or too long ones together."""
    datagram = b"!x\r\n!y\r\n" + b"\n" * padding
    most = min(MAX_DATAGRAMS, MAX_QUEUED_BYTES // len(datagram))

    async def flood():
        port = free_udp_port()
        feed = create_feed(f"udp://127.0.0.1:{port}")
        reports = feed.reports()
        first = asyncio.create_task(anext(reports))
        await until(lambda: feed.connected)
        loop = asyncio.get_running_loop()
        transport = next(t for t in loop._transports.values() if hasattr(t, "_protocol"))
        for _ in range(most + 10):
            transport._protocol.datagram_received(datagram, None)
        await until(lambda: feed.counts.received == 2 * (most + 10))
        first.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await first
        return feed.counts

    counts = asyncio.run(flood())
    assert counts.received == 2 * (most + 10)
    assert counts.rejected[RejectReason.OVERRUN] == 20
    assert counts.pending == 0


def test_a_port_in_use_is_told_in_one_line():
    async def listen():
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
            taken.bind(("127.0.0.1", 0))
            feed = create_feed(f"udp://127.0.0.1:{taken.getsockname()[1]}")
            await anext(feed.reports())

    with pytest.raises(InputError, match=r"cannot listen: .*in use"):
        asyncio.run(listen())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["traffic.nmea", "traffic.nmea.gz"])
def test_a_file(tmp_path, traffic, name):
    path = tmp_path / name
    data = b"\n".join(traffic)
    path.write_bytes(gzip.compress(data) if name.endswith("gz") else data)

    async def play():
        feed = create_feed(str(path))
        assert isinstance(feed, FileFeed)
        feed.pace = math.inf
        return feed, [report async for report in feed.reports()]

    feed, reports = asyncio.run(play())
    assert feed.counts.received == len(traffic)
    assert feed.counts.pending == 0
    assert (reports[-1].time - reports[0].time).total_seconds() == pytest.approx(600, abs=2)


def test_a_file_is_played_at_its_times_and_the_pace_may_change(tmp_path, traffic):
    path = tmp_path / "traffic.nmea"
    first = [line for line in traffic if b"c:14081292" in line]  # until 19:01:39
    path.write_bytes(b"\n".join(first))

    async def play():
        feed = FileFeed(path, pace=20.0)
        played = []
        async for report in feed.reports():
            played.append((report.time.timestamp(), now_s()))
            if report.time.timestamp() >= 1_408_129_220:
                feed.pace = math.inf
        return played

    played = run(play())
    (first_s, begun_s), (last_s, ended_s) = played[0], played[-1]
    slow = [(time_s, at_s) for time_s, at_s in played if time_s < 1_408_129_220]
    assert begun_s == 0.0
    for time_s, at_s in slow:
        assert at_s >= (time_s - first_s) / 20 - 1e-6
    assert slow[-1][1] == pytest.approx((max(time_s for time_s, _ in slow) - first_s) / 20)
    assert 0.9 < ended_s < 1.1  # 20 s at twenty times the pace, then 80 s without waiting
    assert last_s - first_s > 90


def played(path, lines, pace=1.0):
    """The times of a file's reports and when they came, each [s] from the first."""
    path.write_bytes(b"\n".join(lines))

    async def play():
        feed = FileFeed(path, pace=pace)
        return [(report.time.timestamp(), now_s()) async for report in feed.reports()]

    found = run(play())
    return [(time_s - found[0][0], at_s - found[0][1]) for time_s, at_s in found]


def moved(line, seconds):
    """A line with a tag block, so many seconds later."""
    _, tag, sentence = line.split(b"\\", 2)
    time_s = next(
        int(part[2:12]) for part in tag.partition(b"*")[0].split(b",") if part[:2] == b"c:"
    )
    return b"\\" + TagBlock.create(receiver_timestamp=str(time_s + seconds)) + b"\\" + sentence


def test_a_gap_in_a_file_is_passed_over(tmp_path, traffic):
    hour = [line for line in traffic if b"c:14081292" in line]
    times = played(tmp_path / "gap.nmea", hour + [moved(line, 3 * 3600) for line in hour])
    assert times[-1][0] > 3 * 3600
    assert times[-1][1] < 250  # twice the hundred seconds of traffic


def test_a_file_waits_for_no_single_wrong_clock(tmp_path, traffic):
    lines = [line for line in traffic if b"c:14081292" in line]
    ais = next(k for k, line in enumerate(lines) if b"AIVDM,1," in line and k > 100)
    for off in (500, 43200):
        wrong = [moved(lines[ais], off)] * 3
        times = played(tmp_path / "wrong.nmea", lines[:ais] + wrong + lines[ais:])
        assert times[-1][1] == pytest.approx(times[-1][0], abs=2.0)
        assert max(at_s - time_s for time_s, at_s in times) < 2.0


@pytest.mark.parametrize(
    ("station", "ships", "named"),
    [(b"s:HARBOR,", 60, "station HARBOR (12 h ahead)"), (b"", 3, "MMSI 257300000 (12 h ahead)")],
)
def test_a_station_with_its_zone_in_the_time_moves_nothing(
    tmp_path, traffic, station, ships, named
):
    """Of ships that only it hears: one witness, however many they are; or a few without a name."""
    lines = [line for line in traffic if b"c:14081292" in line and b"AIVDM,1," in line]
    tag, wrong = station + b"c:%d" % (1_408_129_250 + 43_200), []
    for k in range(ships):
        message = POSITION | {"mmsi": 257_300_000 + k}
        for part in encode_dict(message, talker_id="AI", sentence_type="VDM"):
            wrong.append(b"\\%b*%02X\\%b" % (tag, nmea_checksum(tag), part.encode()))
    path = tmp_path / "station.nmea"
    path.write_bytes(b"\n".join(lines[:200] + wrong + lines[200:]))

    async def play():
        feed = FileFeed(path, pace=math.inf)
        reports = [report async for report in feed.reports()]
        return feed, reports

    feed, reports = asyncio.run(play())
    assert len(reports) == len(lines)
    assert feed.counts.rejected[RejectReason.TIME_JUMP] == len(wrong)
    assert named in feed.counts.summary()


def heard_of(path):
    """The feed of a file, and how many reports it gave."""

    async def play():
        feed = create_feed(str(path))
        feed.pace = math.inf
        return feed, len([report async for report in feed.reports()])

    return asyncio.run(play())


def test_a_damaged_file_is_played_as_far_as_it_goes(tmp_path, traffic):
    path = tmp_path / "traffic.nmea.gz"
    path.write_bytes(gzip.compress(b"\n".join(traffic))[:2000])
    feed, reports = heard_of(path)
    assert reports > 10
    assert "cut off or damaged" in feed.last_error


def test_a_file_that_cannot_be_played_is_told_in_one_line(tmp_path):
    path = tmp_path / "traffic.nmea"
    path.write_bytes(b"%PDF-1.7 and so on")
    with pytest.raises(InputError, match=r"^traffic.nmea: a PDF document"):
        heard_of(path)


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le"])
def test_a_file_of_any_encoding_is_played_whole(tmp_path, traffic, encoding):
    plain, other = tmp_path / "plain.nmea", tmp_path / "other.nmea"
    plain.write_bytes(b"\n".join(traffic[:2000]))
    other.write_bytes(b"\r\n".join(traffic[:2000]).decode("latin-1").encode(encoding))
    assert heard_of(other)[1] == heard_of(plain)[1]


def test_waits_grow_and_success_sets_them_back(monkeypatch):
    waits = []

    async def sleep(delay):
        waits.append(delay)

    monkeypatch.setattr(asyncio, "sleep", sleep)

    async def fail():
        backoff = Backoff()
        for _ in range(7):
            await backoff.wait()
        backoff.succeeded()
        await backoff.wait()

    asyncio.run(fail())
    assert waits == [0.5, 1.0, 2.0, 4.0, 8.0, 15.0, 15.0, 0.5]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("no-such-file.nmea", "no feed 'no-such-file.nmea' .* choose tcp://"),
        ("http://localhost", "no feed 'http://localhost': choose tcp://"),
        ("tcp://localhost", "must be tcp://HOST:PORT"),
        ("tcp://localhost:0", "must be tcp://HOST:PORT"),
        ("tcp://localhost:99999", "port of 1 to 65535"),
        ("udp://:10110", "must be udp://HOST:PORT"),
        ("tcp://user@localhost:10110", "must be tcp://HOST:PORT"),
        ("tcp://localhost:10110/x", "must be tcp://HOST:PORT"),
        ("tcp://[::1:10110", "must be tcp://HOST:PORT"),
        ("signalk://", "must be signalk://HOST:PORT"),
        ("", "no feed ''"),
        ("a\0b", "no feed"),
    ],
)
def test_no_such_feed(text, message):
    with pytest.raises(InputError, match=message) as caught:
        create_feed(text)
    assert "\n" not in str(caught.value)


def test_own_must_be_an_mmsi():
    with pytest.raises(InputError, match="must be an MMSI"):
        create_feed("tcp://localhost:10110", own="me")
    assert create_feed("tcp://[::1]:10110", own="211000001").title.startswith("NMEA 0183 from ::1")
