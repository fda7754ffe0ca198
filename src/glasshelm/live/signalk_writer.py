"""Writing the pilot's advice to Signal K: rudder target, closest approaches, notifications.

Only for whoever asked for it and has a token: other instruments on board may act on it.
"""

import asyncio
import contextlib
import logging
import time
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

import msgspec
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import WebSocketException

from glasshelm.ais.mmsi import is_number
from glasshelm.feeds.connection import Backoff, describe_error
from glasshelm.feeds.signalk_client import SignalKServer
from glasshelm.frames.schema import Frame, Target

RUDDER = "steering.rudderAngleTarget"
CLOSEST_APPROACH = "navigation.closestApproach"
SELF = "vessels.self"
#: What is published must be published again within so long [s], or it is out of date.
STALE_S = 15.0
#: What is written while closing must be written within [s].
_CLOSE_S = 2.0
#: Equal to no value: what may or may not be on the server, and what is not.
_UNKNOWN, _NOTHING = object(), object()
#: A context and a path of Signal K.
Key = tuple[str, str]
_log = logging.getLogger("glasshelm.bridge")


@runtime_checkable
class Alarm(Protocol):
    """What is published of an alarm: the ship, the cause, whether it is acknowledged."""

    @property
    def target(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def state(self) -> str: ...
    @property
    def cause(self) -> str: ...


class SignalKWriter:
    """Writes to one server.

    ``publish`` never waits: the latest values are written when ``run``, a task of its own, can
    write. After ``withdraw``, when nothing was published for ``STALE_S``, and when ``run`` ends,
    everything written is withdrawn: no advice stays behind that is out of date. What a connection
    that broke may have left on the server is withdrawn, or written anew, by the next one.
    """

    def __init__(self, server: SignalKServer):
        self.title = f"writing to Signal K at {server.address}"
        self.connected = False
        self.last_error: str | None = None
        #: How many frames were published, and how many of them were written.
        self.n_published, self.n_written = 0, 0
        self._server = server
        #: The values that the server should have, since when, and whether their frame is unwritten.
        self._wanted: dict[Key, Any] = {}
        self._wanted_at = 0.0
        self._unwritten = False
        self._changed = asyncio.Event()
        #: The values that the server may have: those written last, or ``_UNKNOWN``.
        self._on_server: dict[Key, Any] = {}
        #: Withdrawn values that the server may not have read yet.
        self._withdrawing: dict[Key, object] = {}
        self._task: asyncio.Task[Any] | None = None

    def publish(self, frame: Frame, alarms: Sequence[Alarm]) -> None:
        """Have a frame and the alarms of its instant written, in place of what is not written yet.

        Where they cannot be expressed, everything is withdrawn, and the error raised.
        """
        try:
            values = signalk_values(frame, alarms)
        except Exception:
            self.withdraw()
            raise
        self.n_published += 1
        self._unwritten = True
        self._want(values)

    def withdraw(self) -> None:
        """Have everything withdrawn: there is no current picture to publish."""
        self._unwritten = False
        self._want({})

    def _want(self, values: dict[Key, Any]) -> None:
        # A process that was killed may have left a rudder angle: replace or withdraw it.
        if self._wanted_at == 0.0:
            self._on_server.setdefault((SELF, RUDDER), _UNKNOWN)
        self._wanted, self._wanted_at = values, time.monotonic()
        self._changed.set()

    async def run(self) -> None:
        """Write what is published until cancelled; connects again, whatever has failed."""
        self._task, backoff = asyncio.current_task(), Backoff()
        try:
            while True:
                try:
                    socket = await self._server.connect("none")
                except Exception as error:
                    self._failed(error)
                else:
                    await self._use(socket, backoff)
                await backoff.wait()
        finally:
            if self._on_server:
                await self._withdraw_over_new_connection()

    async def close(self) -> None:
        """Withdraw everything for good; returns when that is done, or cannot be done in time."""
        if self._task is not None and not self._task.done():
            self._task.cancel()
            await asyncio.wait((self._task,), timeout=3 * _CLOSE_S)

    async def _use(self, socket: ClientConnection, backoff: Backoff) -> None:
        """Write for as long as the connection holds, then withdraw what it wrote."""
        self.connected, self.last_error = True, None
        try:
            await self._write_all(socket, backoff)
        except Exception as error:
            self._failed(error)
        finally:
            self.connected = False
            await self._withdraw_and_disconnect(socket)

    async def _write_all(self, socket: ClientConnection, backoff: Backoff) -> None:
        """Write what is published, and read what the server sends, while the connection holds.

        What it sends (its hello, refusals) must be read: unread, it would fill the line.
        """
        reading = asyncio.create_task(_read(socket))
        if self._on_server or self._wanted:
            self._changed.set()  # what the last connection has left, or not written
        try:
            while not reading.done():
                changed = asyncio.create_task(self._changed.wait())
                await asyncio.wait(
                    (changed, reading),
                    timeout=self._stale_in_s(),
                    return_when=asyncio.FIRST_COMPLETED,
                )
                changed.cancel()
                if self._stale_in_s() == 0.0:
                    self.withdraw()
                if reading.done() or not self._changed.is_set():
                    continue
                self._changed.clear()
                new_frame, self._unwritten = self._unwritten, False
                await self._write(socket, self._wanted)
                self.n_written += new_frame
                backoff.succeeded()
            reading.result()
        finally:
            reading.cancel()

    def _stale_in_s(self) -> float | None:
        """Seconds until the wanted values are out of date; None where there are none."""
        if not self._wanted:
            return None
        return max(self._wanted_at + STALE_S - time.monotonic(), 0.0)

    async def _write(self, socket: ClientConnection, values: Mapping[Key, Any]) -> None:
        """Write what is new or changed, and withdraw what is no longer wanted."""
        changed = {key: v for key, v in values.items() if self._on_server.get(key, _NOTHING) != v}
        gone = {key: _withdrawn(key[1]) for key in self._on_server if key not in values}
        # Sending may fail in the middle: until all is sent, any of it may be there.
        self._on_server |= dict.fromkeys(changed, _UNKNOWN)
        for delta in deltas(changed | gone):
            await socket.send(delta)
        self._on_server = dict(values)
        for key in values:
            self._withdrawing.pop(key, None)
        if gone:
            sent = object()
            self._withdrawing |= dict.fromkeys(gone, sent)
            pong = asyncio.ensure_future(await socket.ping())
            pong.add_done_callback(lambda pong: self._read_by_server(pong, sent))

    def _read_by_server(self, pong: asyncio.Future[float], sent: object) -> None:
        """The server has answered, so it has read what was sent before."""
        if not pong.cancelled() and pong.exception() is None:
            self._withdrawing = {k: at for k, at in self._withdrawing.items() if at is not sent}

    async def _withdraw_and_disconnect(self, socket: ClientConnection) -> None:
        """Withdraw everything, and see that the server reads it; remember what is not sure."""
        try:
            with contextlib.suppress(Exception):
                async with asyncio.timeout(_CLOSE_S):
                    await self._write(socket, {})
                    await (await socket.ping())
                    self._withdrawing.clear()
            with contextlib.suppress(Exception):
                async with asyncio.timeout(_CLOSE_S):
                    await socket.close()
        finally:
            self._on_server = dict.fromkeys((*self._on_server, *self._withdrawing), _UNKNOWN)
            self._withdrawing.clear()

    async def _withdraw_over_new_connection(self) -> None:
        """The last connection broke: withdraw over another one what it may have left."""
        with contextlib.suppress(Exception):
            async with asyncio.timeout(_CLOSE_S):
                socket = await self._server.connect("none")
            await self._withdraw_and_disconnect(socket)
        if self._on_server:
            _log.error("%s: what was written could not be withdrawn", self.title)

    def _failed(self, error: Exception) -> None:
        self.last_error = f"{self.title}: {describe_error(error)}"
        if not isinstance(error, OSError | WebSocketException):
            _log.error("%s failed", self.title, exc_info=error)


async def _read(socket: ClientConnection) -> None:
    while True:
        await socket.recv()


def signalk_values(frame: Frame, alarms: Sequence[Alarm]) -> dict[Key, Any]:
    """A frame and its alarms as Signal K values: context and path, and the value there."""
    values: dict[Key, Any] = {}
    if frame.decision is not None:
        values[SELF, RUDDER] = frame.decision.rudder_rad
    for target in frame.targets:
        if not target.lost and target.tcpa_s > 0 and target.id:
            values[_context(target), CLOSEST_APPROACH] = {
                "distance": target.dcpa_m,
                "timeTo": target.tcpa_s,
            }
    for alarm in alarms:
        silent = alarm.state == "acknowledged"
        # A dot in a ship's number would begin another part of the path.
        path = f"notifications.{CLOSEST_APPROACH}.{alarm.target.replace('.', '_')}"
        values[SELF, path] = {
            "state": "alarm",
            "method": ["visual"] if silent else ["visual", "sound"],
            "message": f"{alarm.name}: {alarm.cause}",
        }
    return values


def deltas(values: Mapping[Key, Any]) -> list[str]:
    """Signal K deltas, one a context; the server dates them."""
    contexts: dict[str, list[dict[str, Any]]] = {}
    for (context, path), value in values.items():
        contexts.setdefault(context, []).append({"path": path, "value": value})
    source = {"label": "glasshelm"}
    return [
        msgspec.json.encode(
            {"context": context, "updates": [{"source": source, "values": entries}]}
        ).decode()
        for context, entries in contexts.items()
    ]


def _withdrawn(path: str) -> Any:
    """A notification becomes normal, any other value unknown."""
    if path.startswith("notifications."):
        return {"state": "normal", "method": [], "message": "no longer within the limits"}
    return None


def _context(target: Target) -> str:
    number = target.id
    return f"vessels.{f'urn:mrn:imo:mmsi:{int(number):09d}' if is_number(number) else number}"
