"""NMEA 0183 from where it comes: a TCP server, UDP datagrams, a file."""

import asyncio
import math
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

from glasshelm.ais.files import TextFile
from glasshelm.ais.line_splitter import LineSplitter
from glasshelm.ais.nmea import NmeaDecoder
from glasshelm.ais.reports import Counts, FeedBase, RejectReason, Report
from glasshelm.ais.traffic_time import TOLERANCE_S, TrafficTime
from glasshelm.core.errors import InputError, hide_paths
from glasshelm.feeds.backoff import Backoff
from glasshelm.feeds.connection_errors import describe_error

#: A TCP server that is silent for so long [s] is taken for gone, and connected to again.
SILENT_S = 120.0
#: An attempt to connect is given up after so long [s].
CONNECT_S = 10.0
#: Datagrams that may wait to be read.
MAX_DATAGRAMS = 4096
#: ... and how many bytes they may have together.
MAX_QUEUED_BYTES = 1 << 24
#: So much is read in one turn of the event loop [bytes]: some 150 lines, and others' turn.
_PIECE = 8192
_SILENT = "nothing comes"


class TcpFeed(FeedBase):
    """A client of an NMEA server (receiver, multiplexer, plotter)."""

    def __init__(self, host: str, port: int, own: str | None = None):
        super().__init__(f"NMEA 0183 from {host}:{port} (TCP)")
        self._address, self._own = (host, port), own

    async def reports(self) -> AsyncIterator[Report]:
        """The reports as they come; connects again until it is cancelled."""
        backoff = Backoff()
        while True:
            try:
                async with asyncio.timeout(CONNECT_S):
                    stream, writer = await asyncio.open_connection(*self._address)
            except OSError as error:  # asyncio's TimeoutError is one
                self.last_error = f"{self.title}: {describe_error(error, _SILENT)}"
                await backoff.wait()
                continue
            self.connected, self.last_error = True, None
            reader, lines = NmeaDecoder(self.counts, live=True, own_mmsi=self._own), LineSplitter()
            try:
                while piece := await self._piece(stream):
                    backoff.succeeded()
                    for report in reader.decode(lines.feed(piece)):
                        yield report
                    await asyncio.sleep(0)  # a fast sender leaves time for others
                for report in reader.decode(lines.end()):
                    yield report
            finally:
                self.connected = False
                reader.close()
                writer.close()
            await backoff.wait()

    async def _piece(self, stream: asyncio.StreamReader) -> bytes:
        """What comes next; nothing when the connection is over."""
        try:
            # Not wait_for: before Python 3.12 that may lose a cancellation to a fast server.
            async with asyncio.timeout(SILENT_S):
                piece = await stream.read(_PIECE)
        except OSError as error:
            self.last_error = f"{self.title}: {describe_error(error, _SILENT)}"
            return b""
        if not piece:
            self.last_error = f"{self.title}: the server closed the connection"
        return piece


class UdpFeed(FeedBase):
    """Listens for datagrams of one or more lines, from anybody who sends to the port."""

    def __init__(self, host: str, port: int, own: str | None = None):
        super().__init__(f"NMEA 0183 on {host}:{port} (UDP)")
        self._address, self._own = (host, port), own

    async def reports(self) -> AsyncIterator[Report]:
        """The reports as they come. InputError if the port cannot be listened on."""
        datagrams: asyncio.Queue[bytes] = asyncio.Queue(MAX_DATAGRAMS)
        try:
            transport, listener = await asyncio.get_running_loop().create_datagram_endpoint(
                lambda: _Listener(datagrams, self.counts), local_addr=self._address
            )
        except OSError as error:
            why = f"{self.title}: cannot listen: {describe_error(error, _SILENT)}"
            raise self.fatal_error(why) from None
        reader = NmeaDecoder(self.counts, live=True, own_mmsi=self._own)
        self.connected = True
        try:
            while True:
                datagram = await datagrams.get()
                listener.bytes -= len(datagram)
                for report in reader.decode(_lines_of(datagram)):
                    yield report
                await asyncio.sleep(0)
        finally:
            self.connected = False
            transport.close()
            reader.close()


class _Listener(asyncio.DatagramProtocol):
    def __init__(self, datagrams: asyncio.Queue[bytes], counts: Counts):
        self._datagrams, self._counts = datagrams, counts
        #: How many bytes wait.
        self.bytes = 0

    def datagram_received(self, data: bytes, addr: Any) -> None:
        if not self._datagrams.full() and self.bytes + len(data) <= MAX_QUEUED_BYTES:
            self.bytes += len(data)
            self._datagrams.put_nowait(data)
        else:
            lost = sum(1 for _ in _lines_of(data))
            self._counts.received += lost
            self._counts.reject(RejectReason.OVERRUN, lost)


class FileFeed(FeedBase):
    """A file of NMEA, packed or not, played at the times of its lines.

    ``pace`` is how many seconds of the file pass in one; it may be changed while
    playing, and ``inf`` does not wait at all. The time that passes is the one that most ships
    agree on: nobody waits for a single wrong clock, nor for hours in which the file has nothing.
    """

    def __init__(self, path: Path, own: str | None = None, pace: float = 1.0):
        super().__init__(f"NMEA 0183 from {path.name}")
        self.pace = pace
        self._path, self._own = path, own

    async def reports(self) -> AsyncIterator[Report]:
        """The reports when their time comes. InputError if the file cannot be read."""
        reader = NmeaDecoder(self.counts, live=False, own_mmsi=self._own)
        played = TrafficTime()
        self.connected = True
        try:
            for lines in self._lines():
                for report in reader.decode(lines):
                    before_s = played.latest_s
                    played.update(report.time.timestamp(), report.id)
                    if before_s is not None and played.latest_s is not None:
                        await self._pass(played.latest_s - before_s)
                    yield report
                await asyncio.sleep(0)
        finally:
            self.connected = False
            reader.close()

    async def _pass(self, seconds: float) -> None:
        """Let so many seconds of the file go by, in steps, so that a new pace is soon felt.

        A gap in the file is passed over.
        """
        if seconds > TOLERANCE_S:
            return
        while seconds > 0 and math.isfinite(self.pace):
            step = min(seconds, 0.5 * self.pace)
            await asyncio.sleep(step / self.pace)
            seconds -= step

    def _lines(self) -> Iterator[list[bytes]]:
        """The lines of the file, block by block."""
        try:
            with hide_paths(self._path.name, self._path), TextFile(self._path) as file:
                for block in file.blocks(_PIECE):
                    yield block.split(b"\n")
                self.last_error = "; ".join(file.notes) or None
        except InputError as error:
            raise self.fatal_error(str(error)) from None


def _lines_of(datagram: bytes) -> Iterator[bytes]:
    return (line for line in datagram.replace(b"\r", b"\n").split(b"\n") if line.strip())
