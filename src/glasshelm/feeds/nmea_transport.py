"""NMEA 0183 from where it comes: a TCP server, UDP datagrams, a file."""

import asyncio
import math
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

from glasshelm.ais.files import TextFile
from glasshelm.ais.nmea_decoder import NmeaDecoder
from glasshelm.ais.nmea_sentence import LineSplitter
from glasshelm.ais.reports import Counts, Feed, RejectReason, Report
from glasshelm.ais.traffic_time import TOLERANCE_S, TrafficTime
from glasshelm.core.errors import InputError, hide_paths
from glasshelm.feeds.client_feed import ClientFeed
from glasshelm.feeds.connection import CONNECT_S, describe_error

#: Datagrams that may wait to be read, ...
MAX_DATAGRAMS = 4096
#: ... and their size together.
MAX_QUEUED_BYTES = 1 << 24
#: So much is read in one turn of the event loop [bytes]: some 150 lines.
_PIECE = 8192

_Connection = tuple[asyncio.StreamReader, asyncio.StreamWriter]


class TcpFeed(ClientFeed):
    """A client of an NMEA server (receiver, multiplexer, plotter)."""

    def __init__(self, host: str, port: int, own_mmsi: str | None = None):
        super().__init__(f"NMEA 0183 from {host}:{port} (TCP)")
        self._address, self._own_mmsi = (host, port), own_mmsi

    async def _connect(self) -> _Connection:
        async with asyncio.timeout(CONNECT_S):
            connection = await asyncio.open_connection(*self._address)
        self._decoder = NmeaDecoder(self.counts, live=True, own_mmsi=self._own_mmsi)
        self._lines = LineSplitter()
        return connection

    async def _receive(self, connection: _Connection) -> bytes | None:
        piece = await connection[0].read(_PIECE)
        if not piece:
            self.last_error = f"{self.title}: the server closed the connection"
        return piece or None

    def _decode(self, piece: bytes) -> Iterator[Report]:
        return self._decoder.decode(self._lines.feed(piece))

    def _decode_rest(self) -> Iterator[Report]:
        return self._decoder.decode(self._lines.close())

    async def _disconnect(self, connection: _Connection) -> None:
        self._decoder.close()
        connection[1].close()

    def _failed(self, error: Exception) -> None:
        self.last_error = f"{self.title}: {describe_error(error, 'nothing comes')}"


class UdpFeed(Feed):
    """Listens for datagrams of one or more lines, from any sender."""

    def __init__(self, host: str, port: int, own_mmsi: str | None = None):
        super().__init__(f"NMEA 0183 on {host}:{port} (UDP)")
        self._address, self._own_mmsi = (host, port), own_mmsi

    async def reports(self) -> AsyncIterator[Report]:
        """The reports as they come. InputError if the port cannot be listened on."""
        datagrams: asyncio.Queue[bytes] = asyncio.Queue(MAX_DATAGRAMS)
        try:
            transport, listener = await asyncio.get_running_loop().create_datagram_endpoint(
                lambda: _Listener(datagrams, self.counts), local_addr=self._address
            )
        except OSError as error:
            message = f"{self.title}: cannot listen: {describe_error(error)}"
            raise self.fatal_error(message) from None
        decoder = NmeaDecoder(self.counts, live=True, own_mmsi=self._own_mmsi)
        self.connected = True
        try:
            while True:
                datagram = await datagrams.get()
                listener.queued_bytes -= len(datagram)
                for report in decoder.decode(_split_datagram(datagram)):
                    yield report
                await asyncio.sleep(0)
        finally:
            self.connected = False
            transport.close()
            decoder.close()


class _Listener(asyncio.DatagramProtocol):
    def __init__(self, datagrams: asyncio.Queue[bytes], counts: Counts):
        self._datagrams, self._counts = datagrams, counts
        self.queued_bytes = 0

    def datagram_received(self, data: bytes, addr: Any) -> None:
        if not self._datagrams.full() and self.queued_bytes + len(data) <= MAX_QUEUED_BYTES:
            self.queued_bytes += len(data)
            self._datagrams.put_nowait(data)
        else:
            lost = sum(1 for _ in _split_datagram(data))
            self._counts.received += lost
            self._counts.reject(RejectReason.OVERRUN, lost)


def _split_datagram(datagram: bytes) -> Iterator[bytes]:
    return (line for line in datagram.replace(b"\r", b"\n").split(b"\n") if line.strip())


class FileFeed(Feed):
    """A file of NMEA, packed or not, played at the times of its lines.

    ``pace`` is how many seconds of the file pass in one; it may change while the file is
    played, and ``inf`` does not wait at all. The time that passes is the one that most ships
    agree on: a single wrong clock, or hours in which the file has nothing, are not waited for.
    """

    def __init__(self, path: Path, own_mmsi: str | None = None, pace: float = 1.0):
        super().__init__(f"NMEA 0183 from {path.name}")
        self.pace = pace
        self._path, self._own_mmsi = path, own_mmsi

    async def reports(self) -> AsyncIterator[Report]:
        """The reports when their time comes. InputError if the file cannot be read."""
        decoder = NmeaDecoder(self.counts, live=False, own_mmsi=self._own_mmsi)
        played = TrafficTime()
        self.connected = True
        try:
            for lines in self._read_blocks():
                for report in decoder.decode(lines):
                    before_s = played.latest_s
                    played.update(report.time.timestamp(), report.id)
                    if before_s is not None and played.latest_s is not None:
                        await self._wait(played.latest_s - before_s)
                    yield report
                await asyncio.sleep(0)
        finally:
            self.connected = False
            decoder.close()

    async def _wait(self, seconds: float) -> None:
        """Let so many seconds of the file pass, in steps, so that a new pace takes effect soon.

        A gap in the file is passed over.
        """
        if seconds > TOLERANCE_S:
            return
        while seconds > 0 and math.isfinite(self.pace):
            step = min(seconds, 0.5 * self.pace)
            await asyncio.sleep(step / self.pace)
            seconds -= step

    def _read_blocks(self) -> Iterator[list[bytes]]:
        """The lines of the file, block by block."""
        try:
            with hide_paths(self._path.name, self._path), TextFile(self._path) as file:
                for block in file.blocks(_PIECE):
                    yield block.split(b"\n")
                self.last_error = "; ".join(file.notes) or None
        except InputError as error:
            raise self.fatal_error(str(error)) from None
