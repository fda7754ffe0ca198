"""Signal K over its WebSocket: own ship and AIS targets, as the server has them."""

import asyncio
import contextlib
from collections.abc import AsyncIterator

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, WebSocketException

from glasshelm.ais.reports import Counts, FeedBase, RejectReason, Report
from glasshelm.ais.signalk_deltas import MAX_MESSAGE_BYTES, DeltaDecoder
from glasshelm.feeds.backoff import Backoff
from glasshelm.feeds.connection_errors import describe_error

#: A server that is silent for so long [s] is taken for gone, and connected to again.
SILENT_S = 120.0
CONNECT_S = 10.0
_TOO_BIG = 1009  # RFC 6455, 7.4.1


class _Straight(connect):
    """Goes nowhere else than to the address given: a token is for that server alone."""

    def process_redirect(self, exc: Exception) -> Exception | str:
        return exc


class SignalKServer:
    """Where a Signal K server is, and how to get in."""

    def __init__(self, host: str, port: int, tls: bool = False, token: str | None = None):
        at = f"[{host}]" if ":" in host else host
        self.address = f"{at}:{port}"
        self._url = f"{'wss' if tls else 'ws'}://{self.address}/signalk/v1/stream?subscribe="
        self._token = token

    def connect(self, subscribe: str) -> connect:
        """A connection to open; ``subscribe`` is ``all`` or ``none``."""
        headers = {"Authorization": f"Bearer {self._token}"} if self._token else None
        return _Straight(
            self._url + subscribe,
            additional_headers=headers,
            max_size=MAX_MESSAGE_BYTES,
            open_timeout=CONNECT_S,
            close_timeout=1.0,
            proxy=None,  # a boat's own network
        )


class SignalKFeed(FeedBase):
    """A client of a Signal K server: everything it has of vessels, each delta as it came to it."""

    def __init__(self, server: SignalKServer, own: str | None = None):
        super().__init__(f"Signal K at {server.address}", Counts("messages"))
        self._server, self._own = server, own

    async def reports(self) -> AsyncIterator[Report]:
        """The reports as they come; connects again until it is cancelled."""
        backoff, reader = Backoff(), DeltaDecoder(self.counts, self._own)
        while True:
            try:
                socket = await self._server.connect("all")
            except (OSError, WebSocketException) as error:
                self.last_error = f"{self.title}: {describe_error(error)}"
                await backoff.wait()
                continue
            self.connected, self.last_error = True, None
            try:
                while (message := await self._message(socket)) is not None:
                    backoff.succeeded()
                    for report in reader.decode(message):
                        yield report
                    await asyncio.sleep(0)  # a fast server leaves time for others
            finally:
                self.connected = False
                with contextlib.suppress(OSError, WebSocketException):
                    await socket.close()
            await backoff.wait()

    async def _message(self, socket: ClientConnection) -> str | bytes | None:
        """What comes next; None when the connection is over."""
        try:
            # Not wait_for: before Python 3.12 that may lose a cancellation to a fast server.
            async with asyncio.timeout(SILENT_S):
                return await socket.recv(decode=False)
        except ConnectionClosed as error:
            if error.sent is not None and error.sent.code == _TOO_BIG:
                self.counts.received += 1
                self.counts.reject(RejectReason.TOO_LONG)
            self.last_error = f"{self.title}: {describe_error(error)}"
        except (OSError, WebSocketException) as error:
            self.last_error = f"{self.title}: {describe_error(error)}"
        return None
