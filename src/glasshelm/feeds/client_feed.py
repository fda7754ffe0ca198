"""A feed from a server: connects, and connects again whenever the connection is lost."""

import asyncio
from collections.abc import AsyncIterator, Iterator
from typing import Any

from websockets.exceptions import WebSocketException

from glasshelm.ais.reports import Feed, Report
from glasshelm.feeds.connection import SILENT_S, Backoff, describe_error


class ClientFeed(Feed):
    """Subclasses say how to connect, receive, decode and disconnect."""

    async def reports(self) -> AsyncIterator[Report]:
        """The reports as they come, until cancelled."""
        backoff = Backoff()
        while True:
            try:
                connection = await self._connect()
            except (OSError, WebSocketException) as error:  # TimeoutError is an OSError
                self._failed(error)
                await backoff.wait()
                continue
            self.connected, self.last_error = True, None
            try:
                while (piece := await self._receive_within_limit(connection)) is not None:
                    backoff.succeeded()
                    for report in self._decode(piece):
                        yield report
                    await asyncio.sleep(0)  # a fast sender leaves time for others
                for report in self._decode_rest():
                    yield report
            finally:
                self.connected = False
                await self._disconnect(connection)
            await backoff.wait()

    async def _connect(self) -> Any:
        raise NotImplementedError

    async def _receive(self, connection: Any) -> str | bytes | None:
        """What comes next; None when the connection is over."""
        raise NotImplementedError

    def _decode(self, piece: Any) -> Iterator[Report] | list[Report]:
        raise NotImplementedError

    def _decode_rest(self) -> Iterator[Report] | list[Report]:
        """The reports of what was left when the connection ended."""
        return []

    async def _disconnect(self, connection: Any) -> None:
        raise NotImplementedError

    async def _receive_within_limit(self, connection: Any) -> str | bytes | None:
        try:
            # Not wait_for: before Python 3.12 that may lose a cancellation to a fast server.
            async with asyncio.timeout(SILENT_S):
                return await self._receive(connection)
        except (OSError, WebSocketException) as error:
            self._failed(error)
            return None

    def _failed(self, error: Exception) -> None:
        self.last_error = f"{self.title}: {describe_error(error)}"
