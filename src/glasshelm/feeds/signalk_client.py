"""Signal K over its WebSocket: own ship and AIS targets, as the server has them."""

import contextlib

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, WebSocketException

from glasshelm.ais.reports import Counts, RejectReason, Report
from glasshelm.ais.signalk_deltas import MAX_MESSAGE_BYTES, DeltaDecoder
from glasshelm.feeds.client_feed import ClientFeed
from glasshelm.feeds.connection import CONNECT_S

_TOO_BIG = 1009  # RFC 6455, 7.4.1


class _NoRedirect(connect):
    """Connects to the given address alone: a token is for that server only."""

    def process_redirect(self, exc: Exception) -> Exception | str:
        return exc


class SignalKServer:
    """The address of a Signal K server, and the token that it wants."""

    def __init__(self, host: str, port: int, tls: bool = False, token: str | None = None):
        at = f"[{host}]" if ":" in host else host
        self.address = f"{at}:{port}"
        self._url = f"{'wss' if tls else 'ws'}://{self.address}/signalk/v1/stream?subscribe="
        self._token = token

    def connect(self, subscribe: str) -> connect:
        """A connection to open; ``subscribe`` is ``all`` or ``none``."""
        headers = {"Authorization": f"Bearer {self._token}"} if self._token else None
        return _NoRedirect(
            self._url + subscribe,
            additional_headers=headers,
            max_size=MAX_MESSAGE_BYTES,
            open_timeout=CONNECT_S,
            close_timeout=1.0,
            proxy=None,  # a boat's own network
        )


class SignalKFeed(ClientFeed):
    """A client of a Signal K server: all its vessels, each delta as it came to the server."""

    def __init__(self, server: SignalKServer, own_mmsi: str | None = None):
        super().__init__(f"Signal K at {server.address}", Counts("messages"))
        self._server = server
        self._decoder = DeltaDecoder(self.counts, own_mmsi)

    async def _connect(self) -> ClientConnection:
        return await self._server.connect("all")

    async def _receive(self, connection: ClientConnection) -> bytes:
        try:
            return await connection.recv(decode=False)
        except ConnectionClosed as error:
            if error.sent is not None and error.sent.code == _TOO_BIG:
                self.counts.received += 1
                self.counts.reject(RejectReason.TOO_LONG)
            raise

    def _decode(self, piece: str | bytes) -> list[Report]:
        return self._decoder.decode(piece)

    async def _disconnect(self, connection: ClientConnection) -> None:
        with contextlib.suppress(OSError, WebSocketException):
            await connection.close()
